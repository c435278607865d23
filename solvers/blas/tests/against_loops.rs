//! Every routine × every combination of flags × odd sizes × padded leading dimensions, against plain loops.
#![allow(unsafe_code, reason = "calls routines as C does")]

use faer::{c32, c64};
use fracas_blas::symbols::*;
use std::ffi::c_char;
use std::ops::{Add, AddAssign, Mul};

/// Sizes around register tiles and recursion thresholds, and none at all.
const SIZES: [usize; 7] = [0, 1, 3, 8, 17, 33, 70];
const TRANS: [u8; 3] = *b"NTC";

trait Scalar:
    Copy + Add<Output = Self> + Mul<Output = Self> + AddAssign + PartialEq + std::fmt::Debug
{
    const TOLERANCE: f64;
    fn of(re: f64, im: f64) -> Self;
    fn conj(self) -> Self;
    fn size(self) -> f64;
}
macro_rules! real {
    ($t:ty, $tolerance:literal) => {
        impl Scalar for $t {
            const TOLERANCE: f64 = $tolerance;
            fn of(re: f64, _: f64) -> Self {
                re as $t
            }
            fn conj(self) -> Self {
                self
            }
            fn size(self) -> f64 {
                f64::from(self.abs())
            }
        }
    };
}
macro_rules! complex {
    ($t:ty, $part:ty, $tolerance:literal) => {
        impl Scalar for $t {
            const TOLERANCE: f64 = $tolerance;
            fn of(re: f64, im: f64) -> Self {
                Self::new(re as $part, im as $part)
            }
            fn conj(self) -> Self {
                Self::new(self.re, -self.im)
            }
            fn size(self) -> f64 {
                f64::from(self.re.abs() + self.im.abs())
            }
        }
    };
}
real!(f32, 3e-4);
real!(f64, 1e-12);
complex!(c32, f32, 3e-4);
complex!(c64, f64, 1e-12);

/// A Fortran array with leading dimension `rows + 3`; the padding is NaN and must stay so.
#[derive(Clone, Debug)]
struct Array<T> {
    rows: usize,
    cols: usize,
    lda: usize,
    data: Vec<T>,
}

impl<T: Scalar> Array<T> {
    fn new(rows: usize, cols: usize, seed: u64) -> Self {
        let lda = rows + 3;
        let mut state = seed.wrapping_mul(0x9e37_79b9_7f4a_7c15) | 1;
        let mut next = || {
            state ^= state << 13;
            state ^= state >> 7;
            state ^= state << 17;
            (state >> 11) as f64 / (1u64 << 53) as f64 - 0.5
        };
        let mut array = Self {
            rows,
            cols,
            lda,
            data: vec![T::of(f64::NAN, f64::NAN); lda * cols.max(1)],
        };
        for j in 0..cols {
            for i in 0..rows {
                array.data[j * lda + i] = T::of(next(), next());
            }
        }
        array
    }

    fn at(&self, i: usize, j: usize) -> T {
        self.data[j * self.lda + i]
    }

    fn set(&mut self, i: usize, j: usize, v: T) {
        self.data[j * self.lda + i] = v;
    }

    fn op(&self, trans: u8, i: usize, j: usize) -> T {
        match trans {
            b'N' => self.at(i, j),
            b'T' => self.at(j, i),
            _ => self.at(j, i).conj(),
        }
    }

    fn is(&self, expected: &Self, what: &str) {
        for j in 0..self.cols {
            for i in 0..self.lda {
                let (found, wanted) = (self.at(i, j), expected.at(i, j));
                let untouched = found.size().is_nan() && wanted.size().is_nan();
                let difference = (found + T::of(-1.0, 0.0) * wanted).size();
                assert!(
                    untouched || difference <= T::TOLERANCE * (1.0 + wanted.size()),
                    "{what}: ({i}, {j}) is {found:?}, not {wanted:?}"
                );
            }
        }
    }

    fn lda(&self) -> i32 {
        self.lda as i32
    }
}

fn flag(f: &u8) -> *const c_char {
    std::ptr::from_ref(f).cast()
}

fn stored(trans: u8, m: usize, n: usize) -> (usize, usize) {
    if trans == b'N' { (m, n) } else { (n, m) }
}

fn in_triangle(uplo: u8, i: usize, j: usize) -> bool {
    if uplo == b'L' { i >= j } else { i <= j }
}

/// A well-conditioned triangle; the other one, and a unit diagonal, hold NaN.
fn triangle<T: Scalar>(n: usize, uplo: u8, diag: u8) -> Array<T> {
    let mut a = Array::<T>::new(n, n, 7);
    for j in 0..n {
        for i in 0..n {
            if !in_triangle(uplo, i, j) || (i == j && diag == b'U') {
                a.set(i, j, T::of(f64::NAN, f64::NAN));
            } else if i == j {
                a.set(i, j, a.at(i, j) + T::of(2.0, 0.0));
            } else {
                a.set(i, j, a.at(i, j) * T::of(2.0 / n as f64, 0.0));
            }
        }
    }
    a
}

/// op(triangle) as a full array.
fn full<T: Scalar>(a: &Array<T>, uplo: u8, trans: u8, diag: u8) -> Array<T> {
    let mut f = a.clone();
    for j in 0..a.cols {
        for i in 0..a.rows {
            let (si, sj) = if trans == b'N' { (i, j) } else { (j, i) };
            let value = if si == sj && diag == b'U' {
                T::of(1.0, 0.0)
            } else if in_triangle(uplo, si, sj) {
                a.op(trans, i, j)
            } else {
                T::of(0.0, 0.0)
            };
            f.set(i, j, value);
        }
    }
    f
}

fn product<T: Scalar>(a: &Array<T>, ta: u8, b: &Array<T>, tb: u8, i: usize, j: usize) -> T {
    let k = if ta == b'N' { a.cols } else { a.rows };
    let mut sum = T::of(0.0, 0.0);
    for l in 0..k {
        sum += a.op(ta, i, l) * b.op(tb, l, j);
    }
    sum
}

macro_rules! check {
    ($module:ident, $t:ty, $scale:ty, $hermitian:literal:
     $gemm:ident $rank_k:ident $trsm:ident $gemv:ident $trsv:ident $ger:ident $potrf:ident) => {
        mod $module {
            use super::*;
            type T = $t;

            fn scalars() -> [T; 3] {
                [T::of(0.0, 0.0), T::of(1.0, 0.0), T::of(-0.75, 0.5)]
            }

            #[test]
            fn gemm() {
                for (ta, tb) in TRANS
                    .iter()
                    .flat_map(|a| TRANS.iter().map(move |b| (*a, *b)))
                {
                    for (m, n, k) in [
                        (3, 8, 17),
                        (17, 3, 1),
                        (33, 17, 8),
                        (70, 33, 70),
                        (0, 3, 3),
                        (3, 0, 3),
                        (5, 4, 0),
                    ] {
                        let ((ra, ca), (rb, cb)) = (stored(ta, m, k), stored(tb, k, n));
                        let (a, b) = (Array::<T>::new(ra, ca, 1), Array::<T>::new(rb, cb, 2));
                        for alpha in scalars() {
                            for beta in scalars() {
                                let mut c = Array::<T>::new(m, n, 3);
                                let mut expected = c.clone();
                                for j in 0..n {
                                    for i in 0..m {
                                        let value = alpha * product(&a, ta, &b, tb, i, j);
                                        expected.set(i, j, value + beta * c.at(i, j));
                                        if beta == T::of(0.0, 0.0) {
                                            // β = 0 must not read C
                                            c.set(i, j, T::of(f64::NAN, f64::NAN));
                                        }
                                    }
                                }
                                // Safety: arrays of the stated sizes.
                                unsafe {
                                    $gemm(
                                        flag(&ta),
                                        flag(&tb),
                                        &(m as i32),
                                        &(n as i32),
                                        &(k as i32),
                                        &alpha,
                                        a.data.as_ptr(),
                                        &a.lda(),
                                        b.data.as_ptr(),
                                        &b.lda(),
                                        &beta,
                                        c.data.as_mut_ptr(),
                                        &c.lda(),
                                    );
                                }
                                c.is(
                                    &expected,
                                    &format!("gemm {ta} {tb} {m} {n} {k} {alpha:?} {beta:?}"),
                                );
                            }
                        }
                    }
                }
            }

            #[test]
            fn rank_k() {
                let transposed = if $hermitian { b'C' } else { b'T' };
                for (uplo, trans) in [
                    (b'L', b'N'),
                    (b'L', transposed),
                    (b'U', b'N'),
                    (b'U', transposed),
                ] {
                    for (n, k) in [(3, 8), (17, 3), (33, 17), (70, 33), (8, 70), (0, 3), (5, 0)] {
                        let (rows, cols) = stored(trans, n, k);
                        let a = Array::<T>::new(rows, cols, 1);
                        let adjoint = if $hermitian { b'C' } else { b'T' };
                        let (left, right) = if trans == b'N' {
                            (b'N', adjoint)
                        } else {
                            (adjoint, b'N')
                        };
                        for (alpha, beta) in [(1.0, 0.0), (-1.0, 1.0), (0.5, -2.0), (0.0, 0.5)] {
                            let mut c = Array::<T>::new(n, n, 3);
                            (0..n).for_each(|i| c.set(i, i, T::of(c.at(i, i).size(), 0.0)));
                            let mut expected = c.clone();
                            for j in 0..n {
                                for i in 0..n {
                                    if !in_triangle(uplo, i, j) {
                                        c.set(i, j, T::of(f64::NAN, f64::NAN));
                                        expected.set(i, j, T::of(f64::NAN, f64::NAN));
                                        continue;
                                    }
                                    let value =
                                        T::of(alpha, 0.0) * product(&a, left, &a, right, i, j);
                                    expected.set(i, j, value + T::of(beta, 0.0) * c.at(i, j));
                                }
                            }
                            // Safety: arrays of the stated sizes.
                            unsafe {
                                $rank_k(
                                    flag(&uplo),
                                    flag(&trans),
                                    &(n as i32),
                                    &(k as i32),
                                    &(alpha as $scale),
                                    a.data.as_ptr(),
                                    &a.lda(),
                                    &(beta as $scale),
                                    c.data.as_mut_ptr(),
                                    &c.lda(),
                                );
                            }
                            c.is(
                                &expected,
                                &format!("rank_k {uplo} {trans} {n} {k} {alpha} {beta}"),
                            );
                        }
                    }
                }
            }

            #[test]
            fn trsm() {
                for side in *b"LR" {
                    for (uplo, trans, diag) in flags() {
                        for (m, n) in [
                            (3, 8),
                            (17, 3),
                            (33, 17),
                            (70, 33),
                            (8, 70),
                            (0, 3),
                            (3, 0),
                            (1, 1),
                        ] {
                            let order = if side == b'L' { m } else { n };
                            let a = triangle::<T>(order, uplo, diag);
                            let op = full(&a, uplo, trans, diag);
                            let x = Array::<T>::new(m, n, 5);
                            for alpha in scalars() {
                                let mut b = x.clone();
                                for j in 0..n {
                                    for i in 0..m {
                                        b.set(
                                            i,
                                            j,
                                            if side == b'L' {
                                                product(&op, b'N', &x, b'N', i, j)
                                            } else {
                                                product(&x, b'N', &op, b'N', i, j)
                                            },
                                        );
                                    }
                                }
                                let mut expected = x.clone();
                                for j in 0..n {
                                    (0..m).for_each(|i| expected.set(i, j, alpha * x.at(i, j)));
                                }
                                // Safety: arrays of the stated sizes.
                                unsafe {
                                    $trsm(
                                        flag(&side),
                                        flag(&uplo),
                                        flag(&trans),
                                        flag(&diag),
                                        &(m as i32),
                                        &(n as i32),
                                        &alpha,
                                        a.data.as_ptr(),
                                        &a.lda(),
                                        b.data.as_mut_ptr(),
                                        &b.lda(),
                                    );
                                }
                                b.is(
                                    &expected,
                                    &format!("trsm {side} {uplo} {trans} {diag} {m} {n} {alpha:?}"),
                                );
                            }
                        }
                    }
                }
            }

            #[test]
            fn gemv() {
                for trans in TRANS {
                    for (m, n) in [(3, 8), (17, 3), (33, 17), (70, 33), (1, 70), (0, 3), (3, 0)] {
                        let (len_y, len_x) = stored(trans, m, n);
                        let a = Array::<T>::new(m, n, 1);
                        for (incx, incy) in [(1, 1), (2, 3), (-1, 2), (2, -2)] {
                            for (alpha, beta) in [
                                (scalars()[1], scalars()[0]),
                                (scalars()[2], scalars()[2]),
                                (scalars()[0], scalars()[1]),
                            ] {
                                let (x, mut y) =
                                    (Strided::new(len_x, incx, 2), Strided::new(len_y, incy, 3));
                                let mut expected = y.clone();
                                for i in 0..len_y {
                                    let mut sum = T::of(0.0, 0.0);
                                    (0..len_x).for_each(|j| sum += a.op(trans, i, j) * x.get(j));
                                    *expected.slot(i) = alpha * sum + beta * y.get(i);
                                    if beta == T::of(0.0, 0.0) {
                                        *y.slot(i) = T::of(f64::NAN, f64::NAN);
                                    }
                                }
                                // Safety: arrays of the stated sizes.
                                unsafe {
                                    $gemv(
                                        flag(&trans),
                                        &(m as i32),
                                        &(n as i32),
                                        &alpha,
                                        a.data.as_ptr(),
                                        &a.lda(),
                                        x.data.as_ptr(),
                                        &incx,
                                        &beta,
                                        y.data.as_mut_ptr(),
                                        &incy,
                                    );
                                }
                                y.is(&expected, &format!("gemv {trans} {m} {n} {incx} {incy}"));
                            }
                        }
                    }
                }
            }

            #[test]
            fn trsv() {
                for (uplo, trans, diag) in flags() {
                    for n in SIZES {
                        let a = triangle::<T>(n, uplo, diag);
                        let op = full(&a, uplo, trans, diag);
                        for inc in [1, 3, -2] {
                            let x = Strided::<T>::new(n, inc, 4);
                            let mut b = x.clone();
                            for i in 0..n {
                                let mut sum = T::of(0.0, 0.0);
                                (0..n).for_each(|j| sum += op.at(i, j) * x.get(j));
                                *b.slot(i) = sum;
                            }
                            // Safety: arrays of the stated sizes.
                            unsafe {
                                $trsv(
                                    flag(&uplo),
                                    flag(&trans),
                                    flag(&diag),
                                    &(n as i32),
                                    a.data.as_ptr(),
                                    &a.lda(),
                                    b.data.as_mut_ptr(),
                                    &inc,
                                );
                            }
                            b.is(&x, &format!("trsv {uplo} {trans} {diag} {n} {inc}"));
                        }
                    }
                }
            }

            #[test]
            fn ger() {
                for (m, n) in [(3, 8), (17, 3), (70, 33), (1, 1), (0, 3), (3, 0)] {
                    for (incx, incy) in [(1, 1), (2, 3), (-1, 2)] {
                        for alpha in scalars() {
                            let (x, y) =
                                (Strided::<T>::new(m, incx, 2), Strided::<T>::new(n, incy, 3));
                            let mut a = Array::<T>::new(m, n, 1);
                            let mut expected = a.clone();
                            for j in 0..n {
                                (0..m).for_each(|i| {
                                    expected.set(i, j, a.at(i, j) + alpha * x.get(i) * y.get(j))
                                });
                            }
                            // Safety: arrays of the stated sizes.
                            unsafe {
                                $ger(
                                    &(m as i32),
                                    &(n as i32),
                                    &alpha,
                                    x.data.as_ptr(),
                                    &incx,
                                    y.data.as_ptr(),
                                    &incy,
                                    a.data.as_mut_ptr(),
                                    &a.lda(),
                                );
                            }
                            a.is(&expected, &format!("ger {m} {n} {incx} {incy}"));
                        }
                    }
                }
            }

            #[test]
            fn potrf() {
                for uplo in *b"LU" {
                    for n in [0, 1, 3, 8, 17, 33, 70, 150] {
                        let exact = triangle::<T>(n, uplo, b'N');
                        let mut factor = exact.clone();
                        (0..n).for_each(|i| factor.set(i, i, T::of(exact.at(i, i).size(), 0.0)));
                        let wide = full(&factor, uplo, b'N', b'N');
                        for failing in [None, Some(0), Some(n / 2), Some(n.saturating_sub(1))] {
                            let mut a = factor.clone();
                            for j in 0..n {
                                for i in (0..n).filter(|&i| in_triangle(uplo, i, j)) {
                                    let (left, right) = if uplo == b'L' {
                                        (b'N', b'C')
                                    } else {
                                        (b'C', b'N')
                                    };
                                    a.set(i, j, product(&wide, left, &wide, right, i, j));
                                }
                            }
                            let mut expected = 0;
                            if let Some(row) = failing.filter(|_| n > 0) {
                                // one pivot becomes −1
                                let pivot = factor.at(row, row).size();
                                a.set(row, row, a.at(row, row) + T::of(-pivot * pivot - 1.0, 0.0));
                                expected = row as i32 + 1;
                            }
                            let mut info = -7;
                            // Safety: an array of the stated size.
                            unsafe {
                                $potrf(
                                    flag(&uplo),
                                    &(n as i32),
                                    a.data.as_mut_ptr(),
                                    &a.lda(),
                                    &mut info,
                                );
                            }
                            assert_eq!(info, expected, "potrf {uplo} {n} {failing:?}");
                            if expected == 0 {
                                a.is(&factor, &format!("potrf {uplo} {n}"));
                            }
                        }
                    }
                }
            }
        }
    };
}

fn flags() -> Vec<(u8, u8, u8)> {
    let mut all = Vec::new();
    for uplo in *b"LU" {
        for trans in TRANS {
            all.extend([(uplo, trans, b'N'), (uplo, trans, b'U')]);
        }
    }
    all
}

/// A strided vector; what lies between its entries is NaN and must stay so.
#[derive(Clone, Debug)]
struct Strided<T> {
    n: usize,
    inc: i32,
    data: Vec<T>,
}

impl<T: Scalar> Strided<T> {
    fn new(n: usize, inc: i32, seed: u64) -> Self {
        let values = Array::<T>::new(n, 1, seed);
        let length = 1 + n.saturating_sub(1) * inc.unsigned_abs() as usize;
        let mut vector = Self {
            n,
            inc,
            data: vec![T::of(f64::NAN, f64::NAN); length],
        };
        (0..n).for_each(|i| *vector.slot(i) = values.at(i, 0));
        vector
    }

    fn index(&self, i: usize) -> usize {
        let i = if self.inc < 0 { self.n - 1 - i } else { i };
        i * self.inc.unsigned_abs() as usize
    }

    fn get(&self, i: usize) -> T {
        self.data[self.index(i)]
    }

    fn slot(&mut self, i: usize) -> &mut T {
        let k = self.index(i);
        &mut self.data[k]
    }

    fn is(&self, expected: &Self, what: &str) {
        for (found, wanted) in self.data.iter().zip(&expected.data) {
            let untouched = found.size().is_nan() && wanted.size().is_nan();
            let difference = (*found + T::of(-1.0, 0.0) * *wanted).size();
            assert!(
                untouched || difference <= T::TOLERANCE * (1.0 + wanted.size()),
                "{what}: {found:?}, not {wanted:?}"
            );
        }
    }
}

check!(single, f32, f32, false: sgemm_ffm_ ssyrk_ffm_ strsm_ffm_ sgemv_ffm_ strsv_ffm_ sger_ffm_ spotrf_ffm_);
check!(double, f64, f64, false: dgemm_ffm_ dsyrk_ffm_ dtrsm_ffm_ dgemv_ffm_ dtrsv_ffm_ dger_ffm_ dpotrf_ffm_);
check!(single_complex, c32, f32, true: cgemm_ffm_ cherk_ffm_ ctrsm_ffm_ cgemv_ffm_ ctrsv_ffm_ cgeru_ffm_ cpotrf_ffm_);
check!(double_complex, c64, f64, true: zgemm_ffm_ zherk_ffm_ ztrsm_ffm_ zgemv_ffm_ ztrsv_ffm_ zgeru_ffm_ zpotrf_ffm_);
