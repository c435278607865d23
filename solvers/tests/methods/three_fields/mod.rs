//! Claim: preconditioners of three fields are the formulas, in every form.

mod spectra;

use crate::iterations::{solve, until};
use crate::oracle::{
    DenseInverse, Full, assert_spectrum, full, inverse, operator, spectrum, stacked,
};
use crate::samples::{random, trusses};
use crate::with_flow::{Flow, with_flow};
use faer::Mat;
use fracas_operators::laws::{check_parts, check_preconditioner, probe};
use fracas_operators::random::{Random, signed};
use fracas_operators::sparse::{Csr, SparseMatrix, Triplets};
use fracas_operators::{Identity, LinearOperator, Preconditioner};
use fracas_solvers::direct::DirectChoice;
use fracas_solvers::eigen::dense;
use fracas_solvers::krylov::{KrylovChoice, Outcome};
use fracas_solvers::saddle::{
    AugmentationMatrix, Elimination, FlowBlocks, Form, NearSchur, PressureFactors, PressureSchur,
    PressureSystem, Racp, RacpInverse, SaddleBlocks, SaddleMethod, SaddleOperator, ThreeFields,
    ThreeFieldsInverse,
};
use fracas_solvers::{Prepare, SetupError};

const FLOW: Flow = Flow {
    open: 0.5,
    size: 1.0,
    storage: 0.1,
    derivative: 0.0,
    rate: 1.0,
};

fn csr(m: &SparseMatrix<f64>) -> Csr<f64> {
    Csr::new(m.clone())
}

fn flow_of(blocks: &SaddleBlocks) -> &FlowBlocks {
    blocks.flow.as_ref().unwrap()
}

/// `[[A, B1, Q1], [B2, −C, 0], [Q2, 0, T]]` for an `[A B1; B2 −C]`.
fn bordered(ut: &Mat<f64>, flow: &FlowBlocks) -> Mat<f64> {
    let n_p = flow.t.rows();
    let (q1, q2) = (full(&flow.q1), full(&flow.q2));
    let n_u = q1.nrows();
    let tall = Mat::from_fn(
        ut.nrows(),
        n_p,
        |i, j| if i < n_u { q1[(i, j)] } else { 0.0 },
    );
    let wide = Mat::from_fn(
        n_p,
        ut.nrows(),
        |i, j| if j < n_u { q2[(i, j)] } else { 0.0 },
    );
    stacked(ut, &tall, &wide, &full(&flow.t))
}

/// A and B of the blocks, C on its diagonal, S_u.
struct Parts {
    a: Mat<f64>,
    b: Mat<f64>,
    c: Vec<f64>,
    s_u: Mat<f64>,
}

impl Parts {
    fn new(blocks: &SaddleBlocks, c: Vec<f64>) -> Self {
        let Full { a, b1: b, .. } = Full::new(blocks);
        let scaled = Mat::from_fn(b.nrows(), c.len(), |i, k| b[(i, k)] / c[k]);
        Self {
            s_u: &a + &scaled * b.transpose(),
            a,
            b,
            c,
        }
    }

    fn racp(&self, blocks: &SaddleBlocks) -> RacpInverse<'static> {
        let c = AugmentationMatrix::from_diagonal(self.c.clone()).unwrap();
        RacpInverse::new(blocks.b1.clone(), c, DenseInverse::of(&self.s_u))
    }

    fn diagonal(&self) -> Mat<f64> {
        let n = self.c.len();
        Mat::from_fn(n, n, |i, j| if i == j { self.c[i] } else { 0.0 })
    }

    /// `−Q2 S_u⁻¹ Q1`.
    fn given(&self, flow: &FlowBlocks) -> Mat<f64> {
        -(full(&flow.q2) * (inverse(&self.s_u) * full(&flow.q1)))
    }
}

/// Stick everywhere, so that C = H is possible, with Q2 on some faces all the same.
fn stick_with_flow(seed: u64, flow: Flow) -> SaddleBlocks {
    let stick = random(12, 6, 0.3, seed);
    let flowing = with_flow(random(12, 6, 0.3, seed), flow, seed);
    SaddleBlocks {
        flow: flowing.flow,
        ..stick
    }
}

#[test]
fn the_full_form_is_the_inverse_of_what_it_is_made_of_and_each_part_counts() {
    for seed in 0..20 {
        let derivative = signed(seed);
        let blocks = stick_with_flow(seed, Flow { derivative, ..FLOW });
        let flow = flow_of(&blocks);
        let parts = Parts::new(&blocks, vec![0.7; 6]);
        let ut = stacked(
            &parts.a,
            &parts.b,
            &parts.b.transpose().to_owned(),
            &-parts.diagonal(),
        );
        let s_p = full(&flow.t) + parts.given(flow);
        let [q1, q2] = [csr(&flow.q1), csr(&flow.q2)];
        let m = ThreeFieldsInverse::new(
            parts.racp(&blocks),
            q1,
            Some(q2),
            DenseInverse::of(&s_p),
            Form::Full,
        );
        let whole = operator(&bordered(&ut, flow));
        check_preconditioner("three fields", &m, Some(&whole), 1e-8).unwrap();
    }
    let blocks = stick_with_flow(1, FLOW);
    let flow = flow_of(&blocks);
    for form in Form::ALL {
        check_parts("three fields", [18, 2], |[ut, s_p]| {
            ThreeFieldsInverse::new(ut, csr(&flow.q1), Some(csr(&flow.q2)), s_p, form)
        })
        .unwrap();
    }
}

/// S_p of a choice for blocks whose mechanics are exact.
fn system(choice: PressureSchur, blocks: &SaddleBlocks, parts: &Parts) -> PressureSystem {
    let c = AugmentationMatrix::from_diagonal(parts.c.clone()).unwrap();
    let near = |rows| NearSchur::new(rows, (&blocks.a, &blocks.b1), &c);
    let inverse = DenseInverse::of(&parts.s_u);
    choice.system(flow_of(blocks), near, &inverse).unwrap()
}

/// On springs, where B_n of a face has two entries, S_u is known entry by entry.
#[test]
fn every_schur_complement_is_what_its_formula_says() {
    for seed in 0..8 {
        let flow = Flow {
            derivative: f64::from(u8::from(seed % 2 == 0)),
            open: 0.7,
            ..FLOW
        };
        let blocks = with_flow(trusses(3, 10.0, false), flow, seed);
        let parts = Parts::new(&blocks, vec![0.5; blocks.n_t()]);
        let flow = flow_of(&blocks);
        let (n_p, t) = (flow.t.rows(), full(&flow.t));
        let (q1, q2) = (full(&flow.q1), full(&flow.q2));
        let restricted = |i: usize, columns: &[usize], j: usize| -> f64 {
            let is_in = |row: &usize| columns.iter().any(|&k| q1[(*row, k)] != 0.0);
            let rows: Vec<usize> = (0..q1.nrows()).filter(is_in).collect();
            let n = rows.len();
            let s = Mat::from_fn(n, n, |k, l| parts.s_u[(rows[k], rows[l])]);
            let s = inverse(&s);
            let mut sum = 0.0;
            for k in 0..n {
                for l in 0..n {
                    sum -= q2[(i, rows[k])] * s[(k, l)] * q1[(rows[l], j)];
                }
            }
            sum
        };
        let given = parts.given(flow);
        let expected = |choice, i: usize, j: usize| -> f64 {
            let neighbours: Vec<usize> = (0..n_p).filter(|&k| t[(i, k)] != 0.0).collect();
            let is_near = neighbours.contains(&j);
            let is_open = (0..q2.ncols()).any(|k| q2[(i, k)] != 0.0);
            match choice {
                _ if !is_open => 0.0,
                PressureSchur::FixedStress if i == j => restricted(i, &[i], i),
                PressureSchur::PatchFixedStress if is_near => restricted(i, &neighbours, j),
                PressureSchur::Diagonal if is_near => (0..q1.nrows())
                    .map(|k| -q2[(i, k)] * q1[(k, j)] / parts.s_u[(k, k)])
                    .sum(),
                PressureSchur::Exact => given[(i, j)],
                _ => 0.0,
            }
        };
        for choice in PressureSchur::ALL {
            if choice == PressureSchur::HalfOrder {
                continue;
            }
            let found = full(system(choice, &blocks, &parts).matrix());
            let m = Mat::from_fn(n_p, n_p, |i, j| expected(choice, i, j));
            let size = found.norm_max();
            if choice == PressureSchur::ScaledFixedStress {
                let m = full(system(PressureSchur::FixedStress, &blocks, &parts).matrix()) - &t;
                let i = (0..n_p).find(|&i| m[(i, i)] != 0.0).unwrap();
                let alpha = (found[(i, i)] - t[(i, i)]) / m[(i, i)];
                assert!((found - &t - m * faer::Scale(alpha)).norm_max() < 1e-9 * size);
                assert!((1.0..5.0).contains(&alpha), "{alpha}");
                continue;
            }
            let off = (found - &t - m).norm_max();
            assert!(off < 1e-9 * size, "{choice} of seed {seed}: {off:e}");
        }
    }
}

/// Pressures of blocks from elsewhere may act on any displacements.
#[test]
fn where_pressures_act_on_no_surface_half_order_is_fixed_stress() {
    let mut fallen = 0;
    for seed in 0..8 {
        let mut blocks = with_flow(trusses(3, 10.0, false), FLOW, seed);
        let parts = Parts::new(&blocks, vec![0.5; blocks.n_t()]);
        let random = &mut Random::new(seed);
        let flow = blocks.flow.as_mut().unwrap();
        let (n_u, n_p) = (flow.q1.rows(), flow.q1.cols());
        let [mut q1, mut q2] = [Triplets::new((n_u, n_p)), Triplets::new((n_p, n_u))];
        for i in 0..n_u {
            for j in 0..n_p {
                if random.chance(0.4) {
                    let q = random.between(0.01, 0.1);
                    q1.add_triplet(i, j, q);
                    q2.add_triplet(j, i, -q);
                }
            }
        }
        (flow.q1, flow.q2) = (q1.to_csr(), q2.to_csr());
        let [found, fixed] = [PressureSchur::HalfOrder, PressureSchur::FixedStress]
            .map(|choice| system(choice, &blocks, &parts));
        let is_fixed = found.matrix() == fixed.matrix();
        // unknowns behind the pressures are those of a surface
        assert_eq!(is_fixed, found.auxiliary() == 0, "seed {seed}");
        fallen += usize::from(is_fixed);
    }
    assert!(fallen > 0);
}

/// Without an open face S_p = T to the last bit, S_u is not asked for, and an application costs one of mechanics.
#[test]
fn nothing_is_computed_where_no_face_is_open() {
    let blocks = with_flow(trusses(3, 10.0, false), Flow { open: 0.0, ..FLOW }, 3);
    let flow = flow_of(&blocks);
    let unused = Identity { n: blocks.n_u() };
    for choice in PressureSchur::ALL {
        let near = |_| -> Result<NearSchur, SetupError> { panic!("S_u is asked for") };
        let system = choice.system(flow, near, &unused).unwrap();
        assert_eq!(system.matrix(), &flow.t);
    }
    let mechanics = SaddleBlocks {
        flow: None,
        ..blocks.clone()
    };
    let ut = Racp::default().prepare(&mechanics).unwrap();
    let m = Racp::default().prepare(&blocks).unwrap();
    let s_p = PressureFactors::default()
        .factor(&flow.t.clone().into())
        .unwrap();
    assert_eq!(m.flops(), ut.flops() + s_p.flops() + csr(&flow.q1).flops());
    let coupled = with_flow(trusses(3, 10.0, false), FLOW, 3);
    let twice = Racp::default().prepare(&coupled).unwrap();
    // eliminated rows cost less than augmented ones
    assert!(2 * twice.flops() > 3 * ut.flops());
}

/// Solves for a known solution and returns the iterations.
fn solves(method: &SaddleMethod, blocks: &SaddleBlocks) -> usize {
    let operator = SaddleOperator::new(blocks);
    let m = method.prepare(blocks).unwrap();
    check_preconditioner(method.name(), &m, None, 0.0).unwrap();
    let expected: Vec<f64> = probe(blocks.size(), 5);
    let mut rhs = vec![0.0; blocks.size()];
    operator.apply(&expected, &mut rhs, &mut []);
    let krylov = KrylovChoice::default();
    let (x, report) = solve(krylov.method(), &operator, &m, &rhs, until(1e-11, 300));
    let report = report.unwrap();
    assert_eq!(report.outcome, Outcome::Converged, "{method}");
    for (x, expected) in x.iter().zip(&expected) {
        assert!((x - expected).abs() < 1e-5, "{method}: {x} {expected}");
    }
    report.iterations
}

#[test]
fn every_choice_and_form_solves_with_stick_and_open_faces() {
    for (seed, derivative) in [(1, 0.0), (2, 0.5), (3, 0.0)] {
        for open in [0.0, 0.4, 1.0] {
            let flow = Flow {
                open,
                derivative,
                ..FLOW
            };
            let blocks = with_flow(trusses(3, 10.0, false), flow, seed);
            let is_open = open > 0.0 && flow_of(&blocks).is_coupled();
            assert_eq!(Elimination::new(&blocks).is_some(), is_open);
            for schur in PressureSchur::ALL {
                for form in Form::ALL {
                    let racp = Racp {
                        flow: ThreeFields { schur, form },
                        ..Racp::default()
                    };
                    let iterations = solves(&SaddleMethod::Racp(racp), &blocks);
                    assert!(iterations <= 60, "{schur}, {form:?}: {iterations}");
                }
            }
            assert_eq!(solves(&"direct".parse().unwrap(), &blocks), 1);
        }
    }
}

#[test]
fn an_indefinite_t_is_factorized_and_a_singular_one_is_named() {
    let mut blocks = with_flow(trusses(3, 10.0, false), FLOW, 5);
    let flow = blocks.flow.as_mut().unwrap();
    let mut shift = Triplets::new((9, 9));
    (0..9).for_each(|i| shift.add_triplet(i, i, -0.37));
    flow.t = &flow.t + &shift.to_csr();
    solves(&SaddleMethod::default(), &blocks);

    let closed = Flow {
        open: 0.0,
        storage: 0.0,
        ..FLOW
    };
    let blocks = with_flow(trusses(3, 10.0, false), closed, 5);
    let error = SaddleMethod::default().ready(&blocks).err().unwrap();
    let said = error.to_string();
    assert!(
        said.contains("S_p") && said.contains("no prescribed pressure") && said.contains("storage"),
        "{said}"
    );
    // an open face determines them
    let open = Flow {
        open: 0.5,
        ..closed
    };
    solves(
        &SaddleMethod::default(),
        &with_flow(trusses(3, 10.0, false), open, 5),
    );
}

#[test]
fn an_ordering_outlives_a_change_of_values_and_not_of_pattern() {
    let blocks = with_flow(trusses(3, 10.0, false), FLOW, 5);
    let flow = flow_of(&blocks);
    let mut factors = PressureFactors::new(DirectChoice::default());
    for factor in [1.0, 2.0, 7.0] {
        let t = flow.t.map(|v| factor * v);
        let m = factors.factor(&t.clone().into()).unwrap();
        check_preconditioner("S_p", &m, Some(&csr(&t)), 1e-8).unwrap();
    }
    assert_eq!(factors.analyses(), 1);
    let other = SparseMatrix::eye(9);
    factors.factor(&other.into()).unwrap();
    assert_eq!(factors.analyses(), 2);
}

#[test]
fn blocks_of_flow_that_do_not_fit_are_named() {
    let good = with_flow(trusses(3, 10.0, false), FLOW, 5);
    let (n_u, wrong) = (good.n_u(), Triplets::new((9, 8)).to_csr());
    let with = |change: &dyn Fn(&mut FlowBlocks)| {
        let mut blocks = good.clone();
        change(blocks.flow.as_mut().unwrap());
        SaddleMethod::default().ready(&blocks).err().unwrap()
    };
    for (name, error) in [
        ("T", with(&|f| f.t = wrong.clone())),
        ("Q1", with(&|f| f.q1 = Triplets::new((n_u, 8)).to_csr())),
        ("Q2", with(&|f| f.q2 = Triplets::new((9, n_u + 1)).to_csr())),
    ] {
        assert!(
            error.to_string().starts_with(&format!("block {name} is")),
            "{error}"
        );
    }
    let error = with(&|f| f.q2 = f.q2.map(|v| v / 0.0));
    assert!(matches!(error, SetupError::NotFinite { block: "Q2", .. }));
}
