//! Systems whose spectra are known, for tests.

use crate::saddle::{AugmentationMatrix, SaddleBlocks};
use faer::Mat;
use fracas_operators::random::Random;
use fracas_operators::sparse::{SparseMatrix, Triplets};

pub(crate) fn sparse(m: &Mat<f64>) -> SparseMatrix<f64> {
    let mut triplets = Triplets::new((m.nrows(), m.ncols()));
    for i in 0..m.nrows() {
        (0..m.ncols()).for_each(|j| triplets.add_triplet(i, j, m[(i, j)]));
    }
    triplets.to_csr()
}

/// Hadamard's matrix, `H Hᵀ = n I`: with a power of two as n, products with whole numbers round nothing.
pub(crate) fn hadamard(n: usize) -> Mat<f64> {
    Mat::from_fn(n, n, |i, j| match (i & j).count_ones() % 2 {
        0 => 1.0,
        _ => -1.0,
    })
}

/// How the pieces of a case are drawn.
#[derive(Clone, Copy, Debug, PartialEq)]
pub(crate) enum Kind {
    Plain,
    /// Eigenvalues that agree, or all but.
    Clustered,
    /// Stiffness and compliance over many powers of two.
    Stretched,
    /// A with a kernel.
    Singular,
    /// B2 is not B1ᵀ.
    Unsymmetric,
}

/// `[a b₁; b₂ −h]` and `[a b₁; b₁ −c]` side by side, in a basis that hides them: λ = (a h + b₁b₂)/(a c + b₁²), and 1.
pub(crate) struct Case {
    pub(crate) blocks: SaddleBlocks,
    pub(crate) c: AugmentationMatrix,
    /// The n_t eigenvalues beside 1.
    pub(crate) values: Vec<f64>,
}

impl Case {
    pub(crate) fn new(seed: u64, kind: Kind) -> Self {
        let dice = &mut Random::new(seed);
        let n_t = 1 << dice.below(4);
        let n_u = n_t << dice.below(3);
        let whole = |dice: &mut Random, low: u32, high: u32| f64::from(dice.whole(low, high));
        let (mut a, mut c, mut h) = (vec![0.0; n_u], vec![0.0; n_t], vec![0.0; n_t]);
        let (mut b1, mut b2) = (vec![0.0; n_t], vec![0.0; n_t]);
        for i in 0..n_u {
            a[i] = whole(dice, 1, 9);
        }
        for k in 0..n_t {
            (c[k], h[k], b1[k]) = (whole(dice, 1, 9), whole(dice, 0, 9), whole(dice, 1, 5));
            b2[k] = b1[k];
            match kind {
                Kind::Plain => {}
                Kind::Clustered => {
                    // the last digits of h tell them apart, or nothing does
                    (a[k], b1[k], b2[k], c[k]) = (2.0, 3.0, 3.0, 8.0);
                    h[k] = 4.0 + whole(dice, 0, 1) * (-30.0_f64).exp2();
                }
                Kind::Stretched => {
                    a[k] *= (-whole(dice, 0, 16)).exp2();
                    (c[k], h[k]) = (c[k] * 0.25, h[k] * 0.0625);
                }
                Kind::Singular => {
                    if dice.once_in(3) {
                        a[k] = 0.0;
                    }
                }
                Kind::Unsymmetric => b2[k] = whole(dice, 0, 9),
            }
        }
        let values = (0..n_t)
            .map(|k| (a[k] * h[k] + b1[k] * b2[k]) / (a[k] * c[k] + b1[k] * b1[k]))
            .collect();
        let (p, q) = (hadamard(n_u), hadamard(n_t));
        let diagonal = |d: &[f64], p: &Mat<f64>| {
            let n = d.len();
            let scaled = Mat::from_fn(n, n, |i, j| p[(i, j)] * d[j] / n as f64);
            &scaled * p.transpose()
        };
        let coupling = |b: &[f64]| {
            let scaled = Mat::from_fn(n_u, n_t, |i, k| p[(i, k)] * b[k] / n_t as f64);
            &scaled * q.transpose()
        };
        let a = diagonal(&a, &p);
        let b1 = coupling(&b1);
        let b2 = coupling(&b2);
        // B = P diag(b) Qᵀ/n_t, and with P = √n_u U, Q = √n_t V: b √(n_u/n_t); C and H take the square
        let ratio = (n_u / n_t) as f64;
        let times = |m: Mat<f64>| m * ratio;
        Self {
            blocks: SaddleBlocks {
                a: sparse(&a),
                b1: sparse(&b1),
                b2: (kind == Kind::Unsymmetric).then(|| sparse(&b2.transpose().to_owned())),
                h: Some(sparse(&times(diagonal(&h, &q)))),
                rhs_u: vec![0.0; n_u],
                rhs_t: vec![0.0; n_t],
                coordinates: None,
                flow: None,
            },
            c: AugmentationMatrix::from_dense(times(diagonal(&c, &q))).unwrap(),
            values,
        }
    }

    pub(crate) fn ends(&self) -> (f64, f64) {
        let all = self.values.iter().chain([&1.0]);
        let none = (f64::INFINITY, f64::NEG_INFINITY);
        all.fold(none, |(a, b), v| (a.min(*v), b.max(*v)))
    }
}

/// One rounding of the quotient that is known.
pub(crate) const LAST: f64 = 4.0 * f64::EPSILON;

pub(crate) const KINDS: [Kind; 5] = [
    Kind::Plain,
    Kind::Clustered,
    Kind::Stretched,
    Kind::Singular,
    Kind::Unsymmetric,
];

/// `𝒜 = [A b; bᵀ −h]` and c.
pub(crate) fn with_one_traction(
    a: &Mat<f64>,
    b: &[f64],
    c: f64,
    h: f64,
) -> (SaddleBlocks, AugmentationMatrix) {
    let n_u = a.nrows();
    let blocks = SaddleBlocks {
        a: sparse(a),
        b1: sparse(&Mat::from_fn(n_u, 1, |i, _| b[i])),
        b2: None,
        h: Some(sparse(&Mat::from_fn(1, 1, |_, _| h))),
        rhs_u: vec![0.0; n_u],
        rhs_t: vec![0.0],
        coordinates: None,
        flow: None,
    };
    (blocks, AugmentationMatrix::from_diagonal(vec![c]).unwrap())
}
