//! Claim: whoever uses the crates brings an augmentation, an inner solver, a preconditioner, a Krylov method or a scene of their own
//! in some sixty lines, and the laboratory, `solve` and runs take it by its name: the examples hold.
#![allow(clippy::unwrap_used)]

use fracas::nonlinear::Simulation;
use fracas::scene::named;
use fracas_operators::{Preconditioner, Properties};
use fracas_solvers::direct::DirectSolver;
use fracas_solvers::saddle::{
    AugmentationChoice, AugmentationMatrix, AugmentationRule, CustomMethod, Racp, SaddleBlocks,
    SaddleMethod,
};
use fracas_solvers::spectrum::{NonNormalRequest, SpectrumRequest, analyse_method};
use fracas_solvers::{Named, SetupError, Silent};

#[path = "../examples/from_code.rs"]
mod from_code;
#[path = "../examples/own_augmentation.rs"]
mod own_augmentation;
#[path = "../examples/own_inner.rs"]
mod own_inner;
#[path = "../examples/own_krylov.rs"]
mod own_krylov;
#[path = "../examples/own_method.rs"]
mod own_method;
#[path = "../examples/own_scene.rs"]
mod own_scene;

#[test]
fn an_augmentation_that_couples_faces_goes_into_the_laboratory_and_a_run() {
    own_augmentation::main().unwrap();
}

#[test]
fn an_inner_solver_goes_into_a_run() {
    own_inner::main().unwrap();
}

#[test]
fn a_preconditioner_solves_to_the_accuracy_asked_for() {
    own_method::main().unwrap();
}

#[test]
fn a_krylov_method_stands_on_the_bookkeeping_of_the_house() {
    own_krylov::main().unwrap();
}

#[test]
fn a_scene_comes_from_code() {
    own_scene::main().unwrap();
}

#[test]
fn a_system_is_solved_and_a_scene_run_from_code() {
    from_code::main().unwrap();
}

/// A C of the house times a number, given by its entries.
#[derive(Debug)]
struct ByEntries {
    name: &'static str,
    of: AugmentationChoice,
    times: f64,
}

static HALF_H: ByEntries = ByEntries {
    name: "half_h_by_entries",
    of: AugmentationChoice::HalfH,
    times: 1.0,
};

static DOUBLED: ByEntries = ByEntries {
    name: "local_h_doubled",
    of: AugmentationChoice::LocalH,
    times: 2.0,
};

impl Named for ByEntries {
    fn name(&self) -> &'static str {
        self.name
    }
}

impl AugmentationRule for ByEntries {
    fn is_local(&self) -> bool {
        false
    }

    fn compute(
        &self,
        blocks: &SaddleBlocks,
        direct: &dyn DirectSolver,
    ) -> Result<AugmentationMatrix, SetupError> {
        let matrix = self.of.compute(blocks, direct)?.matrix;
        AugmentationMatrix::from_sparse(matrix.entries().map(|c| self.times * c))
    }
}

/// Krylov iterations, tractions and slip at the end of a scene of the gallery that sticks, slips, opens and closes.
fn run(solver: &str) -> (usize, Vec<f64>, Vec<f64>) {
    let scene = named("cycle").unwrap().small_scene().unwrap();
    let body = scene.with_overrides(&[solver]).unwrap().build().unwrap();
    let mut simulation = Simulation::new(&body).unwrap();
    let mut krylov = 0;
    let end = simulation.run(&mut Silent, |_, _, done| krylov += done.record.lin_it);
    let state = end.unwrap();
    (krylov, state.t, state.slip)
}

#[test]
fn a_c_of_faces_given_by_its_entries_makes_the_same_run() {
    AugmentationChoice::register(&HALF_H).unwrap();
    for inner in ["exact", "amg"] {
        let with = |c: &str| {
            run(&format!(
                "solver.racp={{ augmentation='{c}', inner='{inner}' }}"
            ))
        };
        let (krylov, t, slip) = with("half_h_by_entries");
        let (expected, t_faces, slip_faces) = with("half_h");
        // S_u from factors of [A B; Bᵀ −C] in place of its own, sums in another order, and C of stick where faces slip: one that couples
        // faces has no block of H = 0
        assert!(
            krylov.abs_diff(expected) * 20 <= expected,
            "{inner}: {krylov}, {expected}"
        );
        for (a, b) in [(t, t_faces), (slip, slip_faces)] {
            let far = a
                .iter()
                .zip(&b)
                .fold(0.0, |m: f64, (a, b)| m.max((a - b).abs()));
            let size = b.iter().fold(0.0, |m: f64, b| m.max(b.abs()));
            assert!(far <= 1e-6 * size, "{inner}: {far:e} of {size:e}");
        }
    }
}

/// `diag(A, −(C_0 + diag H))⁻¹`.
#[derive(Debug)]
struct Diagonals;

struct Inverse(Vec<f64>);

impl Named for Diagonals {
    fn name(&self) -> &'static str {
        "diagonals"
    }
}

impl CustomMethod for Diagonals {
    fn prepare(&self, blocks: &SaddleBlocks) -> Result<Box<dyn Preconditioner<f64>>, SetupError> {
        let h = |k| blocks.h.as_ref().and_then(|h| h.get(k, k)).copied();
        let of_a = (0..blocks.n_u()).map(|i| blocks.a.get(i, i).copied().unwrap_or(1.0));
        let of_t = blocks.contact_compliance().into_iter().enumerate();
        let of_t = of_t.map(|(k, c)| -(c + h(k).unwrap_or(0.0)));
        Ok(Box::new(Inverse(
            of_a.chain(of_t).map(|d| 1.0 / d).collect(),
        )))
    }

    fn takes_flow(&self) -> bool {
        false
    }

    fn takes_local_rows(&self) -> bool {
        false
    }
}

impl Preconditioner<f64> for Inverse {
    fn size(&self) -> usize {
        self.0.len()
    }

    fn solve(&self, x: &[f64], y: &mut [f64], _: &mut [f64]) {
        for ((y, x), d) in y.iter_mut().zip(x).zip(&self.0) {
            *y = d * x;
        }
    }

    fn flops(&self) -> u64 {
        self.0.len() as u64
    }

    fn properties(&self) -> Properties {
        Properties::LINEAR
    }
}

#[test]
fn a_c_and_a_preconditioner_go_through_pseudospectra_and_proofs() {
    let own = AugmentationChoice::register(&DOUBLED).unwrap();
    SaddleMethod::register(&Diagonals).unwrap();
    let scene = named("crossing").unwrap().scene().unwrap();
    let cells = ["mesh.x.cells=4", "mesh.y.cells=2", "mesh.z.cells=4"];
    let body = scene.with_overrides(&cells).unwrap().build().unwrap();
    let blocks = body.saddle_blocks(Some(Default::default())).unwrap();
    let request = SpectrumRequest {
        non_normal: Some(NonNormalRequest {
            points: 12,
            ..NonNormalRequest::default()
        }),
        conditions: false,
        ..SpectrumRequest::default()
    };
    let published = SaddleMethod::Racp(Racp {
        augmentation: own,
        relaxation: 0.0,
        ..Racp::default()
    });
    let certify = SpectrumRequest {
        certify: true,
        ..request.clone()
    };
    let report = analyse_method(&blocks, &published, &certify, &mut Silent).unwrap();
    assert_eq!(report.augmentation, "local_h_doubled");
    assert!(report.certified, "{:?}", report.enclosures);
    let (low, high) = (report.real_min.unwrap(), report.real_max.unwrap());
    let enclosures = report.enclosures.unwrap();
    for (value, ends) in [(low, enclosures.real_min), (high, enclosures.real_max)] {
        let (a, b) = ends.unwrap();
        assert!(a <= value + 1e-9 && value <= b + 1e-9, "{value}: {a} {b}");
    }

    let method: SaddleMethod = "diagonals".parse().unwrap();
    let other = analyse_method(&blocks, &method, &request, &mut Silent).unwrap();
    for found in [report.non_normal.unwrap(), other.non_normal.unwrap()] {
        let gmres = found.gmres;
        let bounds = gmres.resolvent.iter().zip(&gmres.field_of_values);
        for (measured, (a, b)) in gmres.measured.iter().zip(bounds) {
            assert!(*measured <= a.min(*b) * (1.0 + 1e-8) + 1e-10);
        }
        assert!(gmres.measured.len() > 2 && found.pseudospectra.is_some());
    }
    let refused = analyse_method(&blocks, &method, &certify, &mut Silent).unwrap_err();
    assert!(
        refused.to_string().contains("no explicit blocks"),
        "{refused}"
    );
}
