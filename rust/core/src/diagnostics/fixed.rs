//! Products of small matrices whose sizes are known when the program is compiled.

#![allow(clippy::needless_range_loop, reason = "an index is shared by several matrices")]

/// A matrix of A rows and B columns.
pub(super) type Matrix<const A: usize, const B: usize> = [[f64; B]; A];

/// The first `rows` x `columns` elements, row by row, padded with zeros.
#[inline(always)]
pub(super) fn load<const A: usize, const B: usize>(
    v: &[f64],
    rows: usize,
    columns: usize,
) -> Matrix<A, B> {
    let mut matrix = [[0.0; B]; A];
    if rows == A && columns == B {
        let v = &v[..A * B];
        for i in 0..A {
            matrix[i].copy_from_slice(&v[i * B..(i + 1) * B]);
        }
        return matrix;
    }
    for i in 0..rows {
        matrix[i][..columns].copy_from_slice(&v[i * columns..(i + 1) * columns]);
    }
    matrix
}

/// The scalar product.
#[inline(always)]
pub(super) fn dot<const A: usize>(a: &[f64; A], b: &[f64; A]) -> f64 {
    a.iter().zip(b).map(|(x, y)| x * y).sum()
}

/// The scalar product of the first `count` elements.
#[inline(always)]
pub(super) fn dot_first<const A: usize>(a: &[f64; A], b: &[f64; A], count: usize) -> f64 {
    (0..count).map(|i| a[i] * b[i]).sum()
}

/// A v.
#[inline(always)]
pub(super) fn apply<const A: usize, const B: usize>(a: &Matrix<A, B>, v: &[f64; B]) -> [f64; A] {
    std::array::from_fn(|i| dot(&a[i], v))
}

/// A B.
#[inline(always)]
pub(super) fn product<const A: usize, const B: usize, const C: usize>(
    a: &Matrix<A, B>,
    b: &Matrix<B, C>,
) -> Matrix<A, C> {
    let mut c = [[0.0; C]; A];
    for i in 0..A {
        for k in 0..B {
            for j in 0..C {
                c[i][j] += a[i][k] * b[k][j];
            }
        }
    }
    c
}

/// A B'.
#[inline(always)]
pub(super) fn product_transposed<const A: usize, const B: usize, const C: usize>(
    a: &Matrix<A, B>,
    b: &Matrix<C, B>,
) -> Matrix<A, C> {
    std::array::from_fn(|i| std::array::from_fn(|j| dot(&a[i], &b[j])))
}

/// F C F' of a symmetric C: the columns of (F C)' combined by the rows of F.
#[inline(always)]
pub(super) fn congruence<const N: usize>(f: &Matrix<N, N>, c: &Matrix<N, N>) -> Matrix<N, N> {
    let left = product(f, c);
    let mut columns = [[0.0; N]; N]; // (F C)'
    for i in 0..N {
        for j in 0..N {
            columns[j][i] = left[i][j];
        }
    }
    product(f, &columns)
}

/// A times a number.
#[inline(always)]
pub(super) fn scaled<const A: usize, const B: usize>(m: &Matrix<A, B>, by: f64) -> Matrix<A, B> {
    m.map(|row| row.map(|x| x * by))
}

/// Adds a multiple of a matrix.
#[inline(always)]
pub(super) fn add_scaled<const A: usize, const B: usize>(
    to: &mut Matrix<A, B>,
    m: &Matrix<A, B>,
    by: f64,
) {
    for i in 0..A {
        for j in 0..B {
            to[i][j] += by * m[i][j];
        }
    }
}

/// Row i minus a multiple of row j.
#[inline(always)]
pub(super) fn subtract<const A: usize, const B: usize>(
    m: &mut Matrix<A, B>,
    i: usize,
    j: usize,
    by: f64,
) {
    let row = m[j];
    m[i].iter_mut().zip(row).for_each(|(x, y)| *x -= by * y);
}
