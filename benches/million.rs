//! Stiffness products with a million unknowns: bricks and general hexahedra of the gallery beside CSR, f32 beside f64, one
//! thread and two in turn.
//!
//! `cargo bench --bench million` prints medians and ranges of nine rounds, ratios from within a round. One thread is timed
//! by its processor time. The first lines are the control: what the machine gives two threads that share nothing.

#[path = "products/ceilings.rs"]
mod ceilings;
#[path = "timing/clock.rs"]
mod clock;
#[path = "timing/rounds.rs"]
mod rounds;

use ceilings::Ceilings;
use fracas::elasticity::{matrix_free, stiffness};
use fracas::scene::{Body, named};
use fracas_operators::laws::probe;
use fracas_operators::sparse::Csr;
use fracas_operators::{LinearOperator, Real};
use rounds::Sorted;

const ROUNDS: usize = 9;

/// Products per round, of which the median counts.
const PRODUCTS: usize = 15;

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

/// Seconds of one product, in the current pool.
type Timed<'a> = Box<dyn FnMut() -> f64 + Send + 'a>;

fn timed<'a, R: Real>(operator: &'a dyn LinearOperator<R>) -> Timed<'a> {
    let n = operator.shape().rows;
    let x = probe::<R>(n, 1);
    let (mut y, mut work) = (vec![R::zero(); n], vec![R::zero(); operator.work_len()]);
    Box::new(move || {
        let product = |_| {
            let start = clock::now();
            operator.apply_add(R::of(1e-12), &x, &mut y, &mut work);
            (clock::now() - start).as_secs_f64()
        };
        Sorted::new((0..PRODUCTS).map(product)).median()
    })
}

fn main() {
    let pools = rounds::pools();
    let control: Vec<[Ceilings; 2]> = (0..ROUNDS)
        .map(|_| [0, 1].map(|p| pools[p].install(ceilings::measure::<f64>)))
        .collect();
    let over = |of: &dyn Fn(&Ceilings) -> f64| {
        Sorted::new(control.iter().map(|[one, two]| of(two) / of(one)))
    };
    println!("two threads over one, {ROUNDS} rounds:");
    println!("  multiply-adds  {}", over(&|c| c.flops));
    println!("  bytes read     {}", over(&|c| c.read));
    println!("  bytes streamed {}", over(&|c| c.stream));
    for (name, scene, cells) in BODIES {
        let body = body(scene, &cells);
        let (mesh, materials) = (&body.mesh, &body.materials);
        let double = matrix_free::<f64>(mesh, materials).expect("valid mesh");
        let single = matrix_free::<f32>(mesh, materials).expect("valid mesh");
        let csr = Csr::new(stiffness(mesh, materials).expect("valid mesh").to_csr());
        println!(
            "{name}: {scene} {}, {} displacements",
            cells.join(" "),
            3 * mesh.nodes.len()
        );
        let mut subjects = [
            ("CSR f64", timed::<f64>(&csr)),
            ("f64", timed::<f64>(&*double)),
            ("f32", timed::<f32>(&*single)),
        ];
        let mut seconds = Vec::new();
        for _ in 0..ROUNDS {
            seconds.push(
                subjects
                    .each_mut()
                    .map(|(_, product)| [0, 1].map(|p| pools[p].install(&mut *product))),
            );
        }
        for (k, (name, _)) in subjects.iter().enumerate() {
            let [one, two] =
                [0, 1].map(|p| Sorted::new(seconds.iter().map(|round| 1e3 * round[k][p])));
            let ratio = Sorted::new(seconds.iter().map(|round| round[k][0] / round[k][1]));
            println!("  {name:8} one thread {one} ms, two {two} ms, two over one {ratio}");
        }
        let ratio =
            |a: usize, b: usize| Sorted::new(seconds.iter().map(|round| round[a][0] / round[b][0]));
        println!(
            "  one thread: f64 over CSR {}, f32 over f64 {}",
            ratio(0, 1),
            ratio(1, 2)
        );
    }
}
