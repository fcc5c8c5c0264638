//! Which state an error sits in: the Shapley split of e' P^-1 e.
//!
//! The states play a game in which a coalition S earns v(S) = e_S' P_SS^-1 e_S, the squared error
//! that these states alone show; v never falls as states join, and v(all) is the NEES. The share of
//! a state is its mean contribution over all orders in which the states can join: the shares add up
//! to the NEES, and for a consistent filter each is 1 on average. Shapley (1953),
//! doi:10.1515/9781400881970-018.
//!
//! A state that joins S adds the square of its error, whitened against S: one more row of the
//! Cholesky factor. Exactly, over all 2^d coalitions in a walk that shares factors, d^2 2^d
//! operations; or over given orders, d^3 / 6 each.

use crate::error::{Error, Result};
use crate::threads;

/// Above this many states the exact split is refused.
pub const MOST_STATES: usize = 16;

/// The shares of the states in each of many errors, exactly.
///
/// # Errors
/// If there are more than [`MOST_STATES`] states, something is not finite, sizes do not fit, or a
/// covariance is not positive definite.
pub fn shapley_shares(errors: &[f64], covariances: &[f64], dimension: usize) -> Result<Vec<f64>> {
    if dimension > MOST_STATES {
        let value = dimension as f64;
        return Err(Error::Parameter { argument: "dimension", requirement: "at most 16", value });
    }
    each(errors, covariances, dimension, |index, game, shares| {
        let mut worth = vec![0.0; 1 << dimension];
        Walk { game, index, worth: &mut worth, factor: Factor::new(dimension) }.from(0, 0)?;
        split(&worth, dimension, shares);
        Ok(())
    })
}

/// The shares of the states in each of many errors, as the mean over given orders of joining: rows
/// of `orders`, each a permutation of 0 to `dimension` - 1.
///
/// # Errors
/// If there is no order, a row is no permutation, something is not finite, sizes do not fit, or a
/// covariance is not positive definite.
pub fn sampled_shapley_shares(
    errors: &[f64],
    covariances: &[f64],
    dimension: usize,
    orders: &[i64],
) -> Result<Vec<f64>> {
    let orders = permutations(orders, dimension)?;
    each(errors, covariances, dimension, |index, game, shares| {
        let mut factor = Factor::new(dimension);
        for order in orders.chunks(dimension) {
            for (joined, &state) in order.iter().enumerate() {
                shares[state] += factor.join(&game, joined, state, index)?;
            }
        }
        let count = (orders.len() / dimension) as f64;
        shares.iter_mut().for_each(|share| *share /= count);
        Ok(())
    })
}

fn permutations(orders: &[i64], dimension: usize) -> Result<Vec<usize>> {
    let wrong = |value: i64| Error::Parameter {
        argument: "orders",
        requirement: "permutations of the states",
        value: value as f64,
    };
    if dimension == 0 || orders.is_empty() || !orders.len().is_multiple_of(dimension) {
        return Err(wrong(orders.first().copied().unwrap_or(0)));
    }
    for order in orders.chunks(dimension) {
        let mut seen = vec![false; dimension];
        for &state in order {
            let place = usize::try_from(state).ok().and_then(|s| seen.get_mut(s));
            match place {
                Some(seen) if !*seen => *seen = true,
                _ => return Err(wrong(state)),
            }
        }
    }
    Ok(orders.iter().map(|&state| state as usize).collect())
}

/// One error and its covariance.
#[derive(Clone, Copy)]
struct Game<'a> {
    error: &'a [f64],
    covariance: &'a [f64],
}

fn each<F>(errors: &[f64], covariances: &[f64], dimension: usize, share: F) -> Result<Vec<f64>>
where
    F: Fn(usize, Game<'_>, &mut [f64]) -> Result<()> + Sync,
{
    let d = dimension;
    let count = errors.len().checked_div(d).unwrap_or(0);
    check(errors, covariances, d, count)?;
    let mut shares = vec![vec![0.0; d]; count];
    threads::fill(&mut shares, 64, |first, piece| {
        for (i, shares) in piece.iter_mut().enumerate() {
            let k = first + i;
            let error = &errors[k * d..(k + 1) * d];
            let covariance = &covariances[k * d * d..(k + 1) * d * d];
            share(k, Game { error, covariance }, shares)?;
        }
        Ok(())
    })?;
    Ok(shares.concat())
}

fn check(errors: &[f64], covariances: &[f64], d: usize, count: usize) -> Result<()> {
    if covariances.len() != count * d * d || errors.len() != count * d {
        let (found, expected) = (covariances.len() / (d * d).max(1), count);
        let unit = "matrices";
        return Err(Error::Length {
            argument: "covariances",
            found,
            other: "errors",
            expected,
            unit,
        });
    }
    for (argument, values, size) in [("errors", errors, d), ("covariances", covariances, d * d)] {
        if let Some(i) = values.iter().position(|v| !v.is_finite()) {
            return Err(Error::NotFinite { argument, index: vec![i / size], value: values[i] });
        }
    }
    Ok(())
}

/// A Cholesky factor that grows by one row as a state joins, and the whitened errors.
struct Factor {
    dimension: usize,
    rows: Vec<f64>,
    states: Vec<usize>,
    whitened: Vec<f64>,
}

impl Factor {
    fn new(dimension: usize) -> Self {
        let d = dimension;
        Self { dimension, rows: vec![0.0; d * d], states: vec![0; d], whitened: vec![0.0; d] }
    }

    /// Lets `state` join the first `joined` states; what it adds.
    fn join(&mut self, game: &Game<'_>, joined: usize, state: usize, index: usize) -> Result<f64> {
        let d = self.dimension;
        let (above, row) = self.rows.split_at_mut(joined * d);
        let mut pivot = game.covariance[state * d + state];
        let mut residual = game.error[state];
        for k in 0..joined {
            let other = &above[k * d..k * d + k + 1];
            let mut element = game.covariance[state * d + self.states[k]];
            for l in 0..k {
                element -= row[l] * other[l];
            }
            row[k] = element / other[k];
            pivot -= row[k] * row[k];
            residual -= row[k] * self.whitened[k];
        }
        if pivot <= 0.0 {
            let (argument, index, minor) = ("covariances", vec![index], joined + 1);
            return Err(Error::NotPositiveDefinite { argument, index, minor });
        }
        row[joined] = pivot.sqrt();
        self.states[joined] = state;
        self.whitened[joined] = residual / row[joined];
        Ok(self.whitened[joined] * self.whitened[joined])
    }
}

/// A walk over all coalitions, each extended by states of a higher index only.
struct Walk<'a> {
    game: Game<'a>,
    index: usize,
    worth: &'a mut [f64],
    factor: Factor,
}

impl Walk<'_> {
    fn from(&mut self, coalition: usize, joined: usize) -> Result<()> {
        let next = (usize::BITS - coalition.leading_zeros()) as usize;
        for state in next..self.factor.dimension {
            let gain = self.factor.join(&self.game, joined, state, self.index)?;
            let larger = coalition | 1 << state;
            self.worth[larger] = self.worth[coalition] + gain;
            self.from(larger, joined + 1)?;
        }
        Ok(())
    }
}

/// Shares from the worth of every coalition.
fn split(worth: &[f64], d: usize, shares: &mut [f64]) {
    let weights = weights(d);
    for (coalition, value) in worth.iter().enumerate() {
        let size = coalition.count_ones() as usize;
        for (state, share) in shares.iter_mut().enumerate() {
            if coalition & 1 << state == 0 {
                *share += weights[size] * (worth[coalition | 1 << state] - value);
            }
        }
    }
}

/// k! (d - k - 1)! / d! for coalitions of k states.
fn weights(d: usize) -> Vec<f64> {
    let mut weights = vec![1.0 / (d.max(1) as f64); d.max(1)];
    for k in 1..d {
        weights[k] = weights[k - 1] * k as f64 / (d - k) as f64;
    }
    weights
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn states_that_are_independent_keep_their_own_squares() {
        let shares = shapley_shares(&[1.0, 2.0, 3.0], &[1., 0., 0., 0., 4., 0., 0., 0., 1.], 3);
        for (share, expected) in shares.unwrap().iter().zip([1.0, 1.0, 9.0]) {
            assert!((share - expected).abs() < 1e-14);
        }
    }

    #[test]
    fn all_orders_give_the_exact_shares() {
        let (error, p) = ([1.0, -2.0], [2.0, 0.9, 0.9, 1.0]);
        let exact = shapley_shares(&error, &p, 2).unwrap();
        let orders = sampled_shapley_shares(&error, &p, 2, &[0, 1, 1, 0]).unwrap();
        assert!(exact.iter().zip(&orders).all(|(a, b)| (a - b).abs() < 1e-13));
    }

    #[test]
    fn wrong_arguments_are_named() {
        let error = |result: Result<Vec<f64>>| result.unwrap_err().to_string();
        let indefinite = [1.0, 2.0, 2.0, 1.0];
        assert!(error(shapley_shares(&[1.0; 2], &indefinite, 2)).contains("leading minor 2"));
        assert!(error(shapley_shares(&[1.0; 2], &[1.0], 2)).contains("covariances has"));
        assert!(error(shapley_shares(&[], &[], 17)).contains("at most 16"));
        for orders in [&[0, 0][..], &[0], &[0, 2], &[]] {
            assert!(sampled_shapley_shares(&[1.0; 2], &[1., 0., 0., 1.], 2, orders).is_err());
        }
    }
}
