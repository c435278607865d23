//! Claim: a system folder is solved by algebraic multigrid in little more memory than the rows of A take while they are read, and as it
//! is where all of A stays.

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

/// Text and entries on their way, and what does not grow with the system.
const IN_FLIGHT: usize = 32 << 20;

/// Peak over the memory of the rows of A: 1.5 measured with 200 thousand displacements, 2.2 with all of A in memory.
const OVER_ROWS: f64 = 1.75;

#[test]
fn a_folder_is_solved_in_little_more_memory_than_its_rows() {
    let cells = ["mesh.x.cells=38", "mesh.y.cells=40", "mesh.z.cells=40"];
    let scene = named("layered_crossing").unwrap().scene().unwrap();
    let scene = scene.with_overrides(&cells).unwrap();
    let stuck = StuckBody::of_scene("layered_crossing", scene);
    let folder = std::env::temp_dir().join(format!("fracas-imported-{}", std::process::id()));
    let (_, blocks) = stuck.assemble(&mut Silent).unwrap();
    write_folder(&folder, &blocks, &Manifest::default()).unwrap();
    let rows = 12 * blocks.a.nnz();
    let unit = blocks.traction_unit();
    let settings = Solve {
        method: SaddleMethod::Racp(Racp {
            inner: InnerChoice::Amg(Amg::default()),
            ..Racp::default()
        }),
        inner: InnerRule::Fixed,
        krylov: Some(KrylovChoice::Sqmr(Sqmr {})),
        traction_unit: Some(unit),
        ..Solve::default()
    };
    let whole = settings.solve(&Problem::from(blocks), &mut Silent).unwrap();
    let problem = Problem::Folder(folder.clone());
    let (halved, peak) = peak_bytes(|| settings.solve(&problem, &mut Silent).unwrap());
    std::fs::remove_dir_all(&folder).unwrap();
    println!("peak {peak} bytes, rows of A {rows}");
    assert!(
        peak - IN_FLIGHT < (OVER_ROWS * rows as f64) as usize,
        "{peak} bytes for rows of {rows}"
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
