//! Claim: with S_u inverted exactly, friction moves eigenvalues by one term of a pencil, and GMRES takes one step more than CG on it.
//!
//! S = BᵀA⁻¹B, M = [A B; Bᵀ −C], A and C positive definite, x ↦ xᵀ(S+C)x a norm of tractions.
//! - *Slip.* For 𝒜 = [A B+E; Bᵀ −H], M⁻¹𝒜 = [I *; 0 Z_E], Z_E = (S+C)⁻¹(S + H + BᵀA⁻¹E); for 𝒜 = [A B; Bᵀ+Eᵀ −H], as friction makes it,
//!   𝒜M⁻¹ = [I 0; * (S + H + EᵀA⁻¹B)(S+C)⁻¹]. H need not be symmetric.
//! - *GMRES.* For E = 0, Z = (S+C)⁻¹(S+H) and f(1) = 0: f(M⁻¹𝒜) r = [−A⁻¹B f(Z) r_t; f(Z) r_t], so that its norm in A ⊕ C is that of
//!   f(Z) r_t in S + C. With f(0) = 1 the residuals of GMRES are no larger than those of (1−z) p(z), p(0) = 1.
//!
//! `EXACT_SCHUR_FAMILY=10000 EXACT_SCHUR_SEED=1 cargo test --release --test systems exact_schur -- --nocapture` tries that many systems.

mod friction;
mod gmres;

use faer::Mat;
use fracas::scene::Scene;
use fracas_operators::Dense;
use fracas_operators::random::Random;
use fracas_solvers::direct::DirectChoice;
use fracas_solvers::eigen::dense;
use fracas_solvers::saddle::schur::exact_inverse;
use fracas_solvers::saddle::{AugmentationChoice, RacpInverse, SaddleBlocks};

/// Systems where the environment names no number.
const FEW: u64 = 300;

/// Scenes where the environment names no number: one in so many of the random systems.
const PER_SCENE: u64 = 10;

fn of_environment(name: &str, default: u64) -> u64 {
    let text = std::env::var(name).ok();
    text.and_then(|text| text.parse().ok()).unwrap_or(default)
}

fn seeds() -> std::ops::Range<u64> {
    let first = of_environment("EXACT_SCHUR_SEED", 0) * 1_000_000;
    first..first + of_environment("EXACT_SCHUR_FAMILY", FEW)
}

/// Seeds of scenes.
fn scenes() -> std::ops::Range<u64> {
    let all = seeds();
    all.start..all.start + (all.end - all.start).div_ceil(PER_SCENE)
}

fn random(dice: &mut Random, rows: usize, cols: usize) -> Mat<f64> {
    Mat::from_fn(rows, cols, |_, _| dice.between(-1.0, 1.0))
}

fn transposed(x: &Mat<f64>) -> Mat<f64> {
    x.transpose().to_owned()
}

/// K⁻¹X for K ≻ 0; `None` where K is not.
fn solved(k: &Mat<f64>, x: &Mat<f64>) -> Option<Mat<f64>> {
    let l = dense::cholesky(k.clone()).ok()?;
    let mut x = x.clone();
    dense::solve_lower(l.as_ref(), &mut x);
    dense::solve_lower_adjoint(l.as_ref(), &mut x);
    Some(x)
}

fn stacked(upper: [&Mat<f64>; 2], lower: [&Mat<f64>; 2]) -> Mat<f64> {
    let (n_u, n_t) = (upper[0].nrows(), lower[1].nrows());
    Mat::from_fn(n_u + n_t, n_u + n_t, |i, j| match (i < n_u, j < n_u) {
        (true, true) => upper[0][(i, j)],
        (true, false) => upper[1][(i, j - n_u)],
        (false, true) => lower[0][(i - n_u, j)],
        (false, false) => lower[1][(i - n_u, j - n_u)],
    })
}

/// xᵀKx.
fn square(k: &Mat<f64>, x: &Mat<f64>) -> f64 {
    (x.transpose() * (k * x))[(0, 0)]
}

/// Numbers with two digits.
fn in_short(values: &[f64]) -> String {
    let each: Vec<String> = values.iter().map(|v| format!("{v:.1e}")).collect();
    each.join(", ")
}

fn largest(x: &Mat<f64>) -> f64 {
    (0..x.ncols())
        .flat_map(|j| (0..x.nrows()).map(move |i| (i, j)))
        .fold(0.0, |m, at| m.max(x[at].abs()))
}

/// Boxes on a fixed floor with one or two cuts that stand on it, so that A is regular; layers, grids and ν at random.
fn scene(seed: u64) -> Scene {
    let dice = &mut Random::new(seed);
    let cells = [0, 1, 2].map(|_| 2 + dice.below(2));
    let sides = [0, 1, 2].map(|_| dice.one_of(&[0.1, 1.0, 1.0, 5.0]));
    let mut text = "title = \"box\"\n[mesh]\n".to_owned();
    for (d, axis) in ["x", "y", "z"].into_iter().enumerate() {
        let to = sides[d] * cells[d] as f64;
        text += &format!(
            "{axis} = {{ from = \"0 m\", to = \"{to} m\", cells = {} }}\n",
            cells[d]
        );
    }
    let (poisson, soft) = (dice.one_of(&[0.0, 0.25, 0.45]), dice.scale(0.025, 25.0));
    for (name, young, layers) in [
        ("rock", 25.0, String::new()),
        (
            "layer",
            soft,
            format!("layers = [[\"0 m\", \"{} m\"]]\n", sides[2]),
        ),
    ] {
        text += &format!(
            "[[material]]\nname = \"{name}\"\nyoung = \"{young} GPa\"\npoisson = {poisson}\ndensity = \"2500 kg/m3\"\n{layers}"
        );
    }
    let first = dice.below(2);
    for k in 0..=dice.below(2) {
        let d = (first + k) % 2;
        let at = sides[d] * (1 + dice.below(cells[d] - 1)) as f64;
        text += &format!(
            "[[fracture]]\nname = \"f{k}\"\nplane = \"{}\"\nat = \"{at} m\"\nfriction_angle = \"30 deg\"\n",
            ["x", "y"][d]
        );
    }
    text += "[[boundary]]\nside = \"z-\"\nhold = \"fixed\"\n[[boundary]]\nside = \"z+\"\npressure = \"10 MPa\"\n";
    Scene::from_toml(&text, "box.toml").unwrap()
}

/// What is left out of the hypotheses.
#[derive(Clone, Copy, PartialEq)]
enum Without {
    Nothing,
    /// S̃_u⁻¹ is another one.
    Exact,
    /// A has a negative eigenvalue; S_u has none.
    Definite,
}

/// Which of B1, B2 is not that of M.
#[derive(Clone, Copy, Debug, PartialEq)]
enum Side {
    First,
    Second,
}

/// A system with its C, and M⁻¹.
struct Case {
    a: Mat<f64>,
    b: Mat<f64>,
    e: Mat<f64>,
    h: Mat<f64>,
    c: Mat<f64>,
    m_inverse: Mat<f64>,
}

impl Case {
    /// Random; `friction` gives an E and an unsymmetric H.
    fn new(seed: u64, friction: bool, without: Without) -> Option<Self> {
        let dice = &mut Random::new(seed);
        let n_u = 3 + dice.below(8);
        let n_t = 1 + dice.below(n_u);
        let r = random(dice, n_u, n_u);
        let least = dice.scale(0.02, 1.0);
        let mut a = &r * r.transpose() + Mat::<f64>::identity(n_u, n_u) * least;
        let b = random(dice, n_u, n_t);
        if without == Without::Definite {
            // along B, where S_u has what A lacks
            let v = &b * random(dice, n_t, 1);
            let much = dice.between(1.1, 3.0) / (v.transpose() * solved(&a, &v)?)[(0, 0)];
            a -= &v * v.transpose() * much;
        }
        let (e_size, h_size) = (dice.scale(1e-2, 1.0), dice.scale(1e-2, 30.0));
        let (e, q, skew) = (
            random(dice, n_u, n_t) * e_size,
            random(dice, n_t, n_t) * h_size.sqrt(),
            random(dice, n_t, n_t) * (0.3 * h_size),
        );
        let mut h = &q * q.transpose();
        if dice.once_in(4) {
            h = Mat::zeros(n_t, n_t);
        }
        let c_size = dice.scale(1e-2, 10.0);
        let c = Mat::from_fn(n_t, n_t, |i, j| {
            if i == j {
                dice.scale(0.2, 5.0) * c_size
            } else {
                0.0
            }
        });
        let (e, h) = match friction {
            true => (e, h + skew),
            false => (Mat::zeros(n_u, n_t), h),
        };
        let s_u = &a + &b * solved(&c, &transposed(&b))?;
        let mut inverse = solved(&s_u, &Mat::identity(n_u, n_u))?;
        if without == Without::Exact {
            let v = random(dice, n_u, n_u) * 0.3;
            inverse = &inverse + v.transpose() * &inverse * &v;
        }
        // [I 0; C⁻¹Bᵀ I] diag(S̃_u⁻¹, −C⁻¹) [I BC⁻¹; 0 I]
        let w = solved(&c, &transposed(&b))?;
        let corner = &inverse * w.transpose();
        let last = &w * &corner - solved(&c, &Mat::identity(n_t, n_t))?;
        let m_inverse = stacked([&inverse, &corner], [&transposed(&corner), &last]);
        Some(Self {
            a,
            b,
            e,
            h,
            c,
            m_inverse,
        })
    }

    /// Assembled blocks with the C and the M⁻¹ of the library, which takes B1 for B.
    fn assembled(blocks: SaddleBlocks) -> Option<Self> {
        let unit = blocks.traction_unit();
        let blocks = blocks.into_traction_unit(unit);
        let direct = DirectChoice::Auto.solver().ok()?;
        let c = (AugmentationChoice::LocalH.compute(&blocks, &*direct).ok()?).matrix;
        let (dense_c, s_u) = (c.to_dense(), exact_inverse(&blocks, &c, &*direct).ok()?);
        let inverse = Dense::of_preconditioner(&RacpInverse::new(blocks.b1.clone(), c, s_u));
        let n = blocks.size();
        let (a, b) = (dense::to_dense(&blocks.a), dense::to_dense(&blocks.b1));
        let ends = dense::symmetric_eigenvalues(a.as_ref()).ok()?;
        if ends[0] < 1e-10 * ends[ends.len() - 1] {
            return None;
        }
        Some(Self {
            a,
            e: dense::to_dense(&blocks.b2_rows()).transpose() - &b,
            h: match &blocks.h {
                Some(h) => dense::to_dense(h),
                None => Mat::zeros(blocks.n_t(), blocks.n_t()),
            },
            b,
            c: dense_c,
            m_inverse: Mat::from_fn(n, n, |i, j| inverse.entry(i, j)),
        })
    }

    fn sizes(&self) -> [usize; 2] {
        [self.b.nrows(), self.b.ncols()]
    }

    /// 𝒜.
    fn system(&self, side: Side) -> Mat<f64> {
        let (b_t, other) = (transposed(&self.b), &self.b + &self.e);
        let minus_h = &self.h * -1.0;
        match side {
            Side::First => stacked([&self.a, &other], [&b_t, &minus_h]),
            Side::Second => stacked([&self.a, &self.b], [&transposed(&other), &minus_h]),
        }
    }

    /// S + C.
    fn norm(&self) -> Mat<f64> {
        let [n_u, n_t] = self.sizes();
        // A may be indefinite where that is tried
        let inverse = match solved(&self.a, &Mat::identity(n_u, n_u)) {
            Some(inverse) => inverse,
            None => {
                let (values, v) = dense::symmetric_eigen(self.a.as_ref()).unwrap();
                Mat::from_fn(n_u, n_u, |i, j| v[(i, j)] / values[j]) * v.transpose()
            }
        };
        let mut s = self.b.transpose() * inverse * &self.b;
        dense::symmetrize(&mut s);
        assert_eq!(s.nrows(), n_t);
        s + &self.c
    }

    /// BᵀA⁻¹E.
    fn friction(&self) -> Mat<f64> {
        self.b.transpose() * solved(&self.a, &self.e).unwrap()
    }

    /// Z_E, or what is similar to that of the other side; A ≻ 0.
    fn pencil(&self, side: Side) -> Mat<f64> {
        let norm = self.norm();
        let h = match side {
            Side::First => self.h.clone(),
            // ((S + H + EᵀA⁻¹B)(S+C)⁻¹)ᵀ = (S+C)⁻¹(S + Hᵀ + BᵀA⁻¹E)
            Side::Second => transposed(&self.h),
        };
        let right = &norm - &self.c + h + self.friction();
        solved(&norm, &right).unwrap()
    }
}
