//! What a search for changes of scale finds.

/// The best partitions of one sequence, by number of segments.
#[derive(Debug, Clone, Default, PartialEq)]
pub struct Partitions {
    /// What each has over one segment; -infinity where the sequence is too short.
    pub gains: Vec<f64>,
    /// Of each, where its second and later segments begin.
    pub cuts: Vec<Vec<usize>>,
}
