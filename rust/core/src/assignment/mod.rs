//! Who is matched with whom, at the least total cost.

pub mod dense;
