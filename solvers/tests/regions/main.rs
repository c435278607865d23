//! Claim: every eigenvalue of M⁻¹𝒜, published or with H relaxed, lies in the regions that are proved for it, by the arithmetic of this file
//! and by that of the laboratory; each hypothesis is needed.
//!
//! `REGIONS_FAMILY=10000 REGIONS_SEED=1 cargo test --release -p fracas-solvers --test regions -- --nocapture` tries that many systems.
#![allow(clippy::unwrap_used)]

mod certificate;

use faer::{Mat, c64};
use fracas_operators::random::Random;
use fracas_operators::sparse::{Csr, SparseMatrix, Triplets};
use fracas_operators::{Preconditioner, Properties};
use fracas_solvers::Silent;
use fracas_solvers::direct::DirectChoice;
use fracas_solvers::eigen::dense;
use fracas_solvers::saddle::{
    AugmentationChoice, InnerChoice, RELAXATION, Relaxation, SaddleBlocks,
};
use fracas_solvers::spectrum::real_ends::lower;
use fracas_solvers::spectrum::region::is_non_real;
use fracas_solvers::spectrum::{SpectrumReport, SpectrumRequest, analyse_around};

/// Systems where the environment names no number.
const FEW: u64 = 400;

/// Rounding of the eigenvalue solver, relative to max(1, |λ|).
const ROUNDING: f64 = 1e-7;

/// Condition of S_u above which rounding, not the theorems, says where eigenvalues are: A is singular and B next to orthogonal to its kernel.
const WORST: f64 = 1e5;

fn of_environment(name: &str, default: u64) -> u64 {
    let text = std::env::var(name).ok();
    text.and_then(|text| text.parse().ok()).unwrap_or(default)
}

fn sparse(rows: usize, cols: usize, f: impl Fn(usize, usize) -> f64) -> SparseMatrix<f64> {
    let mut triplets = Triplets::new((rows, cols));
    for i in 0..rows {
        for j in 0..cols {
            triplets.add_triplet(i, j, f(i, j));
        }
    }
    triplets.to_csr()
}

fn random(dice: &mut Random, rows: usize, cols: usize) -> Mat<f64> {
    Mat::from_fn(rows, cols, |_, _| dice.between(-1.0, 1.0))
}

/// L⁻¹ X for a lower L.
fn solved(l: &Mat<f64>, x: &Mat<f64>) -> Mat<f64> {
    let mut x = x.clone();
    dense::solve_lower(l.as_ref(), &mut x);
    x
}

/// L⁻¹ K L⁻ᵀ.
fn scaled(l: &Mat<f64>, k: &Mat<f64>) -> Mat<f64> {
    let half = solved(l, k);
    let mut whole = solved(l, &half.transpose().to_owned());
    dense::symmetrize(&mut whole);
    whole
}

/// What is left out of the hypotheses.
#[derive(Clone, Copy, PartialEq)]
enum Without {
    Nothing,
    /// A has a negative eigenvalue; S_u has none.
    SemiDefiniteA,
    /// B2 is not B1ᵀ.
    Transpose,
}

/// A random system, a C and an approximation of S_u.
struct Case {
    blocks: SaddleBlocks,
    augmentation: AugmentationChoice,
    relaxation: f64,
    /// S̃_u⁻¹, dense.
    inner: Mat<f64>,
    c: Mat<f64>,
    s_u: Mat<f64>,
}

impl Case {
    fn new(seed: u64, without: Without) -> Option<Self> {
        let dice = &mut Random::new(seed);
        let (n_u, n_t) = (3 + dice.below(8), 1 + dice.below(6));
        let rank = if dice.once_in(3) { n_u - 1 } else { n_u };
        let r = random(dice, n_u, rank);
        let mut a = &r * r.transpose() * (1.0 / n_u as f64);
        if without == Without::SemiDefiniteA {
            let v = random(dice, n_u, 1);
            a -= &v * v.transpose() * dice.scale(0.05, 1.0);
        }
        let b = random(dice, n_u, n_t);
        let rank = 1 + dice.below(n_t);
        let q = random(dice, n_t, rank);
        let size = dice.scale(1e-2, 30.0);
        let h = &q * q.transpose() * size;
        let has_h = !dice.once_in(4);
        let other = random(dice, n_t, n_u) * 0.3;
        let blocks = SaddleBlocks {
            a: sparse(n_u, n_u, |i, j| a[(i, j)]),
            b1: sparse(n_u, n_t, |i, j| b[(i, j)]),
            b2: (without == Without::Transpose)
                .then(|| sparse(n_t, n_u, |i, j| b[(j, i)] + other[(i, j)])),
            h: has_h.then(|| sparse(n_t, n_t, |i, j| h[(i, j)])),
            rhs_u: vec![0.0; n_u],
            rhs_t: vec![0.0; n_t],
            coordinates: None,
            flow: None,
        };
        let augmentation = dice.one_of(&[
            AugmentationChoice::Local,
            AugmentationChoice::LocalH,
            AugmentationChoice::HalfH,
            AugmentationChoice::FittedH,
            AugmentationChoice::Global,
        ]);
        let direct = DirectChoice::Faer.solver().unwrap();
        let c = augmentation.compute(&blocks, direct.as_ref()).ok()?;
        let c = c.matrix.to_dense();
        let l_c = dense::cholesky(c.clone()).ok()?;
        let half = solved(&l_c, &b.transpose().to_owned());
        let s_u = &a + half.transpose() * &half;
        let l = dense::cholesky(s_u.clone()).ok()?;
        let ends = dense::symmetric_eigenvalues(s_u.as_ref()).ok()?;
        if ends[n_u - 1] > WORST * ends[0] {
            return None;
        }
        // S̃_u⁻¹ = L⁻ᵀ X L⁻¹ with eigenvalues of X in [δ, Δ]
        let exact = dice.once_in(6);
        let (low, high) = (dice.scale(0.02, 1.0), dice.scale(0.5, 4.0));
        let v = random(dice, n_u, n_u);
        let (_, v) = dense::symmetric_eigen((&v + v.transpose()).as_ref()).unwrap();
        let x = Mat::from_fn(n_u, n_u, |i, j| {
            let of = |k: usize| match exact {
                true => 1.0,
                false => low + (high.max(low) - low) * k as f64 / (n_u - 1) as f64,
            };
            (0..n_u).map(|k| v[(i, k)] * of(k) * v[(j, k)]).sum()
        });
        let half = dense::cholesky(x).ok()?.transpose().to_owned();
        // (X½ᵀ L⁻¹)ᵀ (X½ᵀ L⁻¹)
        let root = half * solved(&l, &Mat::identity(n_u, n_u));
        let inner = root.transpose() * &root;
        Some(Self {
            blocks,
            augmentation,
            relaxation: if dice.once_in(2) { RELAXATION } else { 0.0 },
            inner,
            c,
            s_u,
        })
    }

    fn report(&self) -> SpectrumReport {
        let request = SpectrumRequest {
            augmentation: self.augmentation,
            relaxation: self.relaxation,
            inner: "jacobi".parse::<InnerChoice>().unwrap(),
            conditions: false,
            ..SpectrumRequest::default()
        };
        let build = |_: &SaddleBlocks, _: &_| {
            Ok(Box::new(Inner(self.inner.clone())) as Box<dyn Preconditioner<f64>>)
        };
        analyse_around(&self.blocks, &request, &build, &mut Silent).unwrap()
    }

    /// What the theorems say, by this file.
    fn facts(&self) -> Facts {
        let (n_u, n_t) = (self.blocks.n_u(), self.blocks.n_t());
        let b = dense::to_dense(&self.blocks.b1);
        let b2 = match &self.blocks.b2 {
            Some(b2) => dense::to_dense(b2),
            None => b.transpose().to_owned(),
        };
        let h = match &self.blocks.h {
            Some(h) => dense::to_dense(h),
            None => Mat::zeros(n_t, n_t),
        };
        let l_c = dense::cholesky(self.c.clone()).unwrap();
        let (values, v) = dense::symmetric_eigen(scaled(&l_c, &h).as_ref()).unwrap();
        let direct = DirectChoice::Faer.solver().unwrap();
        let c = (self.augmentation.compute(&self.blocks, direct.as_ref()))
            .unwrap()
            .matrix;
        let w = self
            .blocks
            .h
            .as_ref()
            .and_then(|h| Relaxation::new(Box::new(Csr::new(h.clone())), self.relaxation, &c));
        let modes: Vec<(f64, f64)> = (values.iter())
            .map(|h| (*h, w.as_ref().map_or(1.0, |w| w.at(*h))))
            .collect();
        // W = L_c⁻ᵀ V q Vᵀ L_cᵀ, of the tractions; M⁻¹𝒜 by its formula
        let mut root = v.clone();
        dense::solve_lower_adjoint(l_c.as_ref(), &mut root);
        let w = Mat::from_fn(n_t, n_t, |i, j| root[(i, j)] * modes[j].1)
            * (l_c.clone() * &v).transpose();
        let c_inverse = {
            let i = solved(&l_c, &Mat::identity(n_t, n_t));
            i.transpose() * &i
        };
        let apply = |u: &Mat<f64>, t: &Mat<f64>| {
            let (f, g) = (
                dense::to_dense(&self.blocks.a) * u + &b * t,
                &b2 * u - &h * t,
            );
            let g = w.transpose() * g;
            let y = &self.inner * (f + &b * (&c_inverse * &g));
            let z = &w * (&c_inverse * (b.transpose() * &y - g));
            (y, z)
        };
        let unit = |n: usize, k: Option<usize>| {
            Mat::from_fn(n, 1, |i, _| f64::from(u8::from(Some(i) == k)))
        };
        let columns: Vec<_> = (0..n_u + n_t)
            .map(|k| apply(&unit(n_u, Some(k)), &unit(n_t, k.checked_sub(n_u))))
            .collect();
        let product = Mat::from_fn(n_u + n_t, n_u + n_t, |i, j| {
            let (u, t) = &columns[j];
            if i < n_u { u[(i, 0)] } else { t[(i - n_u, 0)] }
        });
        let l = dense::cholesky(self.s_u.clone()).unwrap();
        // eig(S̃_u⁻¹ S_u) = eig(Lᵀ S̃_u⁻¹ L)
        let mut sigma = l.transpose() * &self.inner * &l;
        dense::symmetrize(&mut sigma);
        let sigma = dense::symmetric_eigenvalues(sigma.as_ref()).unwrap();
        // μ: eig(I − W½(I−Ĥ)W½), W = I − GᵀG with exact S_u
        let g = solved(&l, &b) * solved(&l_c, &Mat::identity(n_t, n_t)).transpose();
        let gram = g.transpose() * &g;
        let pencil = Mat::<f64>::identity(n_t, n_t)
            - (Mat::<f64>::identity(n_t, n_t) - gram)
                * (Mat::<f64>::identity(n_t, n_t) - scaled(&l_c, &h));
        let pencil = dense::general_eigenvalues(pencil.as_ref()).unwrap();
        Facts {
            eigenvalues: dense::general_eigenvalues(product.as_ref()).unwrap(),
            modes,
            delta: sigma[0],
            capital_delta: sigma[n_u - 1],
            mu: pencil.iter().fold(f64::INFINITY, |m, v| m.min(v.re)),
        }
    }
}

struct Inner(Mat<f64>);

impl Preconditioner<f64> for Inner {
    fn size(&self) -> usize {
        self.0.nrows()
    }
    fn solve(&self, r: &[f64], z: &mut [f64], _: &mut [f64]) {
        for (i, z) in z.iter_mut().enumerate() {
            *z = (0..r.len()).map(|j| self.0[(i, j)] * r[j]).sum();
        }
    }
    fn work_len(&self) -> usize {
        0
    }
    fn flops(&self) -> u64 {
        0
    }
    fn properties(&self) -> Properties {
        Properties::LINEAR
    }
}

struct Facts {
    eigenvalues: Vec<c64>,
    /// h, q.
    modes: Vec<(f64, f64)>,
    delta: f64,
    capital_delta: f64,
    mu: f64,
}

/// Statements one by one.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
enum Statement {
    Discs,
    AroundOne,
    Upper,
    Lower,
}

impl Facts {
    fn is_published(&self) -> bool {
        self.modes.iter().all(|m| m.1 == 1.0)
    }

    fn eta(&self) -> f64 {
        self.modes.iter().fold(0.0, |m, x| m.max(x.0))
    }

    /// True where a statement holds for λ; `force` leaves out its own hypotheses (η ≤ 1; Δ as it is).
    fn holds(&self, statement: Statement, l: c64, force: bool) -> bool {
        // exact S_u: 1 is an eigenvalue with chains of up to three vectors, found to the cube root of rounding, of which Δ − δ is what S_u takes
        let rounding = self.capital_delta - self.delta;
        if rounding < 1e-9 && (l - 1.0).norm() < 5e-5f64.max(rounding.cbrt()) {
            return true;
        }
        let (re, square) = (l.re, l.norm_sqr());
        let slack = ROUNDING * square.max(1.0);
        let dominated = force || (self.is_published() && self.eta() <= 1.0);
        match (statement, is_non_real(re, l.im)) {
            (Statement::Discs, true) => self.modes.iter().any(|&(h, q)| {
                let a = h * q * q;
                (2.0 * q - a) * square - 2.0 * q * q * re + q * q * a <= slack * (1.0 + h)
            }),
            (Statement::AroundOne, true) => {
                let least = self.modes.iter().fold(1.0f64, |m, x| m.min(x.0));
                !dominated || (l - 1.0).norm_sqr() <= (1.0 - self.delta) * (1.0 - least) + slack
            }
            (Statement::Upper, false) => {
                let d = if force {
                    1.0
                } else {
                    self.capital_delta.max(1.0)
                };
                let a = self
                    .modes
                    .iter()
                    .fold(0.0f64, |m, x| m.max(x.0 * x.1 * x.1));
                re <= 1f64.max(a).max(d + (d * d - d).sqrt()) + slack
            }
            (Statement::Lower, false) => {
                !dominated || re >= lower(self.delta, self.capital_delta, self.mu) - slack
            }
            _ => true,
        }
    }

    fn outside(&self, statement: Statement, force: bool) -> Vec<c64> {
        let values = self.eigenvalues.iter().copied();
        values
            .filter(|l| !self.holds(statement, *l, force))
            .collect()
    }
}

const ALL: [Statement; 4] = [
    Statement::Discs,
    Statement::AroundOne,
    Statement::Upper,
    Statement::Lower,
];

#[test]
fn every_eigenvalue_of_random_systems_lies_in_the_proved_region() {
    let count = of_environment("REGIONS_FAMILY", FEW);
    let first = of_environment("REGIONS_SEED", 0) * 1_000_000;
    let (mut systems, mut eigenvalues, mut non_real, mut relaxed, mut positive) = (0, 0, 0, 0, 0);
    for seed in first..first + count {
        let Some(case) = Case::new(seed, Without::Nothing) else {
            continue;
        };
        let facts = case.facts();
        for statement in ALL {
            let outside = facts.outside(statement, false);
            assert!(
                outside.is_empty(),
                "{statement:?}, seed {seed}: {outside:?}, delta {}, Delta {}, modes {:?}",
                facts.delta,
                facts.capital_delta,
                facts.modes
            );
        }
        let report = case.report();
        assert_eq!(
            report.contained,
            Some(true),
            "seed {seed}: {:?}",
            report.outside.first()
        );
        // its eigenvalues are those of this file, its extreme values too
        for l in &facts.eigenvalues {
            let near = |(re, im): (f64, f64)| (re - l.re).hypot(im - l.im);
            let nearest = report
                .eigenvalues
                .iter()
                .map(near)
                .fold(f64::INFINITY, f64::min);
            let rounding = (facts.capital_delta - facts.delta).min(1e-9).cbrt();
            assert!(
                nearest < 1e-4f64.max(rounding) * l.norm().max(1.0),
                "seed {seed}: {l} by {nearest:e}"
            );
        }
        for (found, expected) in [
            (report.delta, facts.delta),
            (report.Delta, facts.capital_delta),
            (report.eta, facts.eta()),
        ] {
            assert!(
                (found.unwrap() - expected).abs() < 1e-8 * expected.max(1.0),
                "seed {seed}"
            );
        }
        systems += 1;
        eigenvalues += facts.eigenvalues.len();
        non_real += report.n_complex;
        relaxed += usize::from(!facts.is_published());
        positive += usize::from(report.bounds.real_low.unwrap() > 0.0);
    }
    println!(
        "{systems} systems, {eigenvalues} eigenvalues, {non_real} non-real, {relaxed} systems relaxed, {positive} with a positive lower end"
    );
    // the family is not trivial
    assert!(systems > 9 * count / 10 && non_real > eigenvalues / 20 && relaxed as u64 > count / 10);
}

#[test]
fn each_hypothesis_is_needed() {
    let violated = |without: Without, statement: Statement, force: bool| {
        (0..FEW).any(|seed| {
            let case = Case::new(seed, without);
            case.is_some_and(|case| !case.facts().outside(statement, force).is_empty())
        })
    };
    // the circle around 1 and the lower end ask nothing of A beyond S_u ≻ 0
    for statement in [Statement::Discs, Statement::Upper] {
        assert!(
            violated(Without::SemiDefiniteA, statement, false),
            "A ⪰ 0: {statement:?}"
        );
    }
    for statement in ALL {
        assert!(
            violated(Without::Transpose, statement, false),
            "B2 = B1ᵀ: {statement:?}"
        );
    }
    // η ≤ 1, and Δ > 1 taken for 1
    for statement in [Statement::AroundOne, Statement::Lower, Statement::Upper] {
        assert!(
            violated(Without::Nothing, statement, true),
            "own hypothesis: {statement:?}"
        );
    }
}
