//! Claim: around S_u by PETSc's solvers RACP finds the solution that it finds around an exact S_u: with MUMPS in as many iterations,
//! with GAMG and BoomerAMG in few; an option that PETSc does not read is refused, and threads wait for each other.
//!
//! `cargo test --release --features petsc --test petsc`; [`regions`](../regions.rs) and [`laws`](../laws.rs) take these solvers, too.
#![allow(clippy::unwrap_used)]

use fracas::prelude::*;
use fracas_operators::laws::probe;
use fracas_solvers::SetupError;
use fracas_solvers::saddle::{InnerChoice, Racp, SaddleMethod};
use rayon::prelude::*;

fn around(inner: &str, tolerance: f64) -> Solve {
    let inner: InnerChoice = match inner.strip_prefix('{') {
        None => inner.parse().unwrap(),
        Some(_) => serde_json::from_str(inner).unwrap(),
    };
    Solve {
        method: SaddleMethod::Racp(Racp {
            inner,
            ..Racp::default()
        }),
        inner: InnerRule::Fixed,
        tolerance,
        ..Solve::default()
    }
}

fn far(a: &[f64], b: &[f64]) -> f64 {
    let size = b.iter().fold(0.0, |m: f64, b| m.max(b.abs()));
    let pairs = a.iter().zip(b);
    pairs.fold(0.0, |m: f64, (a, b)| m.max((a - b).abs())) / size
}

#[test]
fn racp_around_mumps_is_racp_around_an_exact_s_u() {
    for name in ["crossing", "layered", "cycle"] {
        let problem: Problem = named(name).unwrap().small_scene().unwrap().into();
        let [exact, mumps] = ["exact", "mumps"].map(|inner| {
            let solved = around(inner, 1e-12).solve(&problem, &mut Silent).unwrap();
            assert!(solved.has_converged(), "{name}, {inner}");
            solved
        });
        assert_eq!(mumps.inner.as_deref(), Some("mumps"));
        assert_eq!(exact.iterations, mumps.iterations, "{name}");
        assert!(
            far(mumps.displacements(), exact.displacements()) < 1e-10,
            "{name}"
        );
        assert!(far(mumps.tractions(), exact.tractions()) < 1e-10, "{name}");
    }
}

/// The scene of sizes, with thirty thousand unknowns.
fn layered_crossing() -> Problem {
    let scene = named("layered_crossing").unwrap().scene().unwrap();
    let cells = [("x", 16), ("y", 24), ("z", 24)].map(|(d, n)| format!("mesh.{d}.cells={n}"));
    scene.with_overrides(&cells).unwrap().into()
}

#[test]
fn gamg_and_boomeramg_find_the_solution_in_few_iterations() {
    let problem = layered_crossing();
    let exact = around("exact", 1e-8).solve(&problem, &mut Silent).unwrap();
    assert!(exact.n_u > 25_000, "{}", exact.n_u);
    for inner in [
        "gamg",
        "boomeramg",
        r#"{"gamg":{"threshold":0.02,"options":"-pc_gamg_agg_nsmooths 1 -mg_levels_ksp_max_it 3"}}"#,
        r#"{"boomeramg":{"options":"-pc_hypre_boomeramg_coarsen_type HMIS"}}"#,
    ] {
        let solved = around(inner, 1e-8).solve(&problem, &mut Silent).unwrap();
        println!("{inner}: {} iterations", solved.iterations);
        assert!(
            solved.has_converged() && solved.iterations <= 150,
            "{inner}"
        );
        assert!(
            solved.iterations > exact.iterations,
            "{inner} is no exact S_u"
        );
        assert!(solved.c_app > 1.0, "{inner}: {}", solved.c_app);
        assert!(
            far(solved.displacements(), exact.displacements()) < 1e-6,
            "{inner}"
        );
        assert!(far(solved.tractions(), exact.tractions()) < 1e-6, "{inner}");
    }
}

#[test]
fn an_option_that_nothing_reads_is_a_sentence() {
    let problem: Problem = named("crossing").unwrap().small_scene().unwrap().into();
    for (inner, said) in [
        (
            r#"{"gamg":{"options":"-pc_gamg_thresold 0.1"}}"#,
            "\"-pc_gamg_thresold\"",
        ),
        (
            r#"{"gamg":{"options":"-pc_hypre_boomeramg_max_iter 2"}}"#,
            "-pc_hypre_boomeramg_max_iter",
        ),
        (r#"{"gamg":{"options":"-pc_type ilu"}}"#, "\"-pc_type\""),
        (r#"{"gamg":{"options":"-pc_gamg_type nothing"}}"#, "nothing"),
        (
            r#"{"boomeramg":{"options":"-pc_hypre_boomeramg_coarsen_type nothing"}}"#,
            "nothing",
        ),
    ] {
        let error = around(inner, 1e-8)
            .solve(&problem, &mut Silent)
            .unwrap_err();
        let text = error.to_string();
        assert!(text.contains(said) && !text.contains('\n'), "{text}");
    }
    // and the next set-up knows nothing of them
    let solved = around("gamg", 1e-8).solve(&problem, &mut Silent).unwrap();
    assert!(solved.has_converged());
}

#[test]
fn threads_wait_for_each_other_and_repeat_every_bit() {
    let blocks = {
        let body = named("crossing")
            .unwrap()
            .small_scene()
            .unwrap()
            .build()
            .unwrap();
        body.saddle_blocks(Some(body.jump_stabilization())).unwrap()
    };
    for inner in ["gamg", "boomeramg", "mumps"] {
        let inner: InnerChoice = inner.parse().unwrap();
        let applied: Vec<Vec<u64>> = (0..16u64)
            .into_par_iter()
            .map(|k| {
                let ready = inner
                    .of_matrix(&blocks.a, blocks.coordinates.as_deref())
                    .unwrap();
                let r = probe::<f64>(blocks.a.rows(), k % 2);
                let (mut z, mut work) = (r.clone(), vec![0.0; ready.inverse.work_len()]);
                ready.inverse.solve(&r, &mut z, &mut work);
                z.iter().map(|z| z.to_bits()).collect()
            })
            .collect();
        for (k, z) in applied.iter().enumerate() {
            assert!(z == &applied[k % 2], "{inner}, set-up {k}");
        }
    }
}

#[test]
fn an_indefinite_matrix_is_no_matrix_for_mumps() {
    let body = named("crossing")
        .unwrap()
        .small_scene()
        .unwrap()
        .build()
        .unwrap();
    let blocks = body.saddle_blocks(Some(body.jump_stabilization())).unwrap();
    let turned = blocks.a.map(|v| -v);
    let inner: InnerChoice = "mumps".parse().unwrap();
    let error = inner.of_matrix(&turned, None).err();
    assert!(
        matches!(error, Some(SetupError::BadDiagonal { row: 1, .. })),
        "{error:?}"
    );
}
