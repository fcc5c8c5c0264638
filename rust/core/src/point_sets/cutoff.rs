//! What a distance between two points costs: `min(d, c)^p`.
//!
//! Whether `d >= c` is decided before anything is raised to a power: `c^p` and `d^p` round
//! differently, and a pair at the cutoff would change sides by one unit in the last place.
//! Distances come as squares where they can, so that even orders need no root and integer
//! coordinates give integer costs.

use crate::error::{Error, Result};

/// Order and cutoff, checked, with what every cost needs of them.
#[derive(Debug, Clone, Copy)]
pub struct Cutoff {
    c: f64,
    p: f64,
    power: Power,
    square: f64,
    most: f64,
}

/// How a power is computed.
#[derive(Debug, Clone, Copy, PartialEq)]
pub(crate) enum Power {
    /// The distance itself.
    One,
    /// The square itself.
    Two,
    /// The square, raised to a whole power by products.
    Even(u32),
    /// Anything else.
    Any,
}

/// Smallest order of OSPA: below it the root of a mean of powers keeps too few digits.
const LEAST_ORDER: f64 = 1e-3;
/// Even orders up to this one are raised by products.
const LARGEST_EVEN: f64 = 64.0;

impl Cutoff {
    /// Order `p`, at least 0.001, and cutoff `c`, positive; each may be infinite.
    ///
    /// # Errors
    /// [`Error::Parameter`] for NaN, for what is not positive and for orders too small.
    pub fn new(c: f64, p: f64) -> Result<Self> {
        for (argument, value) in [("c", c), ("p", p)] {
            if value.is_nan() || value <= 0.0 {
                return Err(Error::Parameter { argument, requirement: "positive", value });
            }
        }
        if p < LEAST_ORDER {
            let requirement = "at least 0.001";
            return Err(Error::Parameter { argument: "p", requirement, value: p });
        }
        let power = match p {
            1.0 => Power::One,
            2.0 => Power::Two,
            p if p <= LARGEST_EVEN && p % 2.0 == 0.0 => Power::Even((p / 2.0) as u32),
            _ => Power::Any,
        };
        let mut cutoff = Self { c, p, power, square: first_square_at(c), most: 0.0 };
        cutoff.most = match power {
            Power::One | Power::Any => cutoff.raise(c),
            Power::Two | Power::Even(_) => cutoff.raise_square(c * c),
        };
        Ok(cutoff)
    }

    /// The cutoff.
    #[inline]
    pub fn c(&self) -> f64 {
        self.c
    }

    /// The order.
    #[inline]
    pub fn p(&self) -> f64 {
        self.p
    }

    /// The cost of a pair at the cutoff or beyond, and of a point that stays alone: `c^p`.
    #[inline]
    pub fn most(&self) -> f64 {
        self.most
    }

    /// The smallest squared distance that is at the cutoff or beyond.
    #[inline]
    pub(crate) fn square(&self) -> f64 {
        self.square
    }

    #[inline]
    pub(crate) fn power(&self) -> Power {
        self.power
    }

    /// Whether squared distances can be told from the cutoff's square: it neither leaves the range
    /// of floats nor loses digits at the end of it.
    #[inline]
    pub(crate) fn has_square(&self) -> bool {
        self.c == f64::INFINITY || (1e-290..1e290).contains(&(self.c * self.c))
    }

    /// `d^p` for a distance, `c^p` from the cutoff on.
    #[inline]
    pub fn cost(&self, distance: f64) -> f64 {
        if distance >= self.c { self.most } else { self.raise(distance) }
    }

    /// The same for the square of a distance.
    #[inline]
    pub(crate) fn cost_of_square(&self, square: f64) -> f64 {
        if square >= self.square { self.most } else { self.raise_square(square) }
    }

    #[inline]
    fn raise(&self, distance: f64) -> f64 {
        match self.power {
            Power::One => distance,
            Power::Two | Power::Even(_) => self.raise_square(distance * distance),
            Power::Any => distance.powf(self.p),
        }
    }

    #[inline]
    fn raise_square(&self, square: f64) -> f64 {
        match self.power {
            Power::One => square.sqrt(),
            Power::Two => square,
            Power::Even(half) => (1..half).fold(square, |product, _| product * square),
            Power::Any => square.sqrt().powf(self.p),
        }
    }

    /// `sum^(1/p)`.
    #[inline]
    pub fn root(&self, sum: f64) -> f64 {
        match self.power {
            Power::One => sum,
            Power::Two => sum.sqrt(),
            _ => sum.powf(1.0 / self.p),
        }
    }
}

/// The smallest float whose square root, rounded, is at least `c`.
fn first_square_at(c: f64) -> f64 {
    let mut square = c * c;
    while square > 0.0 && square.next_down().sqrt() >= c {
        square = square.next_down();
    }
    while square.sqrt() < c {
        square = square.next_up();
    }
    square
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn squares_and_distances_fall_on_the_same_side() {
        let mut c = 1e-3;
        while c < 1e6 {
            let cutoff = Cutoff::new(c, 3.0).unwrap();
            let square = cutoff.square();
            assert!(square.sqrt() >= c && square.next_down().sqrt() < c, "{c}");
            c *= 1.0137;
        }
    }

    #[test]
    fn even_orders_of_integers_are_exact() {
        let cutoff = Cutoff::new(10.0, 4.0).unwrap();
        assert_eq!(cutoff.cost_of_square(2.0), 4.0);
        assert_eq!(cutoff.cost_of_square(99.0), 9801.0);
        assert_eq!(cutoff.cost_of_square(100.0), 10_000.0);
        assert_eq!(cutoff.most(), 10_000.0);
    }

    #[test]
    fn what_is_not_positive_is_named() {
        for (c, p, text) in [
            (0.0, 1.0, "c must be positive, got 0.0"),
            (f64::NAN, 0.0, "c must be positive, got nan"),
            (1.0, -2.0, "p must be positive, got -2.0"),
        ] {
            assert_eq!(Cutoff::new(c, p).unwrap_err().to_string(), text);
        }
        assert!(Cutoff::new(f64::INFINITY, f64::INFINITY).is_ok());
    }
}
