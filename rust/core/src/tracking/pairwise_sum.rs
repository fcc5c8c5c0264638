//! Sums in NumPy's order, so that sums that differ by rounding only tie as they do there.
//!
//! NumPy adds up to 7 numbers one after another, up to 128 in eight partial sums, and halves what is
//! longer.

const LANES: usize = 8;
const BLOCK: usize = 128;

/// The sum of a row.
pub(super) fn pairwise_sum(values: &[f64]) -> f64 {
    if values.len() < LANES {
        return values.iter().sum();
    }
    let entries: Vec<(usize, f64)> = values.iter().copied().enumerate().collect();
    sparse_pairwise_sum(&entries, 0, values.len())
}

/// The sum of a row of `length` numbers from place `first` on, of which all but these entries are 0.
/// The entries are in rising order of their places.
pub(super) fn sparse_pairwise_sum(entries: &[(usize, f64)], first: usize, length: usize) -> f64 {
    if entries.len() < 3 || length < LANES {
        return entries.iter().map(|entry| entry.1).sum();
    }
    if length > BLOCK {
        let half = length / 2 / LANES * LANES;
        let (left, right) = entries.split_at(entries.partition_point(|e| e.0 < first + half));
        return sparse_pairwise_sum(left, first, half)
            + sparse_pairwise_sum(right, first + half, length - half);
    }
    let mut r = [0.0; LANES];
    let tail = first + length / LANES * LANES;
    let (whole, rest) = entries.split_at(entries.partition_point(|e| e.0 < tail));
    whole.iter().for_each(|&(place, value)| r[(place - first) % LANES] += value);
    let sum = ((r[0] + r[1]) + (r[2] + r[3])) + ((r[4] + r[5]) + (r[6] + r[7]));
    rest.iter().fold(sum, |sum, entry| sum + entry.1)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn zeros_change_nothing() {
        for length in [1, 7, 8, 9, 30, 128, 129, 300, 1000] {
            let values: Vec<f64> =
                (0..length).map(|i| if i % 3 == 0 { 0.0 } else { 1.0 / (i + 1) as f64 }).collect();
            let entries: Vec<_> =
                values.iter().copied().enumerate().filter(|entry| entry.1 > 0.0).collect();
            assert_eq!(sparse_pairwise_sum(&entries, 0, length), pairwise_sum(&values));
            let plain: f64 = values.iter().sum();
            assert!((pairwise_sum(&values) - plain).abs() < 1e-12);
        }
    }
}
