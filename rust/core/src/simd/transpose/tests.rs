use super::*;
use crate::simd::MAX_LANES;
use crate::simd::set_width;

struct Check<const E: usize>;

impl<const E: usize> WithLanes for Check<E> {
    type Output = usize;

    #[inline(always)]
    fn with_lanes<S: Simd, L: Load<S>>(self, simd: S, load: L) -> usize {
        let records: Vec<f64> = (0..S::F64_LANES * E).map(|i| i as f64).collect();
        let mut vectors = [simd.splat_f64s(0.0); E];
        load.load(simd, &records, &mut vectors);
        for (i, vector) in vectors.into_iter().enumerate() {
            let mut lanes = [0.0; MAX_LANES];
            simd.partial_store_f64s(&mut lanes[..S::F64_LANES], vector);
            for (l, &value) in lanes[..S::F64_LANES].iter().enumerate() {
                assert_eq!(value, (l * E + i) as f64, "element {i} of record {l} of {E}");
            }
        }
        S::F64_LANES
    }
}

fn check_all() {
    dispatch(Check::<1>);
    dispatch(Check::<2>);
    dispatch(Check::<3>);
    dispatch(Check::<4>);
    dispatch(Check::<5>);
    dispatch(Check::<6>);
    dispatch(Check::<7>);
    dispatch(Check::<9>);
    dispatch(Check::<16>);
    dispatch(Check::<25>);
    dispatch(Check::<81>);
}

#[test]
fn every_element_arrives_in_its_lane() {
    for width in [Width::Scalar, Width::V3, Width::Widest] {
        set_width(width);
        check_all();
    }
}
