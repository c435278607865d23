//! Eigenvectors of chosen eigenvalues, to be shown on the mesh.

use super::coupling::Coupling;
use super::product::Preconditioned;
use crate::SetupError;
use crate::eigen::dense;
use crate::saddle::{AugmentationMatrix, P, SaddleBlocks, T, U};
use faer::{Mat, c64};
use fracas_operators::{Layout, LinearOperator, Preconditioner};
use schemars::JsonSchema;
use serde::{Deserialize, Serialize};
use std::str::FromStr;

/// Which eigenvalue.
#[derive(Clone, Copy, Debug, PartialEq, Serialize, Deserialize, JsonSchema)]
#[serde(rename_all = "snake_case")]
pub enum ModeTarget {
    /// The one with the smallest real part.
    Smallest,
    /// The one with the largest real part.
    Largest,
    /// The one closest to a real number.
    Closest(f64),
}

impl ModeTarget {
    /// Distance to be minimised.
    fn distance(self, re: f64, im: f64) -> f64 {
        match self {
            Self::Smallest => re,
            Self::Largest => -re,
            Self::Closest(target) => (re - target).hypot(im),
        }
    }

    fn choose(self, values: impl Iterator<Item = (f64, f64)>) -> Option<usize> {
        values
            .enumerate()
            .min_by(|(_, a), (_, b)| self.distance(a.0, a.1).total_cmp(&self.distance(b.0, b.1)))
            .map(|(index, _)| index)
    }
}

/// Text that names no eigenvalue.
#[derive(Clone, Debug, PartialEq, Eq, thiserror::Error)]
#[error("unknown mode {found:?}: expected smallest, largest or a number such as 0.5")]
pub struct UnknownModeTarget {
    /// What was given.
    pub found: String,
}

impl FromStr for ModeTarget {
    type Err = UnknownModeTarget;

    fn from_str(name: &str) -> Result<Self, Self::Err> {
        match name {
            "smallest" => Ok(Self::Smallest),
            "largest" => Ok(Self::Largest),
            number => match number.parse() {
                Ok(target) if f64::is_finite(target) => Ok(Self::Closest(target)),
                _ => Err(UnknownModeTarget {
                    found: name.to_owned(),
                }),
            },
        }
    }
}

/// An eigenvector `M⁻¹𝒜 (u, t) = λ (u, t)`, scaled to the energy `uᵀ diag(S_u) u + tᵀ diag(C) t = 1`; with flow (u, t, p) and the
/// energy of p.
///
/// For a non-real λ it is the real part, in the phase that makes the entry of largest energy real and positive.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Mode {
    /// (Re λ, Im λ).
    pub eigenvalue: (f64, f64),
    /// Displacements.
    pub u: Vec<f64>,
    /// Tractions.
    pub t: Vec<f64>,
    /// Pressures, where there is flow.
    #[serde(skip_serializing_if = "Vec::is_empty")]
    pub p: Vec<f64>,
    /// Share of `tᵀ diag(C) t` in the energy: 1 for a mode that displaces nothing.
    pub traction_share: f64,
    /// The same of pressures; none without flow.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pressure_share: Option<f64>,
    /// `‖M⁻¹𝒜v − λv‖ / ‖v‖` in the energy scales √diag(S_u), √diag(C).
    pub residual: f64,
}

/// Modes among the n_t eigenvalues that exact S_u leaves besides 1:
/// `u = S_u⁻¹ B F (I−Ĥ) t' / (λ−1)`, `t = F t'`. Targets whose eigenvalue is 1 are left out (its eigenspace has at
/// least n_u dimensions: every displacement belongs to one).
pub(super) fn of_coupling(
    targets: &[ModeTarget],
    coupling: &Coupling,
    blocks: &SaddleBlocks,
    c: &AugmentationMatrix,
    inner: &dyn Preconditioner<f64>,
    judge: &Judge<'_>,
) -> Result<Vec<Mode>, SetupError> {
    if targets.is_empty() {
        return Ok(Vec::new());
    }
    let (values, vectors) = coupling.eigenvectors()?;
    let root = c.inverse_root()?;
    let others: Vec<usize> = (0..values.len())
        .filter(|&j| (values[j] - 1.0).norm() > 1e-9)
        .collect();
    let mut modes = Vec::new();
    for target in targets {
        let Some(choice) = target.choose(others.iter().map(|&j| (values[j].re, values[j].im)))
        else {
            continue;
        };
        let j = others[choice];
        let lambda = values[j];
        // t = F t', F (I−Ĥ) t' = t − C⁻¹H t, and (λ−1) u
        let part = |f: fn(&c64) -> f64| {
            let t = product(
                &root,
                &Mat::from_fn(values.len(), 1, |i, _| f(&vectors[(i, j)])),
            );
            let mut w = t.clone();
            if let Some(h) = &blocks.h {
                let image = product(h, &column(&t));
                let mut scaled = vec![0.0; t.len()];
                c.solve(
                    &image,
                    &mut scaled,
                    &mut vec![0.0; Preconditioner::work_len(c)],
                );
                w.iter_mut().zip(&scaled).for_each(|(w, s)| *w -= s);
            }
            let force = product(&blocks.b1, &column(&w));
            let mut u = vec![0.0; force.len()];
            inner.solve(&force, &mut u, &mut vec![0.0; inner.work_len()]);
            (u, t)
        };
        let (mut u, t) = part(|v| v.re);
        let im = (lambda.im != 0.0).then(|| part(|v| v.im));
        let shifted = lambda - 1.0;
        let im = im.map(|(mut v, s)| {
            for (u, v) in u.iter_mut().zip(&mut v) {
                let quotient = c64::new(*u, *v) / shifted;
                (*u, *v) = (quotient.re, quotient.im);
            }
            (v, s)
        });
        if im.is_none() {
            u.iter_mut().for_each(|u| *u /= shifted.re);
        }
        let im = im.map(|(v, s)| [v, s].concat());
        modes.push(judge.mode(lambda, [u, t].concat(), im));
    }
    Ok(modes)
}

/// Modes of a dense matrix that is similar to M⁻¹𝒜; `back` makes a vector of unknowns of one of its own.
pub(super) fn of_dense(
    targets: &[ModeTarget],
    matrix: &Mat<f64>,
    back: impl Fn(&[f64]) -> Vec<f64>,
    judge: &Judge<'_>,
) -> Result<Vec<Mode>, SetupError> {
    if targets.is_empty() {
        return Ok(Vec::new());
    }
    let (values, vectors) = dense::general_eigen(matrix.as_ref())?;
    let chosen = targets
        .iter()
        .filter_map(|t| t.choose(values.iter().map(|v| (v.re, v.im))));
    Ok(chosen
        .map(|j| {
            let part = |f: fn(&c64) -> f64| -> Vec<f64> {
                back(&vectors.col(j).iter().map(f).collect::<Vec<f64>>())
            };
            let im = (values[j].im != 0.0).then(|| part(|v| v.im));
            judge.mode(values[j], part(|v| v.re), im)
        })
        .collect())
}

fn column(v: &[f64]) -> Mat<f64> {
    Mat::from_fn(v.len(), 1, |i, _| v[i])
}

fn product(s: &fracas_operators::sparse::SparseMatrix<f64>, v: &Mat<f64>) -> Vec<f64> {
    dense::sparse_multiply(s, v.as_ref())
        .col(0)
        .iter()
        .copied()
        .collect()
}

/// Measures residuals with M⁻¹𝒜 itself.
pub(super) struct Judge<'a> {
    pub(super) operator: &'a Preconditioned<'a>,
    pub(super) scales: &'a [f64],
    pub(super) layout: Layout,
}

impl Judge<'_> {
    /// Scales a vector and measures its residual.
    fn mode(&self, lambda: c64, x: Vec<f64>, y: Option<Vec<f64>>) -> Mode {
        let layout = self.layout;
        let y = y.unwrap_or_else(|| vec![0.0; x.len()]);
        let image = |v: &[f64]| {
            let mut out = vec![0.0; v.len()];
            self.operator
                .apply(v, &mut out, &mut vec![0.0; self.operator.work_len()]);
            out
        };
        let (image_x, image_y) = (image(&x), image(&y));
        let (mut residual, mut energy) = (0.0, 0.0);
        let mut energies = layout.values(0.0);
        let mut largest = (0.0, 0);
        for i in 0..x.len() {
            let d = self.scales[i];
            let r_x = image_x[i] - lambda.re * x[i] + lambda.im * y[i];
            let r_y = image_y[i] - lambda.re * y[i] - lambda.im * x[i];
            residual += (d * r_x).powi(2) + (d * r_y).powi(2);
            let share = (d * x[i]).powi(2) + (d * y[i]).powi(2);
            energy += share;
            let of_field = |field, sum| match layout.range(field).contains(&i) {
                true => sum + share,
                false => sum,
            };
            energies = energies.map(of_field);
            if share > largest.0 {
                largest = (share, i);
            }
        }
        // Re(v · conj(v_i) / |v_i|) for the entry i of largest energy
        let (a, b) = (x[largest.1], y[largest.1]);
        let scale = a.hypot(b) * energy.sqrt();
        let part = |range: std::ops::Range<usize>| -> Vec<f64> {
            range.map(|i| (x[i] * a + y[i] * b) / scale).collect()
        };
        Mode {
            eigenvalue: (lambda.re, lambda.im),
            u: part(layout.range(U)),
            t: part(layout.range(T)),
            p: match layout.length(P) {
                0 => Vec::new(),
                _ => part(layout.range(P)),
            },
            traction_share: match energies.get(P) {
                Some(_) => energies[T] / energy,
                None => (energy - energies[U]) / energy,
            },
            pressure_share: energies.get(P).map(|p| p / energy),
            residual: (residual / energy).sqrt(),
        }
    }
}
