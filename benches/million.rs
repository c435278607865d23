//! Stiffness products with a million unknowns: bricks and general hexahedra of the gallery beside CSR, f32 beside f64, one
//! thread and two in turn.
//!
//! `cargo bench -p fracas-benches --bench million` prints medians and ranges of nine rounds, of wall time; a ratio is one of times within a round.
//! The control is what the machine gives two threads that share nothing, or memory alone.

use fracas::elasticity::{matrix_free, stiffness};
use fracas::scene::{Body, named};
use fracas_benches::fused;
use fracas_benches::rounds::{self, Sorted};
use fracas_operators::laws::probe;
use fracas_operators::sparse::Csr;
use fracas_operators::vector::axpby;
use fracas_operators::{LinearOperator, Real};
use std::time::Instant;

const ROUNDS: usize = 9;

/// Repetitions per round, of which the median counts.
const REPETITIONS: usize = 15;

/// Scenes of the gallery with the overrides that give a million displacements.
const BODIES: [(&str, &str, [&str; 3]); 2] = [
    (
        "bricks",
        "analogue_b",
        ["mesh.x.cells=70", "mesh.y.cells=68", "mesh.z.cells=68"],
    ),
    (
        "hexahedra",
        "layered_crossing",
        ["mesh.x.cells=64", "mesh.y.cells=72", "mesh.z.cells=72"],
    ),
];

fn body(scene: &str, cells: &[&str]) -> Body {
    named(scene)
        .expect("a scene of the gallery")
        .scene()
        .and_then(|scene| scene.with_overrides(cells))
        .and_then(|scene| scene.build())
        .expect("valid scene")
}

/// Work that is timed, the same on any number of threads.
type Work<'a> = Box<dyn FnMut() + Send + 'a>;

fn product<'a, R: Real>(operator: &'a dyn LinearOperator<R>) -> Work<'a> {
    let n = operator.shape().rows;
    let x = probe::<R>(n, 1);
    let (mut y, mut work) = (vec![R::zero(); n], vec![R::zero(); operator.work_len()]);
    Box::new(move || operator.apply_add(R::of(1e-12), &x, &mut y, &mut work))
}

/// Multiply-adds in registers, as much for one thread as for two.
fn arithmetic() -> Work<'static> {
    Box::new(|| fused::run::<f64>(2))
}

/// `y ← α x + β y` on vectors larger than any cache.
fn memory() -> Work<'static> {
    let (x, mut y) = (vec![1.0f64; 16 << 20], vec![1.0; 16 << 20]);
    Box::new(move || axpby(0.5, &x, 0.5, &mut y))
}

/// Milliseconds, in the current pool.
fn timed(work: &mut Work<'_>) -> f64 {
    let time = |_| {
        let start = Instant::now();
        work();
        1e3 * start.elapsed().as_secs_f64()
    };
    Sorted::new((0..REPETITIONS).map(time)).median()
}

fn main() {
    let pools = rounds::pools();
    for (name, scene, cells) in BODIES {
        let body = body(scene, &cells);
        let (mesh, materials) = (&body.mesh, &body.materials);
        let double = matrix_free::<f64>(mesh, materials).expect("valid mesh");
        let single = matrix_free::<f32>(mesh, materials).expect("valid mesh");
        let csr = Csr::new(stiffness(mesh, materials).expect("valid mesh").to_csr());
        println!(
            "{name}: {scene} {}, {} displacements, ms",
            cells.join(" "),
            3 * mesh.nodes.len()
        );
        let mut subjects = [
            ("CSR f64", product::<f64>(&csr)),
            ("f64", product::<f64>(&*double)),
            ("f32", product::<f32>(&*single)),
            ("arithmetic alone", arithmetic()),
            ("memory alone", memory()),
        ];
        let mut times = Vec::new();
        for round in 0..ROUNDS {
            times.push(subjects.each_mut().map(|(_, work)| {
                let mut times = [0.0; 2];
                // neither is always the first
                for p in [round % 2, 1 - round % 2] {
                    times[p] = pools[p].install(|| timed(work));
                }
                times
            }));
        }
        let ratio = |a: (usize, usize), b: (usize, usize)| {
            Sorted::new(times.iter().map(|round| round[a.0][a.1] / round[b.0][b.1]))
        };
        for (k, (name, _)) in subjects.iter().enumerate() {
            let [one, two] = [0, 1].map(|p| Sorted::new(times.iter().map(|round| round[k][p])));
            let speedup = ratio((k, 0), (k, 1));
            println!("  {name:16} one thread {one}, two {two}, speed-up {speedup}");
        }
        let (csr, single) = (ratio((0, 0), (1, 0)), ratio((1, 0), (2, 0)));
        let arithmetic = Sorted::new(times.iter().map(|round| round[3][0]));
        let peak = 2e-6 * fused::operations::<f64>() / arithmetic.median();
        println!(
            "  on one thread f64 is {csr} times as fast as CSR, f32 {single} times as fast as f64, registers do {peak:.0} GFLOP/s"
        );
    }
}
