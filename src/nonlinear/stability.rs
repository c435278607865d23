//! Slip that runs away under weakening: the tangent of the patch that slips is not positive definite.

use super::active_set::{Log, Settled};
use super::arrest::arrest;
use super::newton::{Attempt, Iterate};
use super::tried::tried;
use super::{ContactProblem, Event, Failure, LinearFailure, Load};
use crate::analytic::{Rock, nucleation_half_length};
use crate::contact::ContactState;
use fracas_operators::vector::norm_inf;
use fracas_solvers::Observer;
use fracas_solvers::eigen::{Lanczos, LanczosSettings};
use std::ops::ControlFlow;

/// Loss of strength in a step, relative to the largest traction, below which nothing has weakened. Unit: 1.
const NOTHING: f64 = 1e-5;

/// Relative residual of its linear solves. Unit: 1.
pub(super) const SOLVED: f64 = 1e-6;

/// Error of the largest ratio, relative to it, at which it stands. Unit: 1.
const STANDS: f64 = 1e-3;

/// Iterations in which it does.
const MOST: usize = 30;

/// Share of the largest slip of the mode that a face of the patch has at least. Unit: 1.
const OF_PATCH: f64 = 0.1;

/// Halvings over which slip that runs away is compared.
pub(super) const COMPARED: usize = 3;

/// True where halving the increment up to three times leaves more than `2^(−1/4)` of the largest slip each time. Slip that follows
/// the loads falls with them, at the end of a stable path with their square root; a jump stays. Where nothing is left to
/// halve, what no increment has avoided is shown as well.
pub(super) fn is_shown(runaways: &[[f64; 2]]) -> bool {
    let first = runaways.len().saturating_sub(1 + COMPARED);
    match (runaways.get(first), runaways.last()) {
        (Some([long, much]), Some([short, little])) => *little >= much * (short / long).powf(0.25),
        _ => false,
    }
}

/// A patch whose strength falls faster with slip than the stress that drives it.
#[derive(Clone, Debug, PartialEq)]
pub struct Instability {
    /// Fracture on which it slips most.
    pub fracture: String,
    /// Faces of the patch.
    pub faces: usize,
    /// Its centre [m].
    pub center: [f64; 3],
    /// Largest side of the box around the centres of its faces, a face wider [m].
    pub extent: f64,
    /// Strength lost per slip W, the mean over the patch [Pa/m].
    pub slope: f64,
    /// Largest eigenvalue ρ of `W A_f z = ρ K z`, at least: above 1 K − W A_f has a direction of negative curvature.
    pub ratio: f64,
    /// Half-length `0.578887 G/((1−ν) W)` from which slip runs away, softer side [m].
    pub nucleation: f64,
    /// Largest slip of the step [m].
    pub slip: f64,
    /// The faces slip so in equilibrium; else at states that were tried, and ρ and the patch are those of these states.
    pub settled: bool,
}

impl std::fmt::Display for Instability {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        let [x, y, z] = self.center;
        write!(
            f,
            "{}on fracture \"{}\" {} faces around ({x:.6}, {y:.6}, {z:.6}) m, {:.6} m wide, lose {:.3e} Pa of strength per metre of slip, {:.3} times what the rock around gives back (nucleation half-length {:.6} m)",
            if self.settled {
                ""
            } else {
                "at states that were tried "
            },
            self.fracture,
            self.faces,
            self.extent,
            self.slope,
            self.ratio,
            self.nucleation
        )
    }
}

/// What holds faces: multipliers, or springs.
pub(super) trait Holding {
    /// States that settle.
    fn settle(
        &mut self,
        attempt: &Attempt<'_>,
        states: Vec<ContactState>,
        x: Iterate,
        log: &mut Log,
        observer: &mut dyn Observer,
    ) -> Result<Settled, Failure>;

    /// K⁻¹, linear around x, where the faces that slip in these states do so in the direction of their shear and hold limits that
    /// nothing moves.
    fn at_limits<'a>(
        &'a mut self,
        attempt: &'a Attempt<'_>,
        at: (&'a [ContactState], &Iterate),
    ) -> AtLimits<'a>;
}

/// Displacements that follow where the limits of these faces fall by so much [Pa].
pub(super) type AtLimits<'a> =
    Box<dyn FnMut(&[Weak], &[f64], &mut dyn Observer) -> Result<Vec<f64>, Failure> + 'a>;

/// Where slip that runs away is looked for.
#[derive(Clone, Copy)]
pub(super) enum Slipping<'a> {
    /// In equilibrium: the largest traction so far and the tractions at the start of the step [Pa], and the jumps that the laws of the
    /// faces see [m].
    Settled {
        traction: f64,
        before: &'a [f64],
        effective: &'a [f64],
    },
    /// At the start of a step, whose faces [near their limits](super::tried) are to slip from there on.
    FromRest,
}

/// States that settle, and whether slip runs away there; where none do, whether it would at those tried.
pub(super) fn stable(
    attempt: &Attempt<'_>,
    states: Vec<ContactState>,
    x: Iterate,
    holding: &mut impl Holding,
    log: &mut Log,
    observer: &mut dyn Observer,
) -> Result<Settled, Failure> {
    if !attempt.problem.weakens() {
        return holding.settle(attempt, states, x, log, observer);
    }
    let start = x.clone();
    log.unstable = None;
    log.changing.clear();
    log.most_slipping.clear();
    let from = (states.clone(), x.clone());
    let settled = match holding.settle(attempt, states, x, log, observer) {
        Err(reason) => arrest(attempt, from, reason, holding, (log, observer)),
        settled => settled,
    };
    match settled {
        Ok(mut settled) => {
            let found = Slipping::Settled {
                traction: settled.traction,
                before: &start.t,
                effective: &settled.effective,
            };
            let opened = before_opening(attempt, &settled, &start);
            let own = (&settled.states[..], &settled.x);
            let opened = opened.as_ref().map(|(states, x)| (&states[..], x));
            let mut unstable = None;
            // those that opened slip in no equilibrium, whose tangent may be singular
            for at in opened.into_iter().chain([own]) {
                match instability(attempt, at, found, holding, observer) {
                    Err(Failure::Linear(
                        reason @ (LinearFailure::Breakdown(_)
                        | LinearFailure::IterationLimit { .. }),
                    )) => log.events.push(Event::Unknown {
                        reason: reason.to_string(),
                    }),
                    patch => {
                        unstable = patch?;
                        break;
                    }
                }
            }
            settled.unstable = unstable;
            Ok(settled)
        }
        Err(reason) => {
            if log.asks && reason.may_be_of_slip() && !log.states.is_empty() {
                log.unstable = tried(attempt, &start, holding, log, observer)?;
            }
            Err(reason)
        }
    }
}

/// The states and the iterate in which faces that weaken, and that the step has opened, slip under their tractions of the start: they
/// slipped before they opened, and an open face has no strength left to lose. `None` where none opened.
fn before_opening(
    attempt: &Attempt<'_>,
    settled: &Settled,
    start: &Iterate,
) -> Option<(Vec<ContactState>, Iterate)> {
    let opened: Vec<usize> = (0..settled.states.len())
        .filter(|f| settled.states[*f] == ContactState::Open && start.t[3 * f] < 0.0)
        .filter(|f| (attempt.problem.friction_in(*f, attempt.start).weakening).is_some())
        .collect();
    if opened.is_empty() {
        return None;
    }
    let (mut states, mut x) = (settled.states.clone(), settled.x.clone());
    for f in opened {
        states[f] = ContactState::Slip;
        x.t[3 * f..3 * f + 3].copy_from_slice(&start.t[3 * f..3 * f + 3]);
    }
    Some((states, x))
}

/// The patch that runs away at these states, if one does.
///
/// With slip frozen in its directions m and every limit given, an increase of all limits by τ holds back the slip
/// `K⁻¹ A_f τ`; slip z takes `W z` from the limits, so that `z ← K⁻¹ A_f W z` grows without bound where `ρ(K⁻¹ A_f W) > 1`: then
/// `zᵀ(K − A_f W) z < 0` for its mode. W is the rate at the slip of the start of the step and the larger pressure of start and end, which
/// no rate along it exceeds where the pressure between them does not: where it shows nothing, the patch has been stable all the way.
///
/// ρ comes from Lanczos on `(A_f W)^½ K⁻¹ (A_f W)^½` from the slip at hand. A Ritz value is a lower bound, so that one above 1 is a proof
/// where K is symmetric (the normal tractions stay).
///
/// # Cost
/// A linear system per iteration; none where nothing has weakened.
pub(super) fn instability(
    attempt: &Attempt<'_>,
    (states, x): (&[ContactState], &Iterate),
    slipping: Slipping<'_>,
    holding: &mut impl Holding,
    observer: &mut dyn Observer,
) -> Result<Option<Box<Instability>>, Failure> {
    let problem = attempt.problem;
    let faces: Vec<Weak> = (0..states.len())
        .filter(|f| states[*f].constrained() == 1)
        .filter_map(|f| Weak::new(attempt, f, x, slipping))
        .collect();
    let lost = faces.iter().map(|face| face.rate * face.slip);
    let lost = lost.fold(0.0, f64::max);
    let nothing = match slipping {
        Slipping::Settled { traction, .. } => NOTHING * traction,
        Slipping::FromRest => 0.0,
    };
    if lost <= nothing {
        return Ok(None);
    }
    let mut at_limits = holding.at_limits(attempt, (states, x));
    // (A_f W)^½
    let weight = |face: &Weak| (problem.faces()[face.face].area * face.rate).sqrt();
    let weights: Vec<f64> = faces.iter().map(weight).collect();
    let start = faces.iter().zip(&weights).map(|(face, w)| w * face.slip);
    let settings = LanczosSettings {
        tolerance: STANDS,
        max_steps: MOST.min(faces.len()),
        patience: 1,
        ..LanczosSettings::one_sided()
    };
    // K is that of a body, so that what fails is not finite
    let Ok(mut lanczos) = Lanczos::from_start(start.collect(), settings) else {
        return Ok(None);
    };
    let ratio = loop {
        let Ok(next) = lanczos.next_vector() else {
            return Ok(None);
        };
        match next {
            ControlFlow::Break((_, largest)) => break largest.value,
            ControlFlow::Continue(v) => {
                let drop = faces.iter().zip(v).zip(&weights);
                let drop: Vec<f64> = drop.map(|((face, v), w)| face.rate * v / w).collect();
                let u = at_limits(&faces, &drop, observer)?;
                let slip = slip_of(problem, &u, &faces);
                lanczos.take(slip.iter().zip(&weights).map(|(slip, w)| w * slip));
            }
        }
    };
    if ratio <= 1.0 + SOLVED {
        return Ok(None);
    }
    let Ok(mode) = lanczos.largest_vector() else {
        return Ok(None);
    };
    let mode: Vec<f64> = mode.iter().zip(&weights).map(|(v, w)| v / w).collect();
    let size = norm_inf(&mode);
    let mode: Vec<f64> = mode.iter().map(|z| z / size).collect();
    let patch = patch(problem, &faces, &mode, ratio);
    Ok(Some(Box::new(match slipping {
        Slipping::Settled { .. } => patch,
        // none was found where none settled
        Slipping::FromRest => Instability {
            slip: 0.0,
            settled: false,
            ..patch
        },
    })))
}

/// A face that slips and weakens.
pub(super) struct Weak {
    pub(super) face: usize,
    /// That of its shear.
    pub(super) direction: [f64; 2],
    /// −∂τ_L/∂s along m at the slip of the start of the step and its larger pressure [Pa/m].
    rate: f64,
    /// Slip of the step along m; from rest as far as any other [m].
    slip: f64,
}

impl Weak {
    /// `None` for a face that does not weaken.
    fn new(attempt: &Attempt<'_>, f: usize, x: &Iterate, slipping: Slipping<'_>) -> Option<Self> {
        let t = [x.t[3 * f + 1], x.t[3 * f + 2]];
        let shear = t[0].hypot(t[1]);
        let m = t.map(|t| t / shear);
        let so_far = attempt.problem.so_far(f, attempt.start);
        let before = so_far.slip();
        let friction = attempt.problem.friction_in(f, attempt.start);
        let end = x.t[3 * f];
        let (moved, slip, normal) = match slipping {
            Slipping::Settled {
                effective,
                before: start,
                ..
            } => {
                let moved = [1, 2].map(|k| effective[3 * f + k] - attempt.start.jump[3 * f + k]);
                let slip = m[0] * moved[0] + m[1] * moved[1];
                (moved, slip, end.min(start[3 * f]))
            }
            Slipping::FromRest => ([0.0; 2], 1.0, end),
        };
        // ds/dΔg along m; slip that turns back heals where friction follows the vector
        let along = so_far.after(moved).share(m);
        let rate = -friction.by_slip(normal, before) * along;
        let weakens = shear > 0.0 && slip > 0.0 && rate > 0.0;
        weakens.then_some(Self {
            face: f,
            direction: m,
            rate,
            slip,
        })
    }
}

/// Mean tangential jumps along m that displacements make [m].
fn slip_of(problem: &ContactProblem<'_>, u: &[f64], faces: &[Weak]) -> Vec<f64> {
    let none = Load {
        force: Vec::new(),
        jump: vec![0.0; 3 * problem.faces().len()],
    };
    let jumps = problem.jumps(u, &none);
    let along = |face: &Weak| {
        let i = 3 * face.face + 1;
        face.direction[0] * jumps[i] + face.direction[1] * jumps[i + 1]
    };
    faces.iter().map(along).collect()
}

/// What a mode, its largest slip 1, says of where it slips.
fn patch(problem: &ContactProblem<'_>, faces: &[Weak], mode: &[f64], ratio: f64) -> Instability {
    let body = problem.body();
    let of_patch = || {
        let pairs = faces.iter().zip(mode);
        pairs.filter(|(_, z)| z.abs() >= OF_PATCH)
    };
    let (mut area, mut slope, mut center) = (0.0, 0.0, [0.0; 3]);
    let mut corners = [[f64::INFINITY; 3], [f64::NEG_INFINITY; 3]];
    let (mut widest, mut slip, mut nucleation) = (0.0f64, 0.0f64, f64::INFINITY);
    let mut most = (0.0, 0);
    for (weak, z) in of_patch() {
        let face = &problem.faces()[weak.face];
        area += face.area;
        slope += face.area * weak.rate;
        slip = slip.max(weak.slip);
        widest = widest.max(face.area.sqrt());
        if z.abs() > most.0 {
            most = (z.abs(), usize::from(face.fracture));
        }
        for k in 0..3 {
            center[k] += face.area * face.center[k];
            corners[0][k] = corners[0][k].min(face.center[k]);
            corners[1][k] = corners[1][k].max(face.center[k]);
        }
    }
    for (weak, _) in of_patch() {
        for element in [
            &problem.faces()[weak.face].minus,
            &problem.faces()[weak.face].plus,
        ] {
            let region = usize::from(body.mesh.regions[element.element as usize]);
            let material = &body.materials[region];
            let rock = Rock {
                young: material.young,
                poisson: material.poisson,
            };
            nucleation = nucleation.min(nucleation_half_length(rock, slope / area));
        }
    }
    let side = (0..3).map(|k| corners[1][k] - corners[0][k]);
    Instability {
        fracture: (body.fractures.names.get(most.1))
            .cloned()
            .unwrap_or_default(),
        faces: of_patch().count(),
        center: center.map(|x| x / area),
        extent: side.fold(0.0, f64::max) + widest,
        slope: slope / area,
        ratio,
        nucleation,
        slip,
        settled: true,
    }
}
