//! Algebraic multigrid of S_u on a million unknowns: set-up, refresh, cycle, one thread beside two in turn.
//!
//! `cargo bench -p fracas-benches --bench multigrid` prints medians and ranges of five rounds. One thread is timed by its processor time.

use fracas::contact::JumpStabilization;
use fracas::scene::named;
use fracas_benches::clock;
use fracas_benches::rounds::{self, Sorted};
use fracas_operators::Preconditioner;
use fracas_operators::laws::probe;
use fracas_solvers::amg::Amg;
use fracas_solvers::direct::DirectChoice;
use fracas_solvers::saddle::AugmentationChoice;
use std::sync::atomic::{AtomicUsize, Ordering};

/// Overrides of `analogue_b` that give a million displacements.
const CELLS: [&str; 3] = ["mesh.x.cells=70", "mesh.y.cells=68", "mesh.z.cells=68"];

const ROUNDS: usize = 5;

/// Cycles per round.
const CYCLES: usize = 10;

const NAMES: [&str; 3] = ["set-up", "refresh", "cycle"];

fn main() {
    let body = named("analogue_b")
        .expect("a scene of the gallery")
        .scene()
        .and_then(|scene| scene.with_overrides(&CELLS))
        .and_then(|scene| scene.build())
        .expect("valid scene");
    let blocks = body
        .saddle_blocks(Some(JumpStabilization::default()))
        .expect("valid blocks");
    let direct = DirectChoice::default().solver().expect("a solver");
    let c = AugmentationChoice::FittedH
        .compute(&blocks, direct.as_ref())
        .expect("valid blocks")
        .matrix;
    let f = &blocks.b1 * &c.inverse_root().expect("positive C");
    let settings = Amg::default();
    println!("n_u = {}, n_t = {}", blocks.n_u(), blocks.n_t());
    let kept = AtomicUsize::new(0);
    let round = || {
        let timed = |work: &mut dyn FnMut()| {
            let start = clock::now();
            work();
            (clock::now() - start).as_secs_f64()
        };
        let coordinates = blocks.coordinates.as_deref();
        let mut planned = None;
        let setup = timed(&mut || planned = settings.plan(&blocks.a, Some(&f), coordinates).ok());
        let (first, plan) = planned.take().expect("valid matrix");
        drop(first);
        kept.store(plan.bytes(), Ordering::Relaxed);
        let mut refreshed = None;
        let refresh = timed(&mut || refreshed = plan.refresh(&blocks.a, Some(&f)).ok());
        let m = refreshed.expect("the same matrix");
        let r = probe::<f64>(m.size(), 1);
        let (mut z, mut work) = (vec![0.0; m.size()], vec![0.0; m.work_len()]);
        m.solve(&r, &mut z, &mut work);
        let cycles = timed(&mut || (0..CYCLES).for_each(|_| m.solve(&r, &mut z, &mut work)));
        [setup, refresh, cycles / CYCLES as f64]
    };
    let pools = rounds::pools();
    let rounds: Vec<[[f64; 3]; 2]> = (0..ROUNDS)
        .map(|_| [&pools[0], &pools[1]].map(|pool| pool.install(round)))
        .collect();
    println!("kept for refreshes: {} MB", kept.into_inner() / 1_000_000);
    for (k, name) in NAMES.into_iter().enumerate() {
        let [one, two] = [0, 1].map(|p| Sorted::new(rounds.iter().map(|round| round[p][k])));
        let ratio = Sorted::new(rounds.iter().map(|round| round[0][k] / round[1][k]));
        println!("{name:8} one thread {one:.3} s, two {two:.3} s, ratio {ratio}");
    }
}
