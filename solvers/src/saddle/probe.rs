//! A look for eigenvalues of M⁻¹𝒜 close to zero.

use super::error_judge::TRUSTED;
use super::of_tractions::OfTractions;
use super::remainder::ELIMINATED_IN_DOUBT;
use super::{EnergyNorms, T, U};
use crate::krylov::{Breakdown, Criteria, KrylovMethod, System, least};
use crate::{Observer, Step};
use fracas_operators::vector::axpy;

/// Steps of the first look: well separated eigenvalues are found to a few per cent. Unit: 1.
const STEPS: usize = 40;

/// Most steps of a look: then what is found stands, settled or not. Unit: 1.
const MOST: usize = 320;

/// Share of the value before above which twice the steps found nothing new. Unit: 1.
const SETTLED: f64 = 0.7;

/// Smallest eigenvalue of `diag(C_0 + H)⁻¹ (C_0 + H)` below which a C of the size of that diagonal may leave an eigenvalue of M⁻¹𝒜 that b does
/// not show. Scenes of the gallery with cubes have 0.025 or more. Where a fracture is one or two cells high and cells are 1:300 or flatter, a
/// traction that is constant on it has 3e-6 to 8e-5, and was wrong by 7 to 78 % with errors of 6e-6 to 4e-4 said. Unit: 1.
const SUSPECT: f64 = 0.02;

/// Most times that such tractions are corrected by M: then what is left of them counts as all but lost. Unit: 1.
const CORRECTIONS: usize = 20;

/// Relative residual of a look that has seen how far 𝒜⁻¹w grows. Unit: 1.
const SOLVED: f64 = 1e-8;

/// Times that 𝒜⁻¹w may be longer than M⁻¹w before it hides errors. Unit: 1.
const GROWN: f64 = 2.0;

/// What of such tractions corrections may leave without any more looking.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Left {
    /// A twentieth: of one solve, which is told to be accurate.
    Little,
    /// Half: of a run, for which a look would take several times its memory.
    Half,
}

impl Left {
    /// Unit: 1.
    fn share(self) -> f64 {
        match self {
            Self::Little => 0.05,
            Self::Half => 0.5,
        }
    }
}

/// What was found, and its cost.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct Probed {
    /// Ritz value nearest to zero; `None` from methods that know none.
    pub ritz: Option<f64>,
    /// What stands for such a value where M⁻¹𝒜 is far from normal: [`TRUSTED`] over the most that an error may be longer than M⁻¹r by what
    /// 𝒜⁻¹w has grown to.
    pub hidden: Option<f64>,
    /// Products with 𝒜.
    pub products: u64,
    /// Solves with M.
    pub solves: u64,
}

/// Steps of `method` towards 𝒜⁻¹w for a random w, with its share of every eigenvector (the displacements' part of it where 𝒜 is of
/// displacements alone), around an M of one level
/// ([`local`](fracas_operators::Properties)), or in f32 where A spreads over most of its digits, or where H leaves a traction all but free
/// that its diagonal holds (flat cells), unless M corrects it or the iteration has `seen` it; nothing around others, which leave few
/// small eigenvalues. 40 steps, and where they find M poor twice as many until the value settles, or 320.
///
/// An iteration sees a small eigenvalue only through the share that b has of its vector. Where b is what holds stiff rock, soft
/// rock has a share of 1e-8 or less, below any tolerance, and errors there are not seen either: M⁻¹r is the error times that
/// eigenvalue.
///
/// Where 𝒜 is not symmetric and too large to be eliminated, Ritz values say little: rows of B2 of which each has a multiple of the next left t wrong by
/// 49,500 tolerances beside one of 0.54. There the look goes on until it has 𝒜⁻¹w, and each field of k unknowns that is g > 2 times as long as in M⁻¹w
/// may hide errors of g√k times M⁻¹r: w has a share of 1/√k of the vector that grows, and r may be that vector.
pub fn probe(
    method: &dyn KrylovMethod<f64>,
    system: &System<'_, f64>,
    norms: &EnergyNorms<'_>,
    (seen, left): (Option<f64>, Left),
    observer: &mut dyn Observer,
) -> Probed {
    let m = system.preconditioner.properties();
    let mut probed = Probed::default();
    let is_rough = m.local || m.single && norms.stiffness().exceeds_single();
    let may_grow = norms.is_unsymmetric() && system.size() > ELIMINATED_IN_DOUBT;
    if !is_rough && !may_grow && !may_hide(system, norms, (seen, left), &mut probed) {
        return probed;
    }
    let mut w = norms.random_residual();
    w.truncate(system.size());
    leave_unmoving(system, norms, &mut w);
    let system = System { rhs: &w, ..*system };
    let mut steps = STEPS;
    loop {
        let (found, x) = look(method, &system, steps, observer);
        let is_settled = match (probed.ritz, found.seen.ritz) {
            (Some(before), Some(ritz)) => ritz > SETTLED * before,
            (None, Some(ritz)) => ritz >= TRUSTED,
            (_, None) => true,
        };
        probed = Probed {
            ritz: least([probed.ritz, found.seen.ritz]),
            hidden: None,
            products: probed.products + found.seen.products,
            solves: probed.solves + found.seen.solves,
        };
        let is_solved = !may_grow || found.relative_residual <= SOLVED;
        if is_settled && is_solved || steps >= MOST {
            probed.hidden = may_grow.then(|| grown(&system, norms, &x)).flatten();
            return probed;
        }
        steps *= 2;
    }
}

/// [`Probed::hidden`] of x = 𝒜⁻¹w.
fn grown(system: &System<'_, f64>, norms: &EnergyNorms<'_>, x: &[f64]) -> Option<f64> {
    let m = system.preconditioner;
    let mut e = vec![0.0; x.len()];
    m.solve(system.rhs, &mut e, &mut vec![0.0; m.work_len()]);
    let (first, last) = (norms.error(&e), norms.error(x));
    let layout = norms.layout();
    let most = last
        .iter()
        .fold(0.0f64, |most, (field, last)| match last / first[field] {
            growth if growth > GROWN => most.max(growth * (layout.length(field) as f64).sqrt()),
            _ => most,
        });
    (most > 0.0).then(|| TRUSTED / most)
}

/// The Ritz value nearest to zero of so many steps of `method` towards 𝒜⁻¹b.
pub fn nearest_eigenvalue(
    method: &dyn KrylovMethod<f64>,
    system: &System<'_, f64>,
    steps: usize,
    observer: &mut dyn Observer,
) -> Option<f64> {
    look(method, system, steps, observer).0.seen.ritz
}

/// A look, and the relative residual that it ended at.
struct Look {
    seen: Probed,
    relative_residual: f64,
}

/// Nothing where tractions move nothing, between nodes that are held: H alone determines those, up to a constant, with the eigenvalue 0. b has
/// nothing of that vector, nor has what follows from a w without it.
fn leave_unmoving(system: &System<'_, f64>, norms: &EnergyNorms<'_>, w: &mut [f64]) {
    let layout = norms.layout();
    let tractions = layout.range(T);
    if tractions.end > w.len() {
        return;
    }
    // B2 of random displacements vanishes in empty rows alone
    let mut displaced = vec![0.0; w.len()];
    displaced[layout.range(U)].copy_from_slice(&w[layout.range(U)]);
    let mut image = vec![0.0; w.len()];
    let mut work = vec![0.0; system.operator.work_len()];
    system.operator.apply(&displaced, &mut image, &mut work);
    for i in tractions {
        if image[i] == 0.0 {
            w[i] = 0.0;
        }
    }
}

/// True where an eigenvalue close to zero may be none of those `seen`, because H alone holds some tractions, and little of what its diagonal
/// and C_0 hold. Across flat cells C_0 + H does ([`SUSPECT`]); where M in f32 has left small eigenvalues elsewhere there may be others yet
/// (fractures along flat cells have jumps beyond any traction, which coarse levels hold back: 1e-4 beside a Ritz value of 0.03).
///
/// `B1ᵀ diag(A)⁻¹ B1 + H` does, of known entries, where tractions that each move something move next to nothing together, as those of faces
/// around an edge may, beside an H far smaller than C_0: t was wrong by 4e-5 where 2e-7 was said.
///
/// # Cost
/// None where h is below 49 c_0 everywhere and the entries are not known; else 90 to 140 products with `C_0 + H` or `B1ᵀ diag(A)⁻¹ B1 + H`, and
/// where there are such tractions up to 20 with 𝒜 and solves with M, about five where M holds them.
fn may_hide(
    system: &System<'_, f64>,
    norms: &EnergyNorms<'_>,
    (seen, left): (Option<f64>, Left),
    probed: &mut Probed,
) -> bool {
    let place = norms.layout().range(T);
    if place.is_empty() || place.end > system.size() {
        return false;
    }
    let is_single = system.preconditioner.properties().single;
    let is_poor = is_single && seen.is_some_and(|seen| seen < TRUSTED);
    let alone = norms.of_tractions();
    // 1/(1 + max h/c) bounds the spectrum from below
    alone.may_fall_below(SUSPECT) && (is_poor || keeps(system, norms, &alone, left, probed))
        || (norms.of_moving_tractions())
            .is_some_and(|moving| keeps(system, norms, &moving, left, probed))
}

/// Whether there are tractions of which little is held, and `e ← e − M⁻¹𝒜e` leaves of them what it began with.
fn keeps(
    system: &System<'_, f64>,
    norms: &EnergyNorms<'_>,
    of_tractions: &OfTractions<'_>,
    least_left: Left,
    probed: &mut Probed,
) -> bool {
    let place = norms.layout().range(T);
    let (operator, m) = (system.operator, system.preconditioner);
    let (y, least) = of_tractions.lowest(SUSPECT);
    // NaN is looked at, too
    if least > SUSPECT {
        return false;
    }
    let mut e = vec![0.0; system.size()];
    e[place.clone()].copy_from_slice(&y);
    let [mut r, mut z] = [0; 2].map(|_| vec![0.0; e.len()]);
    let mut work = vec![0.0; operator.work_len().max(m.work_len())];
    let first = of_tractions.norm(&y);
    let (mut before, mut kept) = (first, 0);
    for _ in 0..CORRECTIONS {
        operator.apply(&e, &mut r, &mut work);
        // M in f32 holds no more than 38 orders
        let size = system.norm2(&r);
        r.iter_mut().for_each(|r| *r /= size);
        m.solve(&r, &mut z, &mut work);
        axpy(-size, &z, &mut e);
        probed.products += 1;
        probed.solves += 1;
        let left = of_tractions.norm(&e[place.clone()]);
        if left <= least_left.share() * first {
            return false;
        }
        // NaN is kept, too
        let falls = left <= (1.0 - TRUSTED) * before;
        kept = if falls { 0 } else { kept + 1 };
        // one step alone may be that of a transient
        if kept == 2 {
            return true;
        }
        before = left;
    }
    true
}

/// One look of that many steps, and where they lead.
fn look(
    method: &dyn KrylovMethod<f64>,
    system: &System<'_, f64>,
    steps: usize,
    observer: &mut dyn Observer,
) -> (Look, Vec<f64>) {
    let criteria = Criteria {
        relative_tolerance: f64::EPSILON,
        max_iterations: steps,
    };
    let mut watch = |step: &Step| match step {
        Step::Krylov { iteration, .. } => observer.observe(&Step::Progress {
            stage: "looking for small eigenvalues",
            done: *iteration,
            total: steps,
        }),
        other => observer.observe(other),
    };
    let mut x = vec![0.0; system.size()];
    let found = match method.solve(system, &criteria, &mut x, &mut watch) {
        Ok(report) => Look {
            seen: Probed {
                ritz: report.smallest_ritz,
                hidden: None,
                products: report.products,
                solves: report.preconditioner_solves,
            },
            relative_residual: report.relative_residual,
        },
        Err(breakdown) => {
            // rounding leaves no more to gain, and another look would do the same
            let (ritz, relative_residual) = match breakdown {
                Breakdown::Stagnation { smallest_ritz, .. } => (smallest_ritz, 0.0),
                _ => (None, 0.0),
            };
            let steps = breakdown.iteration() as u64;
            Look {
                seen: Probed {
                    ritz,
                    hidden: None,
                    products: steps,
                    solves: steps,
                },
                relative_residual,
            }
        }
    };
    (found, x)
}
