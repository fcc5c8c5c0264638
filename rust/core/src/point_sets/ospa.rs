//! The Optimal Sub-Pattern Assignment distance between two finite sets of points.
//!
//! For sets of m <= n points, order p and cutoff c, with d the Euclidean distance,
//!
//! ```text
//! OSPA = ( ( min over assignments  sum_i min(d_i, c)^p  +  c^p (n - m) ) / n )^(1/p)
//! ```
//!
//! Schuhmacher, Vo and Vo, "A consistent metric for performance evaluation of multi-object
//! filters", IEEE Trans. Signal Processing 56(8), 2008, doi:10.1109/TSP.2008.920469.
//!
//! Two empty sets are at distance 0; an empty and a non-empty one at distance c.

use crate::assignment::dense;
use crate::error::{Error, Result};
use crate::points::Points;

/// OSPA and the two parts it is made of: `ospa^p = localization^p + cardinality^p`.
#[derive(Debug, Clone, Copy, PartialEq)]
pub struct Ospa {
    /// The distance, in the points' unit.
    pub distance: f64,
    /// The part owed to the distances of matched points.
    pub localization: f64,
    /// The part owed to the difference in cardinality.
    pub cardinality: f64,
}

/// What OSPA of one frame needs and the next frame can use again.
#[derive(Debug, Default)]
pub struct Workspace {
    costs: Vec<f64>,
    assignment: dense::Workspace,
}

/// OSPA of order `p` and cutoff `c` between two sets.
///
/// # Errors
/// [`Error::Parameter`] for a cutoff or an order that is not positive, [`Error::Dimension`] for
/// points of different dimensions.
pub fn ospa(x: Points, y: Points, c: f64, p: f64, work: &mut Workspace) -> Result<Ospa> {
    check_parameters(c, p)?;
    check_dimensions(x, y)?;
    let (n, m) = (x.len().max(y.len()), x.len().min(y.len()));
    if n == 0 {
        return Ok(Ospa { distance: 0.0, localization: 0.0, cardinality: 0.0 });
    }
    if m == 0 {
        return Ok(Ospa { distance: c, localization: 0.0, cardinality: c });
    }
    work.costs.clear();
    for i in 0..x.len() {
        let a = x.point(i);
        work.costs.extend((0..y.len()).map(|j| {
            let square: f64 = a.iter().zip(y.point(j)).map(|(a, b)| (a - b) * (a - b)).sum();
            let d = square.sqrt();
            if d >= c { c.powf(p) } else { d.powf(p) }
        }));
    }
    let columns = dense::solve(&work.costs, x.len(), y.len(), &mut work.assignment)?;
    let total: f64 = columns
        .iter()
        .enumerate()
        .filter(|(_, j)| **j < y.len())
        .map(|(i, &j)| work.costs[i * y.len() + j])
        .sum();
    let missing = c.powf(p) * (n - m) as f64;
    let root = |sum: f64| (sum / n as f64).powf(1.0 / p);
    Ok(Ospa {
        distance: root(total + missing),
        localization: root(total),
        cardinality: root(missing),
    })
}

fn check_parameters(c: f64, p: f64) -> Result<()> {
    for (argument, value) in [("c", c), ("p", p)] {
        if value.is_nan() || value <= 0.0 {
            return Err(Error::Parameter { argument, requirement: "positive", value });
        }
    }
    Ok(())
}

fn check_dimensions(x: Points, y: Points) -> Result<()> {
    let (expected, found) = (x.dimension(), y.dimension());
    if x.is_empty() || y.is_empty() || found == expected {
        return Ok(());
    }
    Err(Error::Dimension { argument: "Y", index: vec![0], found, expected })
}
