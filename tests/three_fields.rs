//! Claim: flow and mechanics together take hardly more iterations than mechanics alone, however large conductivities, whatever share
//! of faces is open.
#![allow(clippy::unwrap_used)]

#[allow(dead_code, reason = "other claims need more of it")]
mod coupled;

use coupled::{Flow, balanced, body, coupled};
use fracas::scene::Scene;
use fracas::solve::{Problem, Solve};
use fracas_operators::random::signed;
use fracas_operators::sparse::Csr;
use fracas_operators::vector::{axpy, dot, norm2};
use fracas_operators::{LinearOperator, Preconditioner};
use fracas_solvers::direct::{DirectChoice, Kind};
use fracas_solvers::krylov::{Criteria, KrylovChoice, System};
use fracas_solvers::saddle::folder::{Manifest, write_folder};
use fracas_solvers::saddle::{
    AugmentationMatrix, Form, Iterated, NearSchur, PressureFactors, PressureSchur, Racp,
    SaddleBlocks, SaddleMethod, SaddleOperator, ThreeFields,
};
use fracas_solvers::{Prepare, Silent};
use rayon::prelude::*;

/// Most iterations before a system counts as not solved. Unit: 1.
const MOST: usize = 400;

/// The loads of a scene and pressures about one value.
fn right_hand_side(blocks: &SaddleBlocks, operator: &SaddleOperator<'_>) -> Vec<f64> {
    let (n, n_p) = (blocks.size(), blocks.n_p());
    let mut exact = vec![0.0; n];
    let size = blocks.rhs_u.iter().fold(0.0f64, |m, f| m.max(f.abs()));
    let largest = blocks.flow.iter().flat_map(|flow| flow.q1.data());
    let largest = largest.fold(f64::MIN_POSITIVE, |m, q| m.max(q.abs()));
    for (i, p) in exact[n - n_p..].iter_mut().enumerate() {
        *p = size / largest * (1.0 + 0.3 * signed(i as u64));
    }
    let mut rhs = blocks.rhs();
    operator.apply_add(1.0, &exact, &mut rhs, &mut vec![0.0; operator.work_len()]);
    rhs
}

/// Iterations to a residual of 1e-8, or [`MOST`], and C_s.
fn iterations(blocks: &SaddleBlocks, racp: Racp) -> (usize, f64) {
    let operator = SaddleOperator::new(blocks);
    let preconditioner = SaddleMethod::Racp(racp).prepare(blocks).unwrap();
    let system = System {
        operator: &operator,
        preconditioner: &preconditioner,
        rhs: &right_hand_side(blocks, &operator),
    };
    let criteria = Criteria {
        relative_tolerance: 1e-8,
        max_iterations: MOST,
    };
    let mut x = vec![0.0; blocks.size()];
    let krylov = KrylovChoice::default();
    let iterated = Iterated::new(&system, krylov, &criteria, &mut x, &mut Silent);
    (
        iterated.iterations().unwrap_or(MOST),
        iterated.c_s().unwrap_or(f64::INFINITY),
    )
}

/// Steps `x ← x + M⁻¹(b − 𝒜x)` to a residual of 1e-8, or [`MOST`]: with the upper form the sequential fixed-stress split.
fn steps(blocks: &SaddleBlocks, racp: Racp) -> usize {
    let operator = SaddleOperator::new(blocks);
    let preconditioner = SaddleMethod::Racp(racp).prepare(blocks).unwrap();
    let b = right_hand_side(blocks, &operator);
    let mut work = vec![0.0; operator.work_len().max(preconditioner.work_len())];
    let (mut x, mut r, mut z) = (vec![0.0; b.len()], b.clone(), b.clone());
    for step in 0..MOST {
        if norm2(&r) <= 1e-8 * norm2(&b) {
            return step;
        }
        preconditioner.solve(&r, &mut z, &mut work);
        axpy(1.0, &z, &mut x);
        r.copy_from_slice(&b);
        operator.apply_add(-1.0, &x, &mut r, &mut work);
    }
    MOST
}

fn racp(inner: &str, schur: PressureSchur, form: Form) -> Racp {
    Racp {
        inner: inner.parse().unwrap(),
        flow: ThreeFields { schur, form },
        ..Racp::default()
    }
}

/// The scene with n cells along x and z.
fn crossing(n: usize) -> fracas::scene::Body {
    let cells = [("x", n), ("y", n / 2), ("z", n)];
    let overrides = cells.map(|(axis, n)| format!("mesh.{axis}.cells={n}"));
    body("crossing", &overrides.each_ref().map(String::as_str))
}

/// Iterations with flow and without, by mesh, share of open faces and size of T.
#[test]
#[ignore = "prints a table: FRACAS_CELLS=8,16 FRACAS_INNER=amg cargo test --release --test three_fields -- --ignored --nocapture"]
fn table_of_iterations() {
    let list = |name: &str, default: &str| -> Vec<String> {
        let text = std::env::var(name).unwrap_or_else(|_| default.to_owned());
        text.split(',').map(str::to_owned).collect()
    };
    let number = |text: &String| text.parse::<f64>().unwrap();
    let choices = list(
        "FRACAS_SCHUR",
        &PressureSchur::ALL.map(PressureSchur::name).join(","),
    );
    let forms = list("FRACAS_FORM", "full");
    let with_steps = std::env::var("FRACAS_STEPS").is_ok();
    println!(
        "cells inner open derivative | mechanics | T: {:?}",
        list("FRACAS_T", "")
    );
    for n in list("FRACAS_CELLS", "8") {
        let body = crossing(n.parse().unwrap());
        for inner in list("FRACAS_INNER", "amg") {
            for open in list("FRACAS_OPEN", "0,0.3,1").iter().map(number) {
                for derivative in list("FRACAS_DERIVATIVE", "0").iter().map(number) {
                    let flow = Flow {
                        open,
                        derivative,
                        ..Flow::default()
                    };
                    let alone = SaddleBlocks {
                        flow: None,
                        ..balanced(coupled(&body, flow, 3))
                    };
                    let (first, _) =
                        iterations(&alone, racp(&inner, PressureSchur::default(), Form::Full));
                    for schur in &choices {
                        for form in &forms {
                            let settings =
                                racp(&inner, schur.parse().unwrap(), form.parse().unwrap());
                            let row = list("FRACAS_T", "1e-12,1e-6,1e-3,1,1e3,1e6,1e12");
                            let row: Vec<String> = (row.iter().map(number))
                                .map(|size| {
                                    let blocks = coupled(&body, Flow { size, ..flow }, 3);
                                    let blocks = balanced(blocks);
                                    let (n, c_s) = iterations(&blocks, settings);
                                    match with_steps {
                                        true => format!(
                                            "{n:4} ({c_s:6.0}, {:4} steps)",
                                            steps(&blocks, settings)
                                        ),
                                        false => format!("{n:4} ({c_s:6.0})"),
                                    }
                                })
                                .collect();
                            println!(
                                "{n:>3} {inner} {open} {derivative} {schur:>20} {form} | {first:3} | {}",
                                row.join(" ")
                            );
                        }
                    }
                }
            }
        }
    }
}

#[test]
fn iterations_depend_little_on_conductivity_and_share_of_open_faces() {
    let body = crossing(8);
    for open in [0.0, 0.3, 1.0] {
        let flow = Flow {
            open,
            ..Flow::default()
        };
        let alone = SaddleBlocks {
            flow: None,
            ..balanced(coupled(&body, flow, 3))
        };
        let amg = racp("amg", PressureSchur::default(), Form::Full);
        let (alone, _) = iterations(&alone, amg);
        for size in [1e-12, 1e-3, 1.0, 1e3, 1e12] {
            let blocks = balanced(coupled(&body, Flow { size, ..flow }, 3));
            let (n, _) = iterations(&blocks, amg);
            assert!(
                n <= 25 && 2 * n <= 3 * alone,
                "{n} iterations, {alone} without flow: {flow:?}, size {size:e}"
            );
        }
    }
}

/// Ends of the spectrum of `S_p⁻¹ (T − Q2 A⁻¹ Q1)` for an open square crack with n faces to a side in a box, T little more than what holds
/// pressures that alternate.
fn ends(n: usize, schur: PressureSchur) -> [f64; 2] {
    let cells = (n + 4).to_string();
    let half = n as f64 / 2.0;
    let toml = format!(
        "title = 'crack'\n[mesh]\nx = {{ from = '-2 m', to = '{0} m', cells = {cells} }}\ny = {{ from = '-2 m', to = '{0} m', \
         cells = {cells} }}\nz = {{ from = '-{half} m', to = '{half} m', cells = {n} }}\n[[material]]\nname = 'rock'\n\
         young = '10 GPa'\npoisson = 0.25\n[[fracture]]\nname = 'F'\nplane = 'z'\nat = '0 m'\nx = ['0 m', '{n} m']\n\
         y = ['0 m', '{n} m']\n[[boundary]]\nside = 'z-'\nhold = 'fixed'\n[[boundary]]\nside = 'z+'\nhold = 'fixed'\n",
        n + 2
    );
    let body = Scene::from_toml(&toml, "crack.toml")
        .unwrap()
        .build()
        .unwrap();
    let flow = Flow {
        open: 1.0,
        size: 1e-6,
        ..Flow::default()
    };
    let blocks = balanced(coupled(&body, flow, 3));
    let flow = blocks.flow.as_ref().unwrap();
    let direct = DirectChoice::default().solver().unwrap();
    let a = direct
        .analyze(&blocks.a, Kind::Spd)
        .unwrap()
        .factor(&blocks.a)
        .unwrap();
    // every face is open: C is nowhere
    let c = AugmentationMatrix::from_diagonal(vec![1e30; blocks.n_t()]).unwrap();
    let near = |rows| NearSchur::new(rows, (&blocks.a, &blocks.b1), &c);
    let s_p = schur.system(flow, near, &a).unwrap();
    let s_p = PressureFactors::default().factor(&s_p).unwrap();
    let [q1, q2, t] = [&flow.q1, &flow.q2, &flow.t].map(|m| Csr::new(m.clone()));
    let mut work = vec![0.0; a.work_len().max(s_p.work_len())];
    let mut product = |p: &[f64]| {
        let (mut f, mut u) = (vec![0.0; blocks.n_u()], vec![0.0; blocks.n_u()]);
        q1.apply_add(1.0, p, &mut f, &mut []);
        a.solve(&f, &mut u, &mut work);
        let (mut r, mut z) = (vec![0.0; p.len()], vec![0.0; p.len()]);
        q2.apply_add(-1.0, &u, &mut r, &mut []);
        t.apply_add(1.0, p, &mut r, &mut []);
        s_p.solve(&r, &mut z, &mut work);
        z
    };
    // power iterations, for the largest eigenvalue and then for its distance from the smallest
    let mut end = |shift: f64| {
        let mut p: Vec<f64> = (0..blocks.n_p())
            .map(|i| 1.0 + 0.5 * signed(i as u64))
            .collect();
        let mut value = 0.0;
        for _ in 0..150 {
            let z = product(&p);
            let next: Vec<f64> = p.iter().zip(&z).map(|(p, z)| z - shift * p).collect();
            value = dot(&p, &next) / dot(&p, &p);
            let size = norm2(&next);
            p = next.iter().map(|v| v / size).collect();
        }
        value + shift
    };
    let high = end(0.0);
    [end(high), high]
}

/// Why `half_order` serves: the volume that a crack takes up grows with the length of the wave of pressure, for it as for the rock; that of a
/// face or of the diagonal of S_u does not know the length.
#[test]
fn a_crack_gives_way_to_each_wave_of_pressure_as_half_order_says() {
    for n in [4, 8, 12] {
        let forms = [
            PressureSchur::HalfOrder,
            PressureSchur::FixedStress,
            PressureSchur::Diagonal,
        ];
        let found: Vec<_> = forms.into_par_iter().map(|form| ends(n, form)).collect();
        let ([low, high], others) = (found[0], &found[1..]);
        println!(
            "{n} faces to a side: half order [{low:.2}, {high:.2}], by face and diagonal {others:.2?}"
        );
        assert!(low > 0.4 && high / low < 4.0, "{n}: {low} {high}");
        assert!(
            n < 12 || others.iter().all(|[low, high]| high / low > 4.5),
            "{others:?}"
        );
    }
}

/// A folder, whatever T is: converged by the errors of all three fields, which a factorization of the whole confirms.
#[test]
fn a_folder_with_flow_is_solved_until_the_errors_of_u_t_and_p_are_small() {
    let folder = std::env::temp_dir().join(format!("fracas-three-fields-{}", std::process::id()));
    let body = crossing(8);
    for (open, derivative) in [(0.0, 0.0), (0.4, 0.3), (1.0, 0.0)] {
        for size in [1e-12, 1.0, 1e12] {
            let flow = Flow {
                open,
                size,
                derivative,
                ..Flow::default()
            };
            let mut blocks = coupled(&body, flow, 3);
            let rhs = right_hand_side(&blocks, &SaddleOperator::new(&blocks));
            let (n_u, n_t) = (blocks.n_u(), blocks.n_t());
            blocks.rhs_u = rhs[..n_u].to_vec();
            blocks.rhs_t = rhs[n_u..n_u + n_t].to_vec();
            if let Some(flow) = &mut blocks.flow {
                flow.rhs_p = rhs[n_u + n_t..].to_vec();
            }
            write_folder(&folder, &blocks, &Manifest::default()).unwrap();
            let solve = |method: &str| {
                let settings = Solve {
                    method: method.parse().unwrap(),
                    ..Solve::default()
                };
                settings.solve(&Problem::Folder(folder.clone()), &mut Silent)
            };
            let (solved, exact) = (solve("racp").unwrap(), solve("direct").unwrap());
            assert!(solved.has_converged(), "{:?} at {flow:?}", solved.reason);
            assert!(solved.error_p.unwrap() <= 1e-8 && solved.n_p == blocks.n_p());
            let norms_of = blocks.pressure_compliance();
            let norm = |p: &mut dyn Iterator<Item = f64>| -> f64 {
                let squares = p.zip(&norms_of).map(|(p, w)| w * p * p);
                squares.sum::<f64>().sqrt()
            };
            let [p, q] = [&solved.x, &exact.x].map(|x| &x[n_u + n_t..]);
            let error = norm(&mut p.iter().zip(q).map(|(p, q)| p - q));
            let size = norm(&mut q.iter().copied());
            assert!(error <= 1e-7 * size, "{:e} at {flow:?}", error / size);
        }
    }
    std::fs::remove_dir_all(folder).unwrap();
}
