//! What a row brought to light.

use super::nested::Errors;
use super::outcome::Outcome;
use fracas::solve::Solved;
use fracas_solvers::multigrid::Summary;
use fracas_solvers::saddle::RelaxationSummary;
use fracas_solvers::spectrum::SpectrumReport;
use fracas_solvers::spectrum::condition::{Ends, StiffnessEnds};

/// A solve that came to an end, however it was counted.
pub(super) struct Run {
    /// n_it and C_s, where the tolerance was met.
    pub(super) iterations: Option<usize>,
    pub(super) cost: Option<f64>,
    pub(super) c_app: Option<f64>,
    pub(super) setup_s: f64,
    pub(super) solve_s: f64,
    pub(super) memory: Option<u64>,
    pub(super) hierarchy: Option<Summary>,
    pub(super) relaxation: RelaxationSummary,
    /// The iteration.
    pub(super) krylov: String,
    /// The method with its parts.
    pub(super) ran: String,
    /// Errors of u and t, as estimated.
    pub(super) estimates: [Option<f64>; 2],
    pub(super) x: Vec<f64>,
}

impl From<Solved> for Run {
    fn from(solved: Solved) -> Self {
        let mut ran = solved.method.clone();
        for part in [&solved.augmentation, &solved.inner].into_iter().flatten() {
            ran = format!("{ran} {part}");
        }
        Self {
            iterations: solved.has_converged().then_some(solved.iterations),
            cost: solved.c_s,
            c_app: Some(solved.c_app),
            setup_s: solved.setup_s,
            solve_s: solved.solve_s,
            memory: solved.peak_memory_bytes,
            relaxation: RelaxationSummary {
                gamma: solved.relaxation,
                degree: solved.relaxation_degree,
                ..RelaxationSummary::default()
            },
            krylov: solved.krylov.to_string(),
            ran: format!("{ran} {}", solved.krylov),
            estimates: [solved.error_u, solved.error_t],
            hierarchy: solved.amg,
            x: solved.x,
        }
    }
}

/// Facts about a contact state.
#[derive(Clone, Copy, Debug)]
pub(super) struct Contact {
    /// Of the faces [%].
    pub(super) slip: f64,
    pub(super) open: f64,
    pub(super) own_rows: usize,
    pub(super) is_symmetric: bool,
    pub(super) newton: usize,
    pub(super) has_converged: bool,
    /// Closed faces in tension, open ones that overlap.
    pub(super) tension: usize,
    pub(super) overlap: usize,
}

/// Sums over the load steps of a run, and what most of its steps and systems take.
#[derive(Clone, Copy, Debug)]
pub(super) struct Steps {
    pub(super) steps: usize,
    pub(super) rounds: usize,
    pub(super) newton: usize,
    pub(super) krylov: usize,
    pub(super) cuts: usize,
    /// Rounds that 95 % of the steps do not exceed, and the median of Newton steps; the equilibrium at time 0 does not count.
    pub(super) rounds_95: Option<usize>,
    pub(super) newton_median: Option<usize>,
    /// Median of the iterations per factor of 1e-8 of the residual, of the systems that tell it; none where none does.
    pub(super) krylov_median: Option<usize>,
    /// Fluid that is missing at the end over what was injected. Unit: 1.
    pub(super) lost: Option<f64>,
    /// Of this process [s].
    pub(super) wall_s: f64,
}

/// What the fractures of a run did, all of them together.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub(super) struct Faults {
    /// End of the first step in which a face slips [s]; none where no face does.
    pub(super) onset: Option<f64>,
    /// End of the first step in which a face is open [s]; none where no face is.
    pub(super) opening: Option<f64>,
    /// Largest ‖γ‖ of a face at the end of a step [m].
    pub(super) slip: f64,
    /// Largest area of faces in slip at the end of a step [m²].
    pub(super) slipping: f64,
    /// Largest area of open faces at the end of a step [m²].
    pub(super) open: f64,
    /// Largest aperture at the end of a step [m].
    pub(super) aperture: f64,
    /// Seismic moment of all steps, slip that goes back counted, too [N m].
    pub(super) moment: f64,
    /// Largest χ of a face at the end of a step. Unit: 1.
    pub(super) criticality: f64,
    /// What friction dissipates in all steps [J].
    pub(super) dissipated: f64,
}

/// What a row brought to light.
#[derive(Default)]
pub(super) struct Measured {
    /// n_u, n_t, n_p.
    pub(super) sizes: Option<[usize; 3]>,
    /// Meshing, assembly [s].
    pub(super) mesh_s: Option<f64>,
    pub(super) assembly_s: Option<f64>,
    /// C, and the iteration that is asked for.
    pub(super) c: Option<fracas_solvers::saddle::AugmentationChoice>,
    pub(super) asked: String,
    pub(super) run: Option<Run>,
    /// Of u and t, against a reference.
    pub(super) errors: Option<[f64; 2]>,
    pub(super) nested: Option<Errors>,
    pub(super) contact: Option<Contact>,
    pub(super) stiffness: Option<StiffnessEnds>,
    /// Of S_u, and of S_u scaled to a unit diagonal.
    pub(super) schur: [Option<Ends>; 2],
    pub(super) spectrum: Option<SpectrumReport>,
    pub(super) steps: Option<Steps>,
    pub(super) faults: Option<Faults>,
    /// Relative residuals, iteration by iteration, as the method estimates them.
    pub(super) residuals: Vec<f64>,
    pub(super) outcome: Option<Outcome>,
    /// Why, or what to mind; several sentences behind each other.
    pub(super) reasons: Vec<String>,
}
