//! Stiffness products beside the ceilings of the machine, measured in one run: CSR, 3×3 blocks, bricks, hexahedra.
//!
//! `cargo bench -p fracas-benches --bench products` prints one table per scalar and number of threads. Bytes are the least that one
//! product must move (matrix once, x read once, y read and written once); the roofline is the larger of bytes over
//! read bandwidth and operations over the peak of fused multiply-adds. One thread is timed by its processor time.
//! `cargo bench -p fracas-benches --bench million` repeats what matters there on a million unknowns.

mod ceilings;
#[path = "../../src/elasticity/sample.rs"]
mod sample;

use ceilings::Ceilings;
use criterion::Criterion;
use fracas::elasticity::{Bricks, Elastic, Hexes, stiffness};
use fracas::mesh;
use fracas_benches::clock;
use fracas_operators::laws::probe;
use fracas_operators::sparse::{Block3, Csr};
use fracas_operators::{LinearOperator, Real};
use rayon::ThreadPool;
use std::time::Duration;

/// Cells per axis: 353k unknowns.
const CELLS: usize = 48;

const ROCKS: [Elastic; 2] = [
    Elastic {
        young: 20e9,
        poisson: 0.2,
    },
    Elastic {
        young: 5e9,
        poisson: 0.3,
    },
];

/// An operator and the bytes that one product must move.
struct Subject<R> {
    name: &'static str,
    operator: Box<dyn LinearOperator<R>>,
    bytes: f64,
}

fn subjects<R: Real>() -> Vec<Subject<R>> {
    let sample = |distortion| {
        sample::mesh(sample::Sample {
            cells: [CELLS; 3],
            distortion,
            regions: 2,
            ..sample::Sample::default()
        })
    };
    let (bricks, hexes) = (sample(0.0), sample(0.2));
    let start = std::time::Instant::now();
    let blocks = stiffness(&bricks, &ROCKS).expect("valid mesh");
    let bricks_time = start.elapsed().as_secs_f64();
    let start = std::time::Instant::now();
    stiffness(&hexes, &ROCKS).expect("valid mesh");
    let hexes_time = start.elapsed().as_secs_f64();
    println!("assembly: bricks {bricks_time:.2} s, hexahedra {hexes_time:.2} s of wall time");
    let blocks: Block3<R> = blocks.cast();
    let csr = Csr::new(blocks.to_csr());
    let (n, elements) = (blocks.shape().rows as f64, bricks.elements.len() as f64);
    let size = std::mem::size_of::<R>() as f64;
    let vectors = 3.0 * size * n;
    vec![
        Subject {
            name: "CSR",
            bytes: vectors + csr.nnz() as f64 * (size + 4.0),
            operator: Box::new(csr),
        },
        Subject {
            name: "Block3",
            bytes: vectors + blocks.block_count() as f64 * (9.0 * size + 4.0),
            operator: Box::new(blocks),
        },
        Subject {
            name: "Bricks",
            bytes: vectors + 2.0 * size * elements,
            operator: Box::new(Bricks::<R>::new(&bricks, &ROCKS).expect("valid mesh")),
        },
        Subject {
            name: "Hexes",
            // On node lines the numbers of nodes are a few bytes per group of elements.
            bytes: vectors + 23.0 * size * elements,
            operator: Box::new(Hexes::<R>::new(&hexes, &ROCKS).expect("valid mesh")),
        },
    ]
}

/// Median time of one product over the samples that criterion takes.
fn median<R: Real>(
    criterion: &mut Criterion,
    pool: &ThreadPool,
    label: &str,
    operator: &dyn LinearOperator<R>,
) -> (f64, usize) {
    let n = operator.shape().rows;
    let x = probe::<R>(n, 1);
    let (mut y, mut work) = (vec![R::zero(); n], vec![R::zero(); operator.work_len()]);
    let mut samples = Vec::new();
    criterion.bench_function(label, |bencher| {
        bencher.iter_custom(|repetitions| {
            pool.install(|| {
                let mut total = Duration::ZERO;
                for _ in 0..repetitions {
                    let start = clock::now();
                    operator.apply_add(R::of(1e-12), &x, &mut y, &mut work);
                    let time = clock::now() - start;
                    samples.push(time.as_secs_f64());
                    total += time;
                }
                total
            })
        });
    });
    samples.sort_by(f64::total_cmp);
    // Left out by the command line: no sample.
    let median = samples.get(samples.len() / 2).copied().unwrap_or(f64::NAN);
    (median, samples.len())
}

fn table<R: Real>(criterion: &mut Criterion, pool: &ThreadPool) {
    let threads = pool.current_num_threads();
    let ceilings: Ceilings = pool.install(ceilings::measure::<R>);
    let subjects = pool.install(subjects::<R>);
    let mut rows = Vec::new();
    let mut csr = f64::NAN;
    for subject in &subjects {
        let label = format!("{} {} {threads} threads", subject.name, R::NAME);
        let (seconds, repetitions) = median(criterion, pool, &label, &*subject.operator);
        if subject.name == "CSR" {
            csr = seconds;
        }
        let flops = subject.operator.flops() as f64;
        let memory = subject.bytes / ceilings.read;
        let roofline = memory.max(flops / ceilings.flops);
        rows.push(format!(
            "{:8} {:9.3} {:6} {:9.1} {:9.1} {:9.0}% {:9.1}%  {:8.2}",
            subject.name,
            seconds * 1e3,
            repetitions,
            subject.bytes / seconds / 1e9,
            flops / seconds / 1e9,
            100.0 * memory / seconds,
            100.0 * roofline / seconds,
            csr / seconds
        ));
    }
    println!(
        "\n{} · {threads} threads · {} unknowns · stream {:.1} GB/s, read {:.1} GB/s, {:.0} GFLOP/s",
        R::NAME,
        subjects[0].operator.shape().rows,
        ceilings.stream / 1e9,
        ceilings.read / 1e9,
        ceilings.flops / 1e9
    );
    println!("operator  median ms   runs      GB/s   GFLOP/s  of read BW  of roofline  CSR/this");
    rows.iter().for_each(|row| println!("{row}"));
    println!();
}

fn main() {
    let mut criterion = Criterion::default()
        .sample_size(30)
        .warm_up_time(Duration::from_millis(300))
        .measurement_time(Duration::from_secs(1))
        .configure_from_args();
    for threads in [1, 2] {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads).build();
        let pool = pool.expect("threads");
        table::<f64>(&mut criterion, &pool);
        table::<f32>(&mut criterion, &pool);
    }
}
