//! Claim: no stiffness product allocates. One thread, because the queues of a pool with more grow on their own.

mod counting;
#[path = "../src/elasticity/sample.rs"]
mod sample;

use counting::{allocations, threads};
use fracas::elasticity::{Constraints, Elastic, Restricted, matrix_free, stiffness};
use fracas::mesh;
use fracas_operators::sparse::Csr;
use fracas_operators::{LinearOperator, Real};
use rayon::ThreadPool;
use std::sync::OnceLock;

/// One pool for the whole test: a thread that ends allocates, too.
fn pool() -> &'static ThreadPool {
    static POOL: OnceLock<ThreadPool> = OnceLock::new();
    POOL.get_or_init(|| threads(1))
}

fn assert_silent<R: Real>(name: &str, operator: &dyn LinearOperator<R>) {
    let n = operator.shape().rows;
    let x = vec![R::one(); n];
    let (mut y, mut work) = (vec![R::zero(); n], vec![R::zero(); operator.work_len()]);
    let made = pool().install(|| {
        allocations(|| {
            for _ in 0..3 {
                operator.apply_add(R::one(), &x, &mut y, &mut work);
            }
        })
    });
    assert_eq!(made, 0, "{name} {}", R::NAME);
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
