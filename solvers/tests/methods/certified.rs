//! Claim: reports are certified where they are true, and only there.

use crate::cases::{Case, KINDS, LAST, sparse, with_one_traction};
use faer::Mat;
use fracas_solvers::direct::{DirectChoice, DirectSolver};
use fracas_solvers::saddle::{
    AugmentationChoice, AugmentationMatrix, AugmentationRule, InnerChoice, SaddleBlocks,
};
use fracas_solvers::spectrum::certify::enclosures;
use fracas_solvers::spectrum::{SpectrumRequest, analyse};
use fracas_solvers::{Named, SetupError, Silent};

/// C of the case that is asked about.
#[derive(Debug)]
struct Given(std::sync::Mutex<Option<AugmentationMatrix>>);

static GIVEN: Given = Given(std::sync::Mutex::new(None));

impl Named for Given {
    fn name(&self) -> &'static str {
        "given_by_the_certified_case"
    }
}

impl AugmentationRule for Given {
    fn is_local(&self) -> bool {
        false
    }

    fn compute(
        &self,
        _: &SaddleBlocks,
        _: &dyn DirectSolver,
    ) -> Result<AugmentationMatrix, SetupError> {
        Ok(self.0.lock().unwrap().clone().unwrap())
    }
}

#[test]
fn a_report_is_certified_where_it_is_true_and_says_why_where_it_is_not() {
    AugmentationChoice::register(&GIVEN).unwrap();
    let (mut certified, mut all) = (0, 0);
    for kind in KINDS {
        for seed in 100..130 {
            let case = Case::new(seed, kind);
            *GIVEN.0.lock().unwrap() = Some(case.c.clone());
            let request = SpectrumRequest {
                augmentation: "given_by_the_certified_case".parse().unwrap(),
                inner: InnerChoice::Exact {
                    backend: DirectChoice::Faer,
                },
                conditions: false,
                certify: true,
                ..SpectrumRequest::default()
            };
            // S_u may be singular to rounding, which factorizations refuse
            let Ok(report) = analyse(&case.blocks, &request, &mut Silent) else {
                continue;
            };
            all += 1;
            let enclosures = report.enclosures.unwrap();
            assert_eq!(report.certified, enclosures.is_complete());
            assert!(report.certified || enclosures.reason.is_some());
            certified += usize::from(report.certified);
            let (low, high) = case.ends();
            for (end, found) in [(low, enclosures.real_min), (high, enclosures.real_max)] {
                let Some((a, b)) = found else { continue };
                let room = LAST * end.abs();
                assert!(
                    a - room <= end && end <= b + room,
                    "{kind:?} {seed}: {end} in [{a}, {b}]"
                );
            }
        }
    }
    assert!(
        all > 100 && 10 * certified > 9 * all,
        "{certified} of {all}"
    );
}

#[test]
fn a_verdict_that_the_proof_contradicts_is_not_certified_nor_is_a_system_without_displacements() {
    let a = Mat::from_fn(2, 2, |i, j| [[2.0, 0.5], [0.5, 2.0]][i][j]);
    let (mut blocks, _) = with_one_traction(&a, &[1.0, 1.0], 1.0, 0.5);
    let request = SpectrumRequest {
        inner: InnerChoice::Exact {
            backend: DirectChoice::Faer,
        },
        conditions: false,
        relaxation: 0.0,
        certify: true,
        ..SpectrumRequest::default()
    };
    let solver = DirectChoice::Faer.solver().unwrap();
    let c = request
        .augmentation
        .compute(&blocks, solver.as_ref())
        .unwrap()
        .matrix;
    let mut report = analyse(&blocks, &request, &mut Silent).unwrap();
    assert!(report.certified && report.contained == Some(true));
    report.contained = Some(false);
    let found = enclosures(&blocks, &c, &report);
    assert_eq!(found.contained, Some(true));
    assert!(!found.is_complete() && found.reason.is_some());
    // λ = h/c alone, and not 1
    (blocks.a, blocks.b1) = (sparse(&Mat::zeros(0, 0)), sparse(&Mat::zeros(0, 1)));
    assert_eq!(enclosures(&blocks, &c, &report).real_max, None);
}
