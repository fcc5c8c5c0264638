//! What the metrics of point sets give back.

/// A row and a column.
pub type Pair = (usize, usize);

/// OSPA and the two parts it is made of: `ospa^p = localization^p + cardinality^p`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ospa {
    /// The distance, in the points' unit.
    pub distance: f64,
    /// The part due to the distances of matched points.
    pub localization: f64,
    /// The part due to the difference in cardinality.
    pub cardinality: f64,
}

/// GOSPA with its parts and counts.
#[derive(Debug, Clone, Copy, Default, PartialEq)]
pub struct Gospa {
    /// The distance, in the points' unit.
    pub distance: f64,
    /// The sum of d^p over the pairs.
    pub localization: f64,
    /// c^p / 2 for each point of the truth without a partner.
    pub missed: f64,
    /// c^p / 2 for each estimate without a partner.
    pub false_alarms: f64,
    /// How many points of the truth have no partner.
    pub missed_count: usize,
    /// How many estimates have no partner.
    pub false_count: usize,
}
