//! Times of the laboratory: dense spectra of 2,000 unknowns, exact C and condition numbers at 20,000.
//!
//! `cargo bench -p fracas-benches --bench spectrum` prints one time per line, on a pool of one thread and of two. One thread is timed by
//! its processor time.

use criterion::{Bencher, BenchmarkId, Criterion, SamplingMode};
use faer::Mat;
use fracas::contact::JumpStabilization;
use fracas::scene::named;
use fracas_benches::clock;
use fracas_operators::laws::probe;
use fracas_solvers::Silent;
use fracas_solvers::direct::{DirectChoice, DirectSolver};
use fracas_solvers::eigen::dense;
use fracas_solvers::saddle::{AugmentationChoice, InnerChoice, SaddleBlocks};
use fracas_solvers::smoothers::{Jacobi, Ssor};
use fracas_solvers::spectrum::{SpectrumRequest, analyse, condition};
use rayon::ThreadPool;
use std::hint::black_box;
use std::time::Duration;

/// Order of the dense matrices.
const DENSE: usize = 2000;

/// Overrides of the scene `crossing` that give about [`DENSE`] unknowns.
const SMALL: [&str; 3] = ["mesh.x.cells=8", "mesh.y.cells=7", "mesh.z.cells=8"];

/// Overrides of `analogue_b` that give about 20,000 unknowns.
const LARGE: [&str; 3] = ["mesh.x.cells=25", "mesh.y.cells=16", "mesh.z.cells=16"];

fn blocks(scene: &str, overrides: &[&str]) -> SaddleBlocks {
    let body = named(scene)
        .expect("a scene of the gallery")
        .scene()
        .and_then(|scene| scene.with_overrides(overrides))
        .and_then(|scene| scene.build())
        .expect("valid scene");
    let blocks = body
        .saddle_blocks(Some(JumpStabilization::default()))
        .expect("valid blocks");
    println!("{scene}: n_u = {}, n_t = {}", blocks.n_u(), blocks.n_t());
    blocks
}

/// Times `work` on the pool.
fn timed<T: Send>(bencher: &mut Bencher<'_>, pool: &ThreadPool, work: impl Fn() -> T + Sync) {
    bencher.iter_custom(|repetitions| {
        pool.install(|| {
            let start = clock::now();
            (0..repetitions).for_each(|_| drop(black_box(work())));
            clock::now() - start
        })
    });
}

fn bench(criterion: &mut Criterion, small: &SaddleBlocks, large: &SaddleBlocks, pool: &ThreadPool) {
    let threads = pool.current_num_threads();
    let mut group = criterion.benchmark_group("spectrum");
    group.sampling_mode(SamplingMode::Flat).sample_size(10);
    let label = |what: &str| BenchmarkId::new(what, format!("{threads} threads"));

    let values: Vec<f64> = probe(DENSE * DENSE, 1);
    let random = Mat::from_fn(DENSE, DENSE, |i, j| values[j * DENSE + i]);
    group.bench_function(label("random general"), |bencher| {
        timed(bencher, pool, || {
            dense::general_eigenvalues(black_box(random.as_ref()))
        });
    });
    group.bench_function(label("random symmetric"), |bencher| {
        timed(bencher, pool, || {
            dense::symmetric_eigenvalues(black_box(random.as_ref()))
        });
    });

    let inners = [
        InnerChoice::Ssor(Ssor::default()),
        InnerChoice::Jacobi(Jacobi::default()),
        InnerChoice::default(),
    ];
    for inner in inners {
        let request = SpectrumRequest {
            inner,
            ..SpectrumRequest::default()
        };
        group.bench_function(label(&format!("analyse {inner}")), |bencher| {
            timed(bencher, pool, || {
                analyse(small, &request, &mut Silent).expect("a report")
            });
        });
    }

    let direct = DirectChoice::default().solver().expect("a backend");
    let direct: &dyn DirectSolver = direct.as_ref();
    group.bench_function(label("exact C"), |bencher| {
        timed(bencher, pool, || {
            AugmentationChoice::ExactH
                .compute(large, direct)
                .expect("C")
        });
    });
    let c = AugmentationChoice::LocalH
        .compute(large, direct)
        .expect("C")
        .matrix;
    group.bench_function(label("cond A"), |bencher| {
        timed(bencher, pool, || {
            condition::stiffness_ends(large, direct).expect("ends")
        });
    });
    group.bench_function(label("cond S_u"), |bencher| {
        timed(bencher, pool, || {
            condition::schur_ends(large, &c, None, direct).expect("ends")
        });
    });
    group.finish();
}

fn main() {
    let mut criterion = Criterion::default()
        .warm_up_time(Duration::from_millis(100))
        .measurement_time(Duration::from_secs(1))
        .configure_from_args();
    let (small, large) = (blocks("crossing", &SMALL), blocks("analogue_b", &LARGE));
    for threads in [1, 2] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let pool = pool.expect("threads");
        bench(&mut criterion, &small, &large, &pool);
    }
}
