//! Distances between finite sets of points.
//!
//! The route of a call of [`ospa::ospa`], the first line that applies:
//!
//! | case | file |
//! | --- | --- |
//! | one set is empty | `ospa` |
//! | p is infinite, or powers leave the range of floats | `scaled_ospa` (with `assignment::bottleneck`) |
//! | at most three points on the smaller side | `tiny` |
//! | many points, few of them closer than c | `cell_grid` finds the pairs, `sparse_matching` matches them |
//! | otherwise | `rows` finds each point's nearest, `gated_matching` solves what conflicts |
//!
//! Where pairs are returned (GOSPA, `ospa_assignment`), `unique` says whether the matching is the only
//! one; if not, `assignment_order` finds SciPy's. Distances come through the trait in `cost_source`.

mod assignment_order;
mod cell_grid;
pub mod cost_source;
pub mod cutoff;
pub mod distances;
mod gated_matching;
pub mod gospa;
pub mod ospa;
pub mod results;
mod rows;
mod scaled_ospa;
mod sparse_matching;
mod tiny;
mod unique;
pub mod workspace;
