//! Counts of positive numbers in bins that grow with them: what quantiles over runs are read from.
//!
//! Counts are whole numbers, so that they add up the same in every order. Each octave from 2^-20 to
//! 2^28 has eight bins of equal width, which are the first bits of the number itself; below and above
//! stand one bin each.

use crate::error::{Error, Result};

/// Bins of each octave, as a number of bits.
const PARTS: u32 = 3;
const LOWEST: i64 = (1023 - 20) << PARTS;
const HIGHEST: i64 = (1023 + 28) << PARTS;

/// How many bins there are, with the one below and the one above.
pub const BINS: usize = (HIGHEST - LOWEST) as usize + 2;

/// The bin of a number that is not NaN.
#[inline]
pub fn bin(x: f64) -> usize {
    let leading = (x.to_bits() as i64) >> (52 - PARTS);
    (leading.clamp(LOWEST - 1, HIGHEST) - LOWEST + 1) as usize
}

/// Counts of every column of `values`, runs by columns; NaN is not counted.
///
/// # Errors
/// [`Error::Length`] where `values` are not whole runs.
pub fn histograms(values: &[f64], columns: usize) -> Result<Vec<i64>> {
    let mut counts = vec![0; columns * BINS];
    let rows = values.chunks_exact(columns.max(1));
    if !rows.remainder().is_empty() || (columns == 0 && !values.is_empty()) {
        let (argument, other, unit) = ("values", "whole runs", "numbers");
        let (found, expected) = (values.len(), values.len() - rows.remainder().len());
        return Err(Error::Length { argument, found, other, expected, unit });
    }
    for row in rows {
        for (&x, counts) in row.iter().zip(counts.chunks_exact_mut(BINS)) {
            if !x.is_nan() {
                counts[bin(x)] += 1;
            }
        }
    }
    Ok(counts)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn bins_rise_with_the_number() {
        assert_eq!(bin(0.0), 0);
        assert_eq!(bin(-1.0), 0);
        assert_eq!(bin(1e-300), 0);
        assert_eq!(bin(f64::INFINITY), BINS - 1);
        assert_eq!(bin(1.0), 161);
        assert_eq!(bin(1.125), 162);
        assert_eq!(bin(1.0f64.next_down()), 160);
        assert_eq!(bin(2f64.powi(28).next_down()), BINS - 2);
        assert_eq!(bin(2f64.powi(-20)), 1);
    }
}
