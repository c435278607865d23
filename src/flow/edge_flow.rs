//! What flows across an edge, or half of one, and its derivatives.

use super::network::Arm;
use super::vertex::Around;

/// An edge, or half of one, at given conductivities and potentials. Each arm brings `F_k = τ_k u_k`, and nothing is left:
/// ```text
/// F_kl = τ_k τ_l/(Σ τ) (u_k − u_l)      u_k = Φ_k − Φ_e      around a vertex: u_k = λ_k Σ_j W_kj (Φ_k − π_j)/τ_k
/// ```
pub(super) struct EdgeFlow<'n> {
    pub(super) arms: &'n [Arm],
    /// τ per arm [m³/(Pa s)].
    pub(super) tau: &'n [f64],
    /// Σ τ.
    pub(super) total: f64,
    /// Φ_e where nothing comes in or goes out [Pa].
    pub(super) shut: f64,
    /// Φ_e [Pa].
    pub(super) potential: f64,
    /// Its pressure is prescribed.
    pub(super) held: bool,
    /// What comes in here, shared by τ, where the rate of a well is [m³/s].
    pub(super) inflow: f64,
    /// Number of the well that it is.
    pub(super) well: Option<usize>,
    pub(super) middle: [f64; 3],
    /// Potential per face [Pa].
    pub(super) potentials: &'n [f64],
    /// The vertex that decides on it, and the number of its first arm there; none: two-point fluxes.
    pub(super) around: Option<(&'n Around<'n>, usize)>,
}

/// What goes from a face to another, or to an edge of prescribed pressure: `weight · drop` [m³/s].
pub(super) struct Passing {
    /// The face that it leaves.
    pub(super) from: usize,
    /// The face that it comes to; none: the edge.
    pub(super) to: Option<usize>,
    /// [m³/(Pa s)].
    pub(super) weight: f64,
    /// [Pa].
    pub(super) drop: f64,
    /// Sizes of the potentials whose difference the drop is [Pa].
    pub(super) apart: f64,
}

impl EdgeFlow<'_> {
    fn face(&self, arm: usize) -> usize {
        self.arms[arm].face as usize
    }

    /// Every pair of arms that is no more than one, or of an arm and the edge: `(k, l or none, weight)`.
    fn pairs(&self) -> impl Iterator<Item = (usize, Option<usize>, f64)> + '_ {
        let n = self.arms.len();
        let held = (0..n).filter(|_| self.held).map(|k| (k, None, self.tau[k]));
        let between = (0..n).filter(|_| !self.held).flat_map(move |k| {
            (k + 1..n).map(move |l| (k, Some(l), self.tau[k] * self.tau[l] / self.total))
        });
        held.chain(between)
    }

    /// `F_kl` of every pair.
    pub(super) fn passing(&self) -> impl Iterator<Item = Passing> + '_ {
        self.pairs().map(|(k, l, weight)| {
            let [drop, apart] = match self.around {
                Some((around, first)) => {
                    let [from, size] = around.drop(first + k);
                    let [to, other] = l.map_or([0.0; 2], |l| around.drop(first + l));
                    [from - to, size + other]
                }
                None => {
                    let from = self.potentials[self.face(k)];
                    let to = l.map_or(self.potential, |l| self.potentials[self.face(l)]);
                    [from - to, from.abs() + to.abs()]
                }
            };
            Passing {
                from: self.face(k),
                to: l.map(|l| self.face(l)),
                weight,
                drop,
                apart,
            }
        })
    }

    /// What leaves the face of every arm [m³/s].
    pub(super) fn fluxes(&self) -> impl Iterator<Item = (usize, f64)> + '_ {
        self.tau.iter().enumerate().map(|(k, tau)| {
            let drop = match self.around {
                Some((around, first)) => around.drop(first + k)[0],
                None => self.potentials[self.face(k)] - self.potential,
            };
            (self.face(k), tau * drop)
        })
    }

    /// What comes to the face of every arm by the rate of a well [m³/s]; nothing on other edges.
    pub(super) fn inflows(&self) -> impl Iterator<Item = (usize, f64)> + '_ {
        let arms = self
            .arms
            .iter()
            .zip(self.tau)
            .filter(|_| self.inflow != 0.0);
        arms.map(|(arm, tau)| (arm.face as usize, self.inflow * tau / self.total))
    }

    /// Derivatives of what leaves faces by potentials: `add(face, by the potential of which face, value)` [m³/(Pa s)].
    pub(super) fn by_potential(&self, mut add: impl FnMut(usize, usize, f64)) {
        if let Some((around, _)) = self.around {
            return self.sloping(&around.slopes().potential, |_| 1.0, add);
        }
        for (k, l, weight) in self.pairs() {
            let k = self.face(k);
            add(k, k, weight);
            if let Some(l) = l {
                let l = self.face(l);
                add(l, l, weight);
                add(k, l, -weight);
                add(l, k, -weight);
            }
        }
    }

    /// The same by what changes the mobility of a face m by `turn(m)`.
    pub(super) fn by_mobility(
        &self,
        turn: impl Fn(usize) -> f64,
        mut add: impl FnMut(usize, usize, f64),
    ) {
        if let Some((around, _)) = self.around {
            return self.sloping(&around.slopes().mobility, turn, add);
        }
        // F_k = τ_k (Φ_k − Φ_e), ∂Φ_e/∂τ_m = (Φ_m − Φ_e)/Σ τ
        for arm in self.arms {
            let m = arm.face as usize;
            let turned = turn(m) * arm.shape;
            if turned == 0.0 {
                continue;
            }
            let above = self.potentials[m] - self.potential;
            add(m, m, turned * above);
            if !self.held {
                for (other, tau) in self.arms.iter().zip(self.tau) {
                    let share = tau / self.total;
                    add(other.face as usize, m, -(turned * share * above));
                }
            }
        }
    }

    /// Derivatives of every pair from those of its arms, so that what leaves one face comes to the other.
    fn sloping(
        &self,
        slopes: &[f64],
        turn: impl Fn(usize) -> f64,
        mut add: impl FnMut(usize, usize, f64),
    ) {
        let Some((around, first)) = self.around else {
            return;
        };
        let count = around.corners();
        for column in 0..count {
            let m = around.face(column);
            let turned = turn(m);
            if turned == 0.0 {
                continue;
            }
            let of = |arm: usize| slopes[(first + arm) * count + column];
            for (k, l, weight) in self.pairs() {
                let per = |arm: usize| of(arm) / self.tau[arm];
                let value = turned * weight * (per(k) - l.map_or(0.0, per));
                add(self.face(k), m, value);
                if let Some(l) = l {
                    add(self.face(l), m, -value);
                }
            }
        }
    }
}
