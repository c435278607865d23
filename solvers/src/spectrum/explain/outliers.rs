//! Eigenvalues of M⁻¹𝒜 as the Krylov run sees them, and where the eigenvectors of the outer ones live.

use super::super::any_method::traction_scales;
use super::super::arnoldi::Ritz;
use super::super::product::{Preconditioned, energy_scales};
use crate::SetupError;
use crate::saddle::{P, SaddleBlocks, T};
use fracas_operators::Preconditioner;
use fracas_operators::laws::probe;
use fracas_operators::sparse::SparseMatrix;
use fracas_operators::vector::norm2;
use serde::Serialize;

/// Steps of Arnoldi.
const STEPS: usize = 40;

/// Residual of a Ritz value, relative to its modulus, below which it is taken for an eigenvalue.
const SETTLED: f64 = 0.1;

/// Moduli between which an eigenvalue is no outlier: M is there to make all of them 1. (The median of Ritz values is no
/// reference: they prefer the outer eigenvalues.)
const FAR: (f64, f64) = (0.1, 3.0);

/// Outliers that are located.
const LOCATED: usize = 3;

/// Share of the energy that a place must hold.
const MOST: f64 = 0.9;

/// Settled Ritz values θ of M⁻¹𝒜 on the Krylov space of M⁻¹b.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Seen {
    /// Ritz values whose residual is below a tenth of their modulus.
    pub settled: usize,
    /// All Ritz values.
    pub steps: usize,
    /// Smallest |θ|; null when none has settled.
    pub modulus_min: Option<f64>,
    /// Largest |θ|.
    pub modulus_max: Option<f64>,
    /// `max|θ| / min|θ|`: the measured κ.
    pub kappa: Option<f64>,
    /// Smallest Re θ; negative for an indefinite M⁻¹𝒜.
    pub re_min: Option<f64>,
    /// Number of θ with |θ| below 0.1 or above 3.
    pub n_outliers: usize,
    /// The three farthest, one of each conjugate pair.
    pub outliers: Vec<Outlier>,
}

/// A Ritz value far from the others.
#[derive(Clone, Debug, PartialEq, Serialize)]
pub struct Outlier {
    /// (Re θ, Im θ).
    pub eigenvalue: (f64, f64),
    /// Residual relative to |θ|.
    pub residual: f64,
    /// Share of t in the energy; that of u, and of p, is the rest.
    pub traction_share: f64,
    /// Share of p in the energy; none without flow.
    #[serde(skip_serializing_if = "Option::is_none")]
    pub pressure_share: Option<f64>,
    /// Where; null without coordinates.
    pub place: Option<Place>,
}

/// Where nine tenths of the energy are. A traction lives at the mean of the unknowns of its column of B1, weighted by |b|, and a pressure
/// at that of its column of Q1.
#[derive(Clone, Copy, Debug, PartialEq, Serialize)]
pub struct Place {
    /// Centre of the energy [m].
    pub centre: [f64; 3],
    /// Lower corner of the box [m].
    pub low: [f64; 3],
    /// Upper corner of the box [m].
    pub high: [f64; 3],
    /// Unknowns that carry it.
    pub unknowns: usize,
    /// `max a_ii / min a_ii` over displacements among them; 1 without any.
    pub contrast: f64,
}

impl Seen {
    pub(super) fn new(
        blocks: &SaddleBlocks,
        m: &dyn Preconditioner<f64>,
        rhs: &[f64],
    ) -> Result<Self, SetupError> {
        let operator = Preconditioned::new(blocks, m);
        let scales = energy_scales(blocks, &traction_scales(blocks));
        let n = scales.len();
        let mut start = vec![0.0; n];
        m.solve(rhs, &mut start, &mut vec![0.0; m.work_len()]);
        start.iter_mut().zip(&scales).for_each(|(x, d)| *x *= d);
        let norm = norm2(&start);
        if !(norm > 0.0 && norm.is_finite()) {
            start = probe(n, 31);
        }
        let ritz = Ritz::new(&operator, &scales, start, STEPS)?;
        let size = |j: usize| ritz.values[j].norm();
        let mut settled: Vec<usize> = (0..ritz.values.len())
            .filter(|&j| ritz.residual(j) <= SETTLED * size(j))
            .collect();
        settled.sort_by(|&i, &j| size(i).total_cmp(&size(j)));
        let modulus_min = settled.first().map(|&j| size(j));
        let modulus_max = settled.last().map(|&j| size(j));
        // 1 at the edge of the bulk
        let distance = |j: usize| (FAR.0 / size(j)).max(size(j) / FAR.1);
        let mut far: Vec<usize> = settled
            .iter()
            .copied()
            .filter(|&j| distance(j) > 1.0)
            .collect();
        far.sort_by(|&i, &j| distance(j).total_cmp(&distance(i)));
        let (places, layout) = (Places::of(blocks), blocks.layout());
        let outliers = far
            .iter()
            .filter(|&&j| ritz.values[j].im >= 0.0)
            .take(LOCATED)
            .map(|&j| {
                let energies = ritz.energies(j);
                let total: f64 = energies.iter().sum();
                let share = |field| {
                    let [energies] = layout.split([field], &energies);
                    energies.iter().sum::<f64>() / total
                };
                Outlier {
                    eigenvalue: (ritz.values[j].re, ritz.values[j].im),
                    residual: ritz.residual(j) / size(j),
                    traction_share: share(T),
                    pressure_share: blocks.flow.as_ref().map(|_| share(P)),
                    place: places.as_ref().map(|p| p.place(blocks, &energies)),
                }
            })
            .collect();
        Ok(Self {
            settled: settled.len(),
            steps: ritz.values.len(),
            modulus_min,
            modulus_max,
            kappa: modulus_min
                .zip(modulus_max)
                .map(|(low, high)| high / low)
                .filter(|kappa| kappa.is_finite()),
            re_min: settled.iter().map(|&j| ritz.values[j].re).reduce(f64::min),
            n_outliers: far.len(),
            outliers,
        })
    }
}

/// Positions of all unknowns.
struct Places(Vec<[f64; 3]>);

impl Places {
    fn of(blocks: &SaddleBlocks) -> Option<Self> {
        let mut positions: Vec<[f64; 3]> = blocks
            .coordinates
            .as_ref()?
            .iter()
            .map(|c| c.position)
            .collect();
        let means = |b: &SparseMatrix<f64>| {
            let mut sums = vec![([0.0; 3], 0.0); b.cols()];
            for (row, x) in b.outer_iterator().zip(&positions) {
                for (k, b) in row.iter() {
                    let (sum, weight) = &mut sums[k];
                    sum.iter_mut().zip(x).for_each(|(s, x)| *s += b.abs() * x);
                    *weight += b.abs();
                }
            }
            // a column without entries has no place
            let place = |(sum, weight): ([f64; 3], f64)| sum.map(|s| s / weight);
            sums.into_iter().map(place).collect::<Vec<_>>()
        };
        let tractions = means(&blocks.b1);
        let pressures = blocks.flow.as_ref().map(|flow| means(&flow.q1));
        positions.extend(tractions.into_iter().chain(pressures.into_iter().flatten()));
        Some(Self(positions))
    }

    /// The fewest unknowns with known places that carry nine tenths of the energy.
    fn place(&self, blocks: &SaddleBlocks, energies: &[f64]) -> Place {
        let mut order: Vec<usize> = (0..energies.len())
            .filter(|&i| self.0[i].iter().all(|x| x.is_finite()))
            .collect();
        order.sort_by(|&i, &j| energies[j].total_cmp(&energies[i]));
        let total: f64 = order.iter().map(|&i| energies[i]).sum();
        let mut place = Place {
            centre: [0.0; 3],
            low: [f64::INFINITY; 3],
            high: [f64::NEG_INFINITY; 3],
            unknowns: 0,
            contrast: 1.0,
        };
        let (mut held, mut soft, mut stiff) = (0.0, f64::INFINITY, 0.0f64);
        for i in order {
            if held >= MOST * total {
                break;
            }
            held += energies[i];
            place.unknowns += 1;
            for k in 0..3 {
                let x = self.0[i][k];
                place.centre[k] += energies[i] * x;
                place.low[k] = place.low[k].min(x);
                place.high[k] = place.high[k].max(x);
            }
            if i < blocks.n_u()
                && let Some(a_ii) = blocks.a.get(i, i).filter(|a| **a > 0.0)
            {
                soft = soft.min(*a_ii);
                stiff = stiff.max(*a_ii);
            }
        }
        place.centre.iter_mut().for_each(|x| *x /= held);
        if stiff > 0.0 {
            place.contrast = stiff / soft;
        }
        place
    }
}
