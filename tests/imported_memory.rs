//! Claim: a system folder is solved by algebraic multigrid in less memory than with all rows of A, in as many iterations, to the same
//! solution.

#![allow(clippy::unwrap_used)]

mod counting;

use counting::peak_bytes;
use fracas::scene::named;
use fracas::solve::{InnerRule, Problem, Solve, StuckBody};
use fracas_operators::vector::norm2;
use fracas_solvers::Silent;
use fracas_solvers::amg::Amg;
use fracas_solvers::krylov::{KrylovChoice, Sqmr};
use fracas_solvers::saddle::folder::{Manifest, write_folder};
use fracas_solvers::saddle::{InnerChoice, Racp, SaddleMethod};

/// What half of A saves at the peak, over the memory of the rows of A; 0.47 measured. Unit: 1.
const SAVED: f64 = 0.4;

/// On one thread, after a solve that nobody counts: dense products keep 64 MiB per thread from their first call on.
#[test]
fn a_folder_is_solved_with_half_of_its_matrix() {
    let pool = rayon::ThreadPoolBuilder::new().num_threads(1).build();
    pool.unwrap().install(compare);
}

fn compare() {
    let cells = ["mesh.x.cells=32", "mesh.y.cells=32", "mesh.z.cells=32"];
    let scene = named("layered_crossing").unwrap().scene().unwrap();
    let scene = scene.with_overrides(&cells).unwrap();
    let stuck = StuckBody::of_scene("layered_crossing", scene);
    let folder = std::env::temp_dir().join(format!("fracas-imported-{}", std::process::id()));
    let (_, blocks) = stuck.assemble(&mut Silent).unwrap();
    write_folder(&folder, &blocks, &Manifest::default()).unwrap();
    let rows = 12 * blocks.a.nnz();
    let settings = Solve {
        method: SaddleMethod::Racp(Racp {
            inner: InnerChoice::Amg(Amg::default()),
            ..Racp::default()
        }),
        inner: InnerRule::Fixed,
        krylov: Some(KrylovChoice::Sqmr(Sqmr {})),
        traction_unit: Some(1.0),
        ..Solve::default()
    };
    let in_memory = Problem::from(blocks);
    let problem = Problem::Folder(folder.clone());
    settings.solve(&problem, &mut Silent).unwrap();
    let (whole, beside) = peak_bytes(|| settings.solve(&in_memory, &mut Silent).unwrap());
    drop(in_memory);
    let (halved, peak) = peak_bytes(|| settings.solve(&problem, &mut Silent).unwrap());
    std::fs::remove_dir_all(&folder).unwrap();
    println!("peak {peak} bytes, with rows of A {rows} + {beside}");
    assert!(
        (peak as f64) < beside as f64 + (1.0 - SAVED) * rows as f64,
        "{peak} bytes, with rows of A {rows} + {beside}"
    );
    assert!(whole.has_converged() && halved.has_converged());
    assert!(whole.iterations.abs_diff(halved.iterations) <= 1);
    assert_eq!(whole.c_app, halved.c_app);
    for range in [0..whole.n_u, whole.n_u..whole.x.len()] {
        let (a, b) = (&whole.x[range.clone()], &halved.x[range]);
        let difference: Vec<f64> = a.iter().zip(b).map(|(a, b)| a - b).collect();
        assert!(norm2(&difference) < 1e-6 * norm2(a));
    }
}
