//! Claim: every operator and every preconditioner obeys the laws of its trait, in f64 and f32, with every instruction set and on one
//! thread and two, allocates nothing, and says how many operations it takes.
//!
//! One list of each; `operators/src/laws/broken.rs` shows that every law can fail.
#![allow(clippy::unwrap_used)]

mod counting;
#[allow(dead_code, reason = "other claims need more of it")]
mod coupled;

use counting::{allocations, threads};
use fracas::contact::{Coupling, JumpStabilization};
use fracas::elasticity::{Bricks, Hexes, Restricted, stiffness};
use fracas::matrix_free::{MatrixFreeSaddle, RacpParts};
use fracas::nonlinear::ContactProblem;
use fracas::scene::{Body, named};
use fracas_operators::laws::{
    check_adjoint, check_flops, check_flops_of_solve, check_operator, check_preconditioner, probe,
};
use fracas_operators::simd::Level;
use fracas_operators::sparse::{Csr, Diagonal};
use fracas_operators::tally::Tally;
use fracas_operators::{
    Adjoint, AdjointOperator, BlockOperator, Counted, Dense, Identity, Layout, LinearOperator,
    Preconditioner, Real,
};
use fracas_solvers::Silent;
use fracas_solvers::direct::{DirectChoice, Kind};
use fracas_solvers::fsai::{Fsai, FsaiInverse};
use fracas_solvers::krylov::Narrowed;
use fracas_solvers::saddle::{
    AugmentationChoice, Form, PressureSchur, Racp, SaddleBlocks, SaddleMethod, SaddleOperator, T,
    ThreeFields, U, schur,
};
use rayon::ThreadPool;

/// Share of its operations by which the count of a kernel may be off, where elements at the boundary take more. Unit: 1.
const PER_ELEMENT: f64 = 0.5;

/// The same where a row is summed in four parts, which are added at its end. Unit: 1.
const PARTIAL_SUMS: f64 = 0.06;

/// Bodies of bricks and of general hexahedra, cut by fractures.
fn bodies() -> Vec<(&'static str, Body)> {
    let built = ["crossing", "inclined"].map(|name| {
        let scene = named(name).unwrap().small_scene().unwrap();
        (name, scene.build().unwrap())
    });
    built.into()
}

/// An operator under test.
enum Subject<R: Real> {
    Product(Box<dyn LinearOperator<R>>),
    WithAdjoint(Box<dyn AdjointOperator<R>>),
}

impl<R: Real> Subject<R> {
    fn product(&self) -> &dyn LinearOperator<R> {
        match self {
            Self::Product(a) => a,
            Self::WithAdjoint(a) => a,
        }
    }
}

/// Name, operator, by how much its `flops()` may be off.
type Listed<R> = (String, Subject<R>, f64);

/// The list of operators, with entries of size one.
fn operators<R: Real>(name: &str, body: &Body) -> Vec<Listed<R>> {
    let mut list: Vec<Listed<R>> = Vec::new();
    let mut with_adjoint = |kind: &str, a: Box<dyn AdjointOperator<R>>, slack: f64| {
        let subject = Subject::WithAdjoint(a);
        list.push((format!("{kind} of {name} in {}", R::NAME), subject, slack));
    };
    let rocks: Vec<_> = (body.materials.iter())
        .map(|rock| fracas::elasticity::Elastic {
            young: 1.0,
            ..*rock
        })
        .collect();
    let assembled = stiffness(&body.mesh, &rocks).unwrap();
    let block3 = || assembled.cast::<R>();
    let csr = || Csr::new(block3().to_csr());
    let rows = assembled.shape().rows;
    with_adjoint("Csr", Box::new(csr()), PARTIAL_SUMS);
    with_adjoint(
        "Csr with its transpose",
        Box::new(Csr::with_transpose(block3().to_csr())),
        PARTIAL_SUMS,
    );
    for level in Level::supported() {
        let named = |kind: &str| format!("{kind} with {level:?}");
        with_adjoint(
            &named("Block3"),
            Box::new(block3().with_level(level)),
            PARTIAL_SUMS,
        );
        let hexes = Hexes::<R>::with_level(&body.mesh, &rocks, level).unwrap();
        with_adjoint(&named("Hexes"), Box::new(hexes), PER_ELEMENT);
        if let Ok(bricks) = Bricks::<R>::with_level(&body.mesh, &rocks, level) {
            with_adjoint(&named("Bricks"), Box::new(bricks), PER_ELEMENT);
        }
    }
    let diagonal = Diagonal::new(probe::<R>(rows, 20));
    with_adjoint("Diagonal", Box::new(diagonal), 0.0);
    let dense = Dense::from_fn(fracas_operators::Shape::new(17, 29), |i, j| {
        R::of(((3 * i + 7 * j) % 11) as f64 - 5.0)
    });
    with_adjoint("Dense", Box::new(dense.clone()), 0.2);
    with_adjoint("Adjoint", Box::new(Adjoint(dense)), 0.2);
    with_adjoint("Counted", Box::new(Counted::new(csr())), PARTIAL_SUMS);
    let coupling = || Coupling::<R>::new(&body.fractures, &body.constraints);
    with_adjoint("Coupling", Box::new(coupling()), PER_ELEMENT);
    with_adjoint(
        "Adjoint of Coupling",
        Box::new(Adjoint(coupling())),
        PER_ELEMENT,
    );
    let restricted = || Restricted::new(block3(), body.constraints.clone());
    with_adjoint("Restricted", Box::new(restricted()), 0.05);
    let mut product = |kind: &str, a: Box<dyn LinearOperator<R>>, slack: f64| {
        let subject = Subject::Product(a);
        list.push((format!("{kind} of {name} in {}", R::NAME), subject, slack));
    };
    // [A B; Bᵀ 0]
    let layout = Layout::new([
        (U, body.constraints.free_len()),
        (T, 3 * body.fractures.faces.len()),
    ]);
    let grid = BlockOperator::new(layout)
        .with([U, U], R::one(), restricted())
        .with([U, T], R::one(), coupling())
        .with([T, U], R::one(), Adjoint(coupling()));
    product("grid of blocks", Box::new(grid), PER_ELEMENT);
    let system = body.stick_system(Some(JumpStabilization::default()));
    let unit = system.magnitude().unwrap().unit;
    let saddle = MatrixFreeSaddle::<R>::in_traction_unit(&system, unit).unwrap();
    product("MatrixFreeSaddle", Box::new(saddle), PER_ELEMENT);
    list
}

/// Allocations of three times `work`, after a first time.
fn allocations_again(pool: &ThreadPool, work: &mut (dyn FnMut() + Send)) -> u64 {
    pool.install(|| {
        work();
        allocations(|| (0..3).for_each(|_| work()))
    })
}

fn bits<R: Real>(values: &[R]) -> Vec<u64> {
    let value = |v: &R| v.to_f64_exact().to_bits();
    values.iter().map(value).collect()
}

fn hold_operators<R: Real>(pools: &[ThreadPool; 2], oracles: &[Dense<f64>], list: &[Listed<R>]) {
    for ((name, subject, _), oracle) in list.iter().zip(oracles) {
        let exact = Dense::from_columns(
            oracle.shape(),
            oracle.values().iter().map(|v| R::of(*v)).collect(),
        );
        let a = subject.product();
        let shape = a.shape();
        let mut seen: Option<Vec<u64>> = None;
        for pool in pools {
            let checked = pool.install(|| match subject {
                Subject::Product(a) => check_operator(name, a, Some(&exact)),
                Subject::WithAdjoint(a) => check_adjoint(name, a, Some(&exact)),
            });
            checked.unwrap();
            let x = probe::<R>(shape.cols, 21);
            let (mut y, mut work) = (vec![R::zero(); shape.rows], vec![R::nan(); a.work_len()]);
            let made = allocations_again(pool, &mut || a.apply(&x, &mut y, &mut work));
            assert_eq!(made, 0, "{name} allocates");
            let own = bits(&y);
            assert!(
                seen.as_ref().is_none_or(|seen| *seen == own),
                "{name}: bits depend on threads"
            );
            seen = Some(own);
        }
    }
}

#[test]
fn all_laws_hold_for_all_operators_and_preconditioners() {
    // one test, because the counter of allocations belongs to the whole process
    let pools = [1, 2].map(threads);
    std::panic::set_hook(Box::new(|info| {
        // vectors that do not fit are refused by a panic
        if !info.to_string().contains(" operator with x of length ") {
            eprintln!("{info}");
        }
    }));
    for (name, body) in bodies() {
        let double = operators::<f64>(name, &body);
        // another representation of the same map is what tells of a wrong one
        let oracles: Vec<_> = (double.iter())
            .map(|(_, subject, _)| Dense::of_operator(subject.product()))
            .collect();
        agree(&double, &oracles);
        hold_operators(&pools, &oracles, &double);
        hold_operators(&pools, &oracles, &operators::<f32>(name, &body));
        pools[0].install(|| {
            let list = operators::<Tally>(name, &body);
            let wrong = list.iter().filter_map(|(name, subject, slack)| {
                check_flops(name, subject.product(), *slack).err()
            });
            let wrong: Vec<_> = wrong.map(|violation| violation.to_string()).collect();
            assert!(wrong.is_empty(), "{}", wrong.join("\n"));
        });
        jacobians(&pools, &body);
        preconditioners(&pools, name, &body);
    }
}

/// The stiffness is one matrix, however it is applied.
fn agree(list: &[Listed<f64>], oracles: &[Dense<f64>]) {
    let stiffness = |name: &str| {
        ["Csr", "Block3", "Hexes", "Bricks"]
            .iter()
            .any(|kind| name.starts_with(kind))
    };
    let mut all = list
        .iter()
        .zip(oracles)
        .filter(|((name, _, _), _)| stiffness(name));
    let (_, first) = all.next().unwrap();
    for ((name, _, _), other) in all {
        let size = first.max_abs();
        let entries = first.values().iter().zip(other.values());
        let largest = entries.map(|(a, b)| (a - b).abs()).fold(0.0, f64::max);
        assert!(largest <= 1e-13 * size, "{name}: {largest:e}");
    }
}

/// Those of a contact problem: [`SaddleOperator`] and the Jacobian without an assembled A.
fn jacobians(pools: &[ThreadPool; 2], body: &Body) {
    let problem = ContactProblem::new(body).unwrap();
    let blocks = problem.stick_blocks().unwrap();
    let assembled = SaddleOperator::new(&blocks);
    for pool in pools {
        pool.install(|| check_operator("SaddleOperator", &assembled, None))
            .unwrap();
        pool.install(|| check_operator("saddle of a contact problem", problem.saddle(), None))
            .unwrap();
    }
}

fn preconditioners(pools: &[ThreadPool; 2], name: &str, body: &Body) {
    let system = body.stick_system(Some(JumpStabilization::default()));
    let unit = system.magnitude().unwrap().unit;
    let blocks = body
        .saddle_blocks(Some(JumpStabilization::default()))
        .unwrap()
        .into_traction_unit(unit);
    let operator = SaddleOperator::new(&blocks);
    let mut list: Vec<(String, Box<dyn Preconditioner<f64>>, bool)> = Vec::new();
    for method in SaddleMethod::all() {
        let inner: &[Option<&str>] = match method.inner() {
            None => &[None],
            Some(_) => &[
                Some("exact"),
                Some("amg"),
                Some("amg:gauss_seidel:f64"),
                Some("amg:chebyshev"),
                Some("amg:fsai"),
                Some("fsai"),
                Some("fsai:static"),
                Some("jacobi"),
                Some("ssor"),
                // refused, and so left out, without the feature petsc
                Some("gamg"),
                Some("boomeramg"),
                Some("mumps"),
            ],
        };
        for inner in inner {
            let parsed = inner.and_then(|inner| inner.parse().ok());
            let Ok(method) = method.with_parts(None, parsed) else {
                continue;
            };
            // a singular A is refused by those that invert it
            let Ok(ready) = method.ready(&blocks) else {
                continue;
            };
            let of = inner
                .map(|inner| format!(" around {inner}"))
                .unwrap_or_default();
            let is_inverse = method.name() == "direct";
            list.push((
                format!("{}{of} of {name}", method.name()),
                ready.inverse,
                is_inverse,
            ));
        }
    }
    assert!(list.len() > 12, "{} methods were set up", list.len());
    for (schur, form, inner) in PressureSchur::ALL
        .into_iter()
        .zip(Form::ALL.into_iter().cycle())
        .zip(["amg", "exact", "fsai", "ssor", "jacobi", "amg:chebyshev"])
        .map(|((schur, form), inner)| (schur, form, inner))
    {
        let coupled = coupled::balanced(coupled::coupled(body, coupled::Flow::default(), 7));
        let racp = SaddleMethod::Racp(Racp {
            inner: inner.parse().unwrap(),
            flow: ThreeFields { schur, form },
            ..Racp::default()
        });
        let of = format!("three fields, {schur}, {form}, direct S_p, {inner} of {name}");
        list.push((of, racp.ready(&coupled).unwrap().inverse, false));
    }
    if body.mesh.grid.is_some() {
        let saddle = MatrixFreeSaddle::in_traction_unit(&system, unit).unwrap();
        let parts = RacpParts::new(&Racp::geometric(), &saddle, &system, &mut Silent).unwrap();
        list.push((
            format!("geometric of {name}"),
            Box::new(parts.inverse),
            false,
        ));
    }
    for choice in DirectChoice::BACKENDS {
        // a build without SuiteSparse has one backend
        let Ok(direct) = choice.solver() else {
            continue;
        };
        let s_u = schur::primal_schur(&blocks.a, &blocks.b1, &c(&blocks)).unwrap();
        let factors = direct
            .analyze(&s_u, Kind::Spd)
            .unwrap()
            .factor(&s_u)
            .unwrap();
        let made = Csr::new(s_u);
        for pool in pools {
            let subject = format!("{choice} of S_u of {name}");
            pool.install(|| check_preconditioner(&subject, &*factors, Some(&made), 1e-7))
                .unwrap();
        }
    }
    for (name, m, is_inverse) in &list {
        let mut seen: Option<Vec<u64>> = None;
        for pool in pools {
            let matrix = is_inverse.then_some(&operator as &dyn LinearOperator<f64>);
            pool.install(|| check_preconditioner(name, &**m, matrix, 1e-7))
                .unwrap();
            let r = probe::<f64>(m.size(), 22);
            let (mut z, mut work) = (vec![0.0; m.size()], vec![f64::NAN; m.work_len()]);
            let made = allocations_again(pool, &mut || m.solve(&r, &mut z, &mut work));
            // factorizations of others allocate within
            let quiet = !["exact", "direct", "mcp"]
                .iter()
                .any(|part| name.contains(part));
            assert!(made == 0 || !quiet, "{name} allocates {made} times");
            let own = bits(&z);
            assert!(
                seen.as_ref().is_none_or(|seen| *seen == own),
                "{name}: bits depend on threads"
            );
            seen = Some(own);
        }
    }
    let (around, m, _) = list.last().unwrap();
    let (narrowed, subject) = (Narrowed(&**m), format!("{around}, for f32"));
    pools[0]
        .install(|| check_preconditioner::<f32>(&subject, &narrowed, None, 1e-3))
        .unwrap();
    let r = probe::<f32>(m.size(), 22);
    let (mut z, mut work) = (vec![0.0; m.size()], vec![f32::NAN; narrowed.work_len()]);
    let made = allocations_again(&pools[0], &mut || narrowed.solve(&r, &mut z, &mut work));
    assert_eq!(made, 0, "{subject} allocates");
    let s_u = schur::primal_schur(&blocks.a, &blocks.b1, &c(&blocks)).unwrap();
    pools[0].install(|| {
        let fsai: FsaiInverse<Tally> = Fsai::default().build(&s_u).unwrap().cast();
        check_flops_of_solve("FSAI", &fsai, 0.2).unwrap();
        check_flops_of_solve("Identity", &Identity { n: 9 }, 0.0).unwrap();
    });
}

fn c(blocks: &SaddleBlocks) -> fracas_solvers::saddle::AugmentationMatrix {
    let direct = DirectChoice::default().solver().unwrap();
    AugmentationChoice::LocalH
        .compute(blocks, &*direct)
        .unwrap()
        .matrix
}
