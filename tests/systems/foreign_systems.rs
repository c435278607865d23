//! Claim: systems written by another code, in any ordering and scale, give the numbers that LAPACK gives.
//!
//! `data/foreign/` holds system folders of an independent assembler (no coordinates, A singular, dependent or empty
//! columns of B, stiffness contrast 1e6, ν = 0.49, blocks scaled over 24 decades, CRLF and comments) and
//! `reference.json` with the values of an independent dense computation.

use fracas_solvers::Silent;
use fracas_solvers::krylov::{Criteria, Gmres, KrylovMethod, Outcome, System};
use fracas_solvers::prepare::Prepare;
use fracas_solvers::saddle::folder::read_folder;
use fracas_solvers::saddle::{InnerChoice, Racp, SaddleBlocks, SaddleOperator};
use fracas_solvers::spectrum::{SpectrumRequest, analyse};
use serde_json::Value;
use std::path::PathBuf;

/// Relative agreement asked for.
const TOLERANCE: f64 = 1e-6;

fn folder() -> PathBuf {
    PathBuf::from(env!("CARGO_MANIFEST_DIR")).join("data/foreign")
}

/// Calls `visit(system, blocks, augmentation, inner, reference)` for every stored case.
fn for_each_case(mut visit: impl FnMut(&str, &SaddleBlocks, &str, &str, &Value)) {
    let text = std::fs::read_to_string(folder().join("reference.json")).unwrap();
    let reference: Value = serde_json::from_str(&text).unwrap();
    let mut cases = 0;
    for (name, choices) in reference.as_object().unwrap() {
        let blocks = read_folder(&folder().join(name)).unwrap().blocks;
        for (augmentation, inners) in choices.as_object().unwrap() {
            for (inner, values) in inners.as_object().unwrap() {
                visit(name, &blocks, augmentation, inner, values);
                cases += 1;
            }
        }
    }
    assert!(cases > 100, "only {cases} cases");
}

fn close(case: &str, key: &str, expected: &Value, found: Option<f64>) {
    match (expected.as_f64(), found) {
        (None, None) => {}
        (Some(e), Some(f)) => {
            // eigenvalues of an unsymmetric matrix of norm 1 are known to about 1e-9 absolute: rounding moves them so far
            let floor = match key {
                "im_max" => 1e-1,
                "real_min" | "re_min" | "alpha_t" => 1e-3,
                _ => 0.0,
            };
            assert!(
                (e - f).abs() <= TOLERANCE * e.abs().max(floor),
                "{case}: {key} is {e} there, {f} here"
            );
        }
        (e, f) => panic!("{case}: {key} is {e:?} there, {f:?} here"),
    }
}

#[test]
fn extreme_eigenvalues_conditions_and_bounds_agree_with_lapack() {
    for_each_case(|name, blocks, augmentation, inner, values| {
        let case = format!("{name}, C = {augmentation}, inner {inner}");
        let request = SpectrumRequest {
            augmentation: augmentation.parse().unwrap(),
            inner: inner.parse::<InnerChoice>().unwrap(),
            ..SpectrumRequest::default()
        };
        let report = analyse(blocks, &request, &mut Silent).unwrap();
        let b = &report.bounds;
        for (key, found) in [
            ("c_min", Some(report.c_min)),
            ("c_max", Some(report.c_max)),
            ("cond_A", report.cond_A),
            ("cond_S_u", report.cond_S_u),
            ("real_min", report.real_min),
            ("real_max", report.real_max),
            ("re_min", report.re_min),
            ("re_max", report.re_max),
            ("im_max", report.im_max),
            ("alpha_u", b.alpha_u),
            ("beta_u", b.beta_u),
            ("alpha_t", b.alpha_t),
            ("beta_t", b.beta_t),
        ] {
            // n_t > n_u: σ_min over R^{n_t} is 0; the reference takes the smallest of the n_u singular values
            if key == "alpha_t" && blocks.n_t() > blocks.n_u() {
                continue;
            }
            if let Some(expected) = values.get(key) {
                close(&case, key, expected, found);
            }
        }
        assert_eq!(report.contained, Some(true), "{case}");
    });
}

#[test]
fn gmres_counts_with_exact_schur_complement_agree() {
    for_each_case(|name, blocks, augmentation, inner, values| {
        let Some(expected) = values.get("gmres").and_then(Value::as_i64) else {
            return;
        };
        // tractions of 1e9 and more beside loads of 1: rounding stops the residual above 1e-8, whatever the code
        if ["nu_049", "badly_scaled_1e24"].contains(&name) {
            return;
        }
        let settings = Racp {
            augmentation: augmentation.parse().unwrap(),
            relaxation: 0.0,
            inner: inner.parse().unwrap(),
            ..Racp::default()
        };
        let operator = SaddleOperator::new(blocks);
        let preconditioner = settings.prepare(blocks).unwrap();
        let given: Vec<f64> = blocks.rhs_u.iter().chain(&blocks.rhs_t).copied().collect();
        let rhs = if given.iter().all(|b| *b == 0.0) {
            (1..=given.len()).map(|i| (i as f64).sin()).collect()
        } else {
            given
        };
        let system = System {
            operator: &operator,
            preconditioner: preconditioner.as_ref(),
            rhs: &rhs,
        };
        let criteria = Criteria {
            relative_tolerance: 1e-8,
            max_iterations: 1000,
        };
        let mut x = vec![0.0; rhs.len()];
        let report = Gmres::restarted(1000)
            .solve(&system, &criteria, &mut x, &mut Silent)
            .unwrap_or_else(|e| panic!("{name}, {augmentation}: {e}"));
        assert_eq!(report.outcome, Outcome::Converged, "{name}, {augmentation}");
        let found = report.iterations as i64;
        assert!(
            (found - expected).abs() <= 1,
            "{name}, C = {augmentation}: {expected} iterations there, {found} here"
        );
    });
}
