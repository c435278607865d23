//! Claim: no stiffness product allocates. One thread, because the queues of a pool with more grow on their own.
#![allow(unsafe_code, reason = "an allocator that counts")]

#[path = "../src/elasticity/sample.rs"]
mod sample;

use fracas::elasticity::{Constraints, Elastic, Restricted, matrix_free, stiffness};
use fracas::mesh;
use fracas_operators::sparse::Csr;
use fracas_operators::{LinearOperator, Real};
use rayon::{ThreadPool, ThreadPoolBuilder};
use std::alloc::{GlobalAlloc, Layout, System};
use std::sync::OnceLock;
use std::sync::atomic::{AtomicU64, Ordering};

struct Counting;

static ALLOCATIONS: AtomicU64 = AtomicU64::new(0);

// SAFETY: forwards to the system allocator.
unsafe impl GlobalAlloc for Counting {
    unsafe fn alloc(&self, layout: Layout) -> *mut u8 {
        ALLOCATIONS.fetch_add(1, Ordering::Relaxed);
        // SAFETY: the caller's contract.
        unsafe { System.alloc(layout) }
    }
    unsafe fn dealloc(&self, pointer: *mut u8, layout: Layout) {
        // SAFETY: the caller's contract.
        unsafe { System.dealloc(pointer, layout) }
    }
}

#[global_allocator]
static ALLOCATOR: Counting = Counting;

/// One pool for the whole test: a thread that ends allocates, too.
fn pool() -> &'static ThreadPool {
    static POOL: OnceLock<ThreadPool> = OnceLock::new();
    POOL.get_or_init(|| {
        let builder = ThreadPoolBuilder::new().num_threads(1);
        let pool = builder.build().expect("one thread");
        // the thread has started and done its own allocations
        pool.install(|| ());
        pool
    })
}

fn assert_silent<R: Real>(name: &str, operator: &dyn LinearOperator<R>) {
    let n = operator.shape().rows;
    let x = vec![R::one(); n];
    let (mut y, mut work) = (vec![R::zero(); n], vec![R::zero(); operator.work_len()]);
    let allocations = pool().install(|| {
        let before = ALLOCATIONS.load(Ordering::Relaxed);
        for _ in 0..3 {
            operator.apply_add(R::one(), &x, &mut y, &mut work);
        }
        ALLOCATIONS.load(Ordering::Relaxed) - before
    });
    assert_eq!(allocations, 0, "{name} {}", R::NAME);
}

fn check<R: Real>(mesh: &mesh::HexMesh) {
    let rock = [Elastic {
        young: 1.0,
        poisson: 0.3,
    }];
    let blocks = stiffness(mesh, &rock).expect("valid input").cast::<R>();
    assert_silent("CSR", &Csr::new(blocks.to_csr()));
    assert_silent("Block3", &blocks);
    let n = 3 * mesh.nodes.len();
    let constraints = Constraints::new((0..n).map(|i| (i % 11 == 0).then_some(0.0)).collect());
    let product = matrix_free::<R>(mesh, &rock).expect("valid input");
    assert_silent("matrix-free", &product);
    assert_silent("restricted", &Restricted::new(product, constraints));
}

#[test]
fn products_do_not_allocate() {
    for distortion in [0.0, 0.2] {
        let mesh = sample::mesh(sample::Sample {
            cells: [20, 20, 20],
            distortion,
            split: true,
            ..sample::Sample::default()
        });
        check::<f64>(&mesh);
        check::<f32>(&mesh);
    }
}
