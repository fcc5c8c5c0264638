//! Many small records at once: one record in each lane of a vector.
//!
//! Records (vectors of an error, covariances) lie one after the other in memory. A kernel that works
//! on as many records as a vector has lanes needs them transposed: element i of every record in one
//! vector. Loading element by element would cost more than the arithmetic; so whole vectors are
//! loaded and transposed in registers, in blocks of four elements.

use crate::simd::{Width, limit};
use pulp::{Simd, WithSimd, bytemuck};
#[cfg(target_arch = "x86_64")]
use pulp::{
    cast,
    x86::{V3, V4},
};

/// The lanes of a vector.
#[inline(always)]
pub(crate) fn lanes<V: bytemuck::Pod>(vector: &mut V) -> &mut [f64] {
    bytemuck::cast_slice_mut(std::slice::from_mut(vector))
}

/// Writes as many lanes as there is space for.
#[inline(always)]
pub(crate) fn store<V: bytemuck::Pod>(mut vector: V, space: &mut [f64]) {
    let values = lanes(&mut vector);
    match space.len() == values.len() {
        true => space.copy_from_slice(values),
        false => space.iter_mut().zip(values).for_each(|(to, x)| *to = *x),
    }
}

/// Loads records transposed.
pub trait Load<S: Simd>: Copy {
    /// Element `i` of record `l` into lane `l` of `vectors[i]`, for as many records as there are
    /// lanes. The records have as many elements as there are vectors.
    fn load(self, simd: S, records: &[f64], vectors: &mut [S::f64s]);

    /// The same of the first `count` records; the lanes beyond repeat the last.
    fn load_some(self, simd: S, records: &[f64], count: usize, vectors: &mut [S::f64s]);

    /// Asks the memory for records that will soon be loaded.
    #[inline(always)]
    fn fetch(self, _simd: S, _records: &[f64]) {}
}

/// What [`dispatch`] runs: a kernel over lanes of any width.
pub trait WithLanes {
    /// What comes out.
    type Output;
    /// The widest vectors that it gains from.
    const WIDEST: Width = Width::Widest;
    /// The kernel; to be marked `#[inline(always)]`, so that it is compiled for the width.
    fn with_lanes<S: Simd, L: Load<S>>(self, simd: S, load: L) -> Self::Output;
}

/// Runs `operation` compiled for the widest vector units that the machine has, the limit allows and
/// the operation is good for.
#[inline]
pub fn dispatch<Op: WithLanes>(operation: Op) -> Op::Output {
    let limit = limit();
    #[cfg(target_arch = "x86_64")]
    {
        if limit == Width::Widest
            && Op::WIDEST == Width::Widest
            && let Some(simd) = V4::try_new()
        {
            return Simd::vectorize(simd, On(operation, simd));
        }
        if limit != Width::Scalar
            && let Some(simd) = V3::try_new()
        {
            return Simd::vectorize(simd, On(operation, simd));
        }
    }
    #[cfg(not(target_arch = "x86_64"))]
    if limit == Width::Widest {
        return pulp::Arch::new().dispatch(Gathered(operation));
    }
    Gathered(operation).with_simd(pulp::Scalar::new())
}

/// An operation with the vector units it is compiled for, whose registers it may transpose.
#[cfg(target_arch = "x86_64")]
struct On<Op, S>(Op, S);

#[cfg(target_arch = "x86_64")]
impl<Op: WithLanes, Own: Simd> WithSimd for On<Op, Own>
where
    Transposed: Load<Own>,
{
    type Output = Op::Output;

    #[inline(always)]
    fn with_simd<S: Simd>(self, _: S) -> Op::Output {
        self.0.with_lanes(self.1, Transposed)
    }
}

/// An operation on vector units whose registers are filled element by element.
struct Gathered<Op>(Op);

impl<Op: WithLanes> WithSimd for Gathered<Op> {
    type Output = Op::Output;

    #[inline(always)]
    fn with_simd<S: Simd>(self, simd: S) -> Op::Output {
        self.0.with_lanes(simd, Each)
    }
}

/// Fills a vector element by element.
#[derive(Clone, Copy)]
struct Each;

impl<S: Simd> Load<S> for Each {
    #[inline(always)]
    fn load(self, simd: S, records: &[f64], vectors: &mut [S::f64s]) {
        self.load_some(simd, records, S::F64_LANES, vectors);
    }

    #[inline(always)]
    fn load_some(self, _: S, records: &[f64], count: usize, vectors: &mut [S::f64s]) {
        let size = vectors.len();
        for (i, vector) in vectors.iter_mut().enumerate() {
            for (l, value) in lanes(vector).iter_mut().enumerate() {
                *value = records[l.min(count - 1) * size + i];
            }
        }
    }
}

/// Loads rows and transposes them in registers, four elements of every record at a time.
#[cfg(target_arch = "x86_64")]
#[derive(Clone, Copy)]
struct Transposed;

#[cfg(target_arch = "x86_64")]
impl Load<V3> for Transposed {
    #[inline(always)]
    fn fetch(self, simd: V3, records: &[f64]) {
        for line in records.chunks(8) {
            simd.sse._mm_prefetch::<{ std::arch::x86_64::_MM_HINT_T0 }>(line.as_ptr().cast());
        }
    }

    #[inline(always)]
    fn load(self, simd: V3, records: &[f64], vectors: &mut [pulp::f64x4]) {
        let size = vectors.len();
        if let ([vector], Some(values)) = (&mut *vectors, records.first_chunk::<4>()) {
            *vector = cast(*values);
            return;
        }
        if let [x, y] = &mut *vectors {
            [*x, *y] = pairs4(simd, records);
            return;
        }
        if let [x, y, z] = &mut *vectors {
            let rows = rows_of_three(records);
            [*x, *y, *z, _] = transpose4(simd, &rows.each_ref().map(std::slice::from_ref), 0);
            return;
        }
        transpose_rows4(simd, &rows::<4>(records, size, 4), vectors);
    }

    #[inline(always)]
    fn load_some(self, simd: V3, records: &[f64], count: usize, vectors: &mut [pulp::f64x4]) {
        transpose_rows4(simd, &rows::<4>(records, vectors.len(), count), vectors);
    }
}

/// Transposes rows as long as there are vectors.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn transpose_rows4(simd: V3, rows: &[&[f64]; 4], vectors: &mut [pulp::f64x4]) {
    let size = vectors.len();
    let fours = rows.map(|row| row.as_chunks::<4>().0);
    let mut blocks = vectors.chunks_exact_mut(4);
    for (b, block) in (&mut blocks).enumerate() {
        block.copy_from_slice(&transpose4(simd, &fours, b));
    }
    let rest = blocks.into_remainder();
    if size > 4 && rest.len() > 1 {
        // One block more, over the last four: it repeats elements of the block before.
        let fours = rows.map(|row| row.as_rchunks::<4>().1);
        let last = transpose4(simd, &fours, size / 4 - 1);
        rest.copy_from_slice(&last[4 - rest.len()..]);
    } else {
        for (k, vector) in rest.iter_mut().enumerate() {
            let [a, b, c, d] = rows.map(|row| row[size / 4 * 4 + k]);
            *vector = cast(simd.avx._mm256_setr_pd(a, b, c, d));
        }
    }
}

#[cfg(target_arch = "x86_64")]
impl Load<V4> for Transposed {
    #[inline(always)]
    fn fetch(self, simd: V4, records: &[f64]) {
        for line in records.chunks(8) {
            simd.sse._mm_prefetch::<{ std::arch::x86_64::_MM_HINT_T0 }>(line.as_ptr().cast());
        }
    }

    #[inline(always)]
    fn load(self, simd: V4, records: &[f64], vectors: &mut [pulp::f64x8]) {
        let size = vectors.len();
        if let ([vector], Some(values)) = (&mut *vectors, records.first_chunk::<8>()) {
            *vector = cast(*values);
            return;
        }
        if let [x, y] = &mut *vectors {
            [*x, *y] = pairs8(simd, records);
            return;
        }
        if let [x, y, z] = &mut *vectors {
            [*x, *y, *z] = triples8(simd, records);
            return;
        }
        transpose_rows8(simd, &rows::<8>(records, size, 8), vectors);
    }

    #[inline(always)]
    fn load_some(self, simd: V4, records: &[f64], count: usize, vectors: &mut [pulp::f64x8]) {
        transpose_rows8(simd, &rows::<8>(records, vectors.len(), count), vectors);
    }
}

/// Transposes rows as long as there are vectors.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn transpose_rows8(simd: V4, rows: &[&[f64]; 8], vectors: &mut [pulp::f64x8]) {
    let size = vectors.len();
    let fours = rows.map(|row| row.as_chunks::<4>().0);
    let mut blocks = vectors.chunks_exact_mut(4);
    for (b, block) in (&mut blocks).enumerate() {
        block.copy_from_slice(&transpose8(simd, &fours, b));
    }
    let rest = blocks.into_remainder();
    if size > 4 && rest.len() > 1 {
        let fours = rows.map(|row| row.as_rchunks::<4>().1);
        let last = transpose8(simd, &fours, size / 4 - 1);
        rest.copy_from_slice(&last[4 - rest.len()..]);
    } else {
        for (k, vector) in rest.iter_mut().enumerate() {
            let [a, b, c, d, e, f, g, h] = rows.map(|row| row[size / 4 * 4 + k]);
            *vector = cast(simd.avx512f._mm512_setr_pd(a, b, c, d, e, f, g, h));
        }
    }
}

/// The elements of four records of two.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn pairs4(simd: V3, records: &[f64]) -> [pulp::f64x4; 2] {
    let (avx, [a, b]) = (simd.avx, whole::<4, 2>(records).map(cast));
    let (x, y) = (avx._mm256_unpacklo_pd(a, b), avx._mm256_unpackhi_pd(a, b));
    [x, y].map(|mixed| cast(simd.avx2._mm256_permute4x64_pd::<0b11_01_10_00>(mixed)))
}

/// The elements of eight records of two.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn pairs8(simd: V4, records: &[f64]) -> [pulp::f64x8; 2] {
    let (avx, [a, b]) = (simd.avx512f, whole::<8, 2>(records).map(cast));
    let x = cast([0u64, 2, 4, 6, 8, 10, 12, 14]);
    let y = cast([1u64, 3, 5, 7, 9, 11, 13, 15]);
    [cast(avx._mm512_permutex2var_pd(a, x, b)), cast(avx._mm512_permutex2var_pd(a, y, b))]
}

/// The elements of eight records of three: from the first two vectors, then from the third.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn triples8(simd: V4, records: &[f64]) -> [pulp::f64x8; 3] {
    let (avx, [a, b, c]) = (simd.avx512f, whole::<8, 3>(records).map(cast));
    let x = avx._mm512_permutex2var_pd(a, cast([0u64, 3, 6, 9, 12, 15, 0, 0]), b);
    let y = avx._mm512_permutex2var_pd(a, cast([1u64, 4, 7, 10, 13, 0, 0, 0]), b);
    let z = avx._mm512_permutex2var_pd(a, cast([2u64, 5, 8, 11, 14, 0, 0, 0]), b);
    [
        cast(avx._mm512_permutex2var_pd(x, cast([0u64, 1, 2, 3, 4, 5, 10, 13]), c)),
        cast(avx._mm512_permutex2var_pd(y, cast([0u64, 1, 2, 3, 4, 8, 11, 14]), c)),
        cast(avx._mm512_permutex2var_pd(z, cast([0u64, 1, 2, 3, 4, 9, 12, 15]), c)),
    ]
}

/// The first `K` vectors of `N` elements.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn whole<const N: usize, const K: usize>(records: &[f64]) -> [[f64; N]; K] {
    let mut vectors = [[0.0; N]; K];
    vectors.copy_from_slice(&records.as_chunks::<N>().0[..K]);
    vectors
}

/// Rows of three, each with one element more, of the next row or any.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn rows_of_three<const N: usize>(records: &[f64]) -> [[f64; 4]; N] {
    let records = &records[..3 * N];
    let mut rows = [[0.0; 4]; N];
    for (l, row) in rows.iter_mut().enumerate().take(N - 1) {
        row.copy_from_slice(&records[3 * l..3 * l + 4]);
    }
    rows[N - 1][..3].copy_from_slice(&records[3 * N - 3..]);
    rows
}

/// The first `count` records, the last of them repeated.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn rows<const N: usize>(records: &[f64], size: usize, count: usize) -> [&[f64]; N] {
    let mut rows = [&records[..0]; N];
    for (l, row) in rows.iter_mut().enumerate() {
        let l = l.min(count - 1);
        *row = &records[l * size..(l + 1) * size];
    }
    rows
}

/// Block `b` of four records, four by four: vector i of the result holds element i of each.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn transpose4(simd: V3, rows: &[&[[f64; 4]]; 4], b: usize) -> [pulp::f64x4; 4] {
    let avx = simd.avx;
    let [a, b, c, d] = [cast(rows[0][b]), cast(rows[1][b]), cast(rows[2][b]), cast(rows[3][b])];
    let low = [avx._mm256_unpacklo_pd(a, b), avx._mm256_unpacklo_pd(c, d)];
    let high = [avx._mm256_unpackhi_pd(a, b), avx._mm256_unpackhi_pd(c, d)];
    [
        cast(avx._mm256_permute2f128_pd::<0x20>(low[0], low[1])),
        cast(avx._mm256_permute2f128_pd::<0x20>(high[0], high[1])),
        cast(avx._mm256_permute2f128_pd::<0x31>(low[0], low[1])),
        cast(avx._mm256_permute2f128_pd::<0x31>(high[0], high[1])),
    ]
}

/// The same of eight records: two transpositions of four by four at once, records l and l + 4 in
/// one register.
#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn transpose8(simd: V4, rows: &[&[[f64; 4]]; 8], b: usize) -> [pulp::f64x8; 4] {
    let avx = simd.avx512f;
    let (a, c) = (pair(simd, &rows[0][b], &rows[4][b]), pair(simd, &rows[2][b], &rows[6][b]));
    let (b, d) = (pair(simd, &rows[1][b], &rows[5][b]), pair(simd, &rows[3][b], &rows[7][b]));
    let low = [avx._mm512_unpacklo_pd(a, b), avx._mm512_unpacklo_pd(c, d)];
    let high = [avx._mm512_unpackhi_pd(a, b), avx._mm512_unpackhi_pd(c, d)];
    let first = cast([0u64, 1, 8, 9, 4, 5, 12, 13]);
    let second = cast([2u64, 3, 10, 11, 6, 7, 14, 15]);
    [
        cast(avx._mm512_permutex2var_pd(low[0], first, low[1])),
        cast(avx._mm512_permutex2var_pd(high[0], first, high[1])),
        cast(avx._mm512_permutex2var_pd(low[0], second, low[1])),
        cast(avx._mm512_permutex2var_pd(high[0], second, high[1])),
    ]
}

#[cfg(target_arch = "x86_64")]
#[inline(always)]
fn pair(simd: V4, low: &[f64; 4], high: &[f64; 4]) -> std::arch::x86_64::__m512d {
    let avx = simd.avx512f;
    avx._mm512_insertf64x4::<1>(avx._mm512_castpd256_pd512(cast(*low)), cast(*high))
}

#[cfg(test)]
mod tests;
