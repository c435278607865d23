//! Claim: methods are plain data, prepare what they say, and tell what they cost.

use crate::elastic_sample::cube;
use crate::iterations::{solve, until};
use crate::oracle::unsymmetric;
use crate::samples::{random, sparse, trusses};
use fracas_operators::laws::{check_parts, check_preconditioner, probe};
use fracas_operators::sparse::Triplets;
use fracas_operators::{Counted, LinearOperator, Preconditioner, Properties};
use fracas_solvers::amg::Amg;
use fracas_solvers::krylov::{KrylovChoice, Outcome};
use fracas_solvers::multigrid::{Cycle, Precision};
use fracas_solvers::saddle::{
    AugmentationChoice, AugmentationMatrix, AugmentedLagrangianInverse, BlockDiagonalInverse,
    BlockTriangularInverse, Cost, EliminatedInverse, Elimination, FlowBlocks, InnerChoice,
    McpInverse, RacpInverse, SaddleBlocks, SaddleMethod, SaddleOperator, SimpleInverse, T, U,
};
use fracas_solvers::{Prepare, SetupError};
use serde::{Deserialize, Serialize};

#[derive(Debug, PartialEq, Serialize, Deserialize)]
struct Study {
    methods: Vec<SaddleMethod>,
}

#[test]
fn the_settings_tree_reads_from_toml_by_name_or_in_full() {
    let study: Study = toml::from_str(
        r#"
        [[methods]]
        racp = { augmentation = "face_block", inner = "fsai" }
        [[methods]]
        mcp = { gamma_factor = 0.0, inner = { ssor = { omega = 1.2 } } }
        [[methods]]
        direct = { backend = "faer" }
        [[methods]]
        block_diagonal = { augmentation = "local_h", inner = "amg" }
        [[methods]]
        simple = { correction = "diagonal" }
        "#,
    )
    .unwrap();
    assert_eq!(
        study
            .methods
            .iter()
            .map(|m| m.to_string())
            .collect::<Vec<_>>(),
        ["racp", "mcp:0", "direct:faer", "block_diagonal", "simple"]
    );
    assert_eq!(study.methods[0].inner().unwrap().name(), "fsai");
    assert_eq!(
        study.methods[0].augmentation(),
        Some(AugmentationChoice::FaceBlock)
    );
    let names: Study = toml::from_str(r#"methods = ["racp", "mcp:0", "direct:faer"]"#).unwrap();
    assert_eq!(names.methods[2], study.methods[2]);
    let wrong = [
        (
            r#"methods = ["racpp"]"#,
            "unknown method \"racpp\": expected racp",
        ),
        (r#"methods = [{ racpp = {} }]"#, "racpp"),
        (
            r#"methods = [{ mcp = { gama_factor = 1.0 } }]"#,
            "gama_factor",
        ),
        (r#"methods = ["racp:3"]"#, "racp:3"),
        (r#"methods = ["mcp:-1"]"#, "mcp:-1"),
        (r#"methods = ["direct:pardiso"]"#, "direct:pardiso"),
    ];
    for (text, expected) in wrong {
        let error = toml::from_str::<Study>(text).unwrap_err().to_string();
        assert!(error.contains(expected), "{text}: {error}");
    }
}

#[test]
fn what_is_written_reads_back() {
    let methods = SaddleMethod::all().to_vec();
    for method in &methods {
        assert_eq!(method.to_string().parse::<SaddleMethod>().unwrap(), *method);
    }
    let study = Study { methods };
    let text = toml::to_string(&study).unwrap();
    assert_eq!(toml::from_str::<Study>(&text).unwrap(), study);
    let schema = serde_json::to_string(&schemars::schema_for!(SaddleMethod)).unwrap();
    assert!(
        SaddleMethod::all()
            .iter()
            .all(|m| schema.contains(m.name()))
    );
}

#[test]
fn parts_that_a_method_lacks_are_refused_in_one_sentence() {
    let direct: SaddleMethod = "direct".parse().unwrap();
    let error = direct
        .with_parts(None, Some(InnerChoice::default()))
        .unwrap_err();
    assert!(
        error
            .to_string()
            .starts_with("method direct has no inner solver; methods with one: racp, mcp")
    );
    let mcp: SaddleMethod = "mcp".parse().unwrap();
    let error = mcp
        .with_parts(Some(AugmentationChoice::Local), None)
        .unwrap_err();
    assert!(
        error
            .to_string()
            .starts_with("method mcp has no augmentation C; methods with one: racp")
    );
    let jacobi: InnerChoice = "jacobi".parse().unwrap();
    assert_eq!(
        mcp.with_parts(None, Some(jacobi)).unwrap().inner(),
        Some(jacobi)
    );
}

/// Solves for a known solution with GMRES and returns the iterations.
fn solves(method: &SaddleMethod, blocks: &SaddleBlocks) -> usize {
    let operator = SaddleOperator::new(blocks);
    let m = method.prepare(blocks).unwrap();
    check_preconditioner(method.name(), &m, None, 0.0).unwrap();
    let n = blocks.size();
    let expected: Vec<f64> = probe(n, 5);
    let mut rhs = vec![0.0; n];
    operator.apply(&expected, &mut rhs, &mut []);
    let krylov = KrylovChoice::default();
    let (x, report) = solve(krylov.method(), &operator, &m, &rhs, until(1e-10, 200));
    let report = report.unwrap();
    assert_eq!(report.outcome, Outcome::Converged, "{method}");
    for (x, expected) in x.iter().zip(&expected) {
        assert!((x - expected).abs() < 1e-6, "{method}: {x} {expected}");
    }
    report.iterations
}

#[test]
fn every_method_obeys_the_laws_and_solves() {
    for blocks in [
        random(24, 8, 0.0, 1),
        random(24, 8, 0.5, 2),
        trusses(3, 10.0, false),
        unsymmetric(random(24, 8, 0.3, 3)),
    ] {
        for method in SaddleMethod::all() {
            let iterations = solves(&method, &blocks);
            assert!(iterations <= 80, "{method}: {iterations}");
        }
        assert_eq!(solves(&"direct:faer".parse().unwrap(), &blocks), 1);
    }
}

#[test]
fn flow_needs_racp_or_the_direct_solver() {
    let mut blocks = random(6, 2, 0.0, 7);
    let diagonal = |rows, cols| {
        let mut t = Triplets::new((rows, cols));
        t.add_triplet(0, 0, 1.0);
        t.to_csr()
    };
    blocks.flow = Some(FlowBlocks {
        q1: diagonal(6, 1),
        q2: diagonal(1, 6),
        t: diagonal(1, 1),
        rhs_p: vec![1.0],
    });
    for method in SaddleMethod::all() {
        let ready = method.ready(&blocks);
        assert_eq!(ready.is_ok(), ["racp", "direct"].contains(&method.name()));
        if let Err(error) = ready {
            assert!(
                error
                    .to_string()
                    .contains("take method = \"racp\" or \"direct\""),
                "{error}"
            );
        }
    }
}

#[test]
fn a_wrong_block_is_named_before_any_method_begins() {
    let mut blocks = random(6, 2, 0.0, 7);
    blocks.b2 = Some(Triplets::new((2, 5)).to_csr());
    for method in SaddleMethod::all() {
        let error = method.ready(&blocks).err().unwrap();
        assert!(matches!(error, SetupError::Shape { block: "B2", .. }));
    }
}

#[test]
fn the_cost_of_a_run_is_what_its_counters_say() {
    let blocks = trusses(3, 10.0, false);
    let rhs: Vec<f64> = probe(blocks.size(), 5);
    for name in ["gmres", "bicgstab"] {
        let krylov: KrylovChoice = name.parse().unwrap();
        let operator = Counted::new(SaddleOperator::new(&blocks));
        let m = Counted::new(SaddleMethod::default().prepare(&blocks).unwrap());
        let cost = Cost::new(&operator, &m);
        let (_, report) = solve(krylov.method(), &operator, &m, &rhs, until(1e-8, 200));
        let report = report.unwrap();
        assert!(report.iterations > 2);
        let flops = operator.applications() * cost.product_flops
            + m.applications() * cost.application_flops;
        // the convention leaves out the true residual at both ends and the correction of a restart
        let counted = flops as f64 / cost.product_flops as f64;
        let stated = cost.c_s(report.iterations, &krylov);
        let allowed = 2.0 * (1.0 + cost.c_app());
        assert!(
            counted >= stated && counted <= stated + allowed,
            "{name}: {counted} {stated}"
        );
    }
}

/// The same blocks with an open last row: `B2_l = 0`, `H_ll = 2`.
fn with_an_open_row(blocks: SaddleBlocks) -> SaddleBlocks {
    let (n_u, n_t) = (blocks.n_u(), blocks.n_t());
    SaddleBlocks {
        b2: Some(sparse(n_t, n_u, |k, i| match blocks.b1.get(i, k) {
            Some(b) if k + 1 < n_t => *b,
            _ => 0.0,
        })),
        h: Some(sparse(n_t, n_t, |i, j| {
            if i == j && i + 1 == n_t { 2.0 } else { 0.0 }
        })),
        ..blocks
    }
}

/// A body of 300 unknowns, of which a K-cycle that ends at 20 makes no linear map, and eight rows of tractions.
fn body(h: f64) -> SaddleBlocks {
    let (a, coordinates) = cube(4);
    let n = a.rows();
    SaddleBlocks {
        b1: sparse(n, 8, |i, k| if i == 36 * k { 1.0 } else { 0.0 }),
        rhs_u: vec![0.0; n],
        coordinates: Some(coordinates),
        a,
        ..random(3, 8, h, 2)
    }
}

#[test]
fn around_an_inner_solver_in_f32_or_no_linear_map_every_method_says_so() {
    let open = with_an_open_row(body(0.0));
    assert!(Elimination::new(&open).is_some());
    for blocks in [body(0.5), open] {
        for (precision, cycle, expected) in [
            (Precision::F32, Cycle::V, Properties::SINGLE),
            (Precision::F64, Cycle::V, Properties::LINEAR),
            (Precision::F64, Cycle::K, Properties::NONLINEAR),
            (
                Precision::F32,
                Cycle::K,
                Properties::SINGLE.and(Properties::NONLINEAR),
            ),
        ] {
            let amg = InnerChoice::Amg(Amg {
                precision,
                cycle,
                coarsest: 20,
                ..Amg::default()
            });
            for method in SaddleMethod::all() {
                let (method, expected) = match method.inner() {
                    // its approximation of the Schur complement is an FSAI
                    Some(_) if method.name() == "mcp" => (
                        method.with_parts(None, Some(amg)).unwrap(),
                        expected.and(Properties::LOCAL),
                    ),
                    Some(_) => (method.with_parts(None, Some(amg)).unwrap(), expected),
                    None => (method, Properties::LINEAR),
                };
                let expected = match method.name() {
                    "block_diagonal" | "block_triangular" | "augmented_lagrangian" => {
                        expected.and(Properties::BLIND)
                    }
                    _ => expected,
                };
                let m = method.prepare(&blocks).unwrap();
                assert_eq!(m.properties(), expected, "{method}");
                let flexible = KrylovChoice::default().flexible_for(m.as_ref());
                assert_eq!(
                    flexible.is_flexible(),
                    !expected.is_linear_map(),
                    "{method}"
                );
                check_preconditioner(method.name(), &m, None, 0.0).unwrap();
            }
        }
    }
}

#[test]
fn every_part_counts() {
    let blocks = random(5, 3, 0.0, 2);
    let (b, c) = (
        blocks.b1.clone(),
        AugmentationMatrix::from_diagonal(vec![1.0; 3]).unwrap(),
    );
    let both = [5, 3];
    check_parts("SIMPLE", both, |[p, s]| {
        SimpleInverse::new(b.clone(), blocks.b2_rows(), p, s)
    })
    .unwrap();
    check_parts("block triangular", both, |[p, s]| {
        BlockTriangularInverse::new(b.clone(), p, s)
    })
    .unwrap();
    check_parts("block diagonal", both, |[p, s]| {
        BlockDiagonalInverse::new(vec![(U, Box::new(p)), (T, Box::new(s))])
    })
    .unwrap();
    check_parts("MCP", both, |[p, s]| McpInverse::new(b.clone(), 1.0, p, s)).unwrap();
    check_parts("RACP", [5], |[s_u]| {
        RacpInverse::new(b.clone(), c.clone(), s_u)
    })
    .unwrap();
    check_parts("augmented Lagrangian", [5], |[s_u]| {
        AugmentedLagrangianInverse::new(b.clone(), None, c.clone(), s_u)
    })
    .unwrap();
    let open = with_an_open_row(blocks.clone());
    check_parts("elimination", [8], |[m]| {
        EliminatedInverse::new(Elimination::new(&open).unwrap(), m)
    })
    .unwrap();
    check_parts::<1, f64, _>("counted", [3], |[m]| Counted::new(m)).unwrap();
    check_parts::<1, f64, Box<dyn Preconditioner<f64>>>("boxed", [3], |[m]| Box::new(m)).unwrap();
}

/// A count that no lifetime ends is refused where it is read, whoever holds the inner solver.
#[test]
fn settings_of_an_inner_solver_out_of_their_range_are_refused() {
    let huge = i64::MAX;
    for inner in [
        format!("amg = {{ sweeps = {huge} }}"),
        format!("geometric = {{ degree = {huge} }}"),
        format!("fsai = {{ kind = {{ adaptive = {{ steps = {huge} }} }} }}"),
        format!("fsai = {{ kind = {{ static = {{ power = {huge} }} }} }}"),
    ] {
        for name in ["racp", "mcp", "simple"] {
            let text = format!(r#"method = {{ {name} = {{ inner = {{ {inner} }} }} }}"#);
            let read: Result<std::collections::BTreeMap<String, SaddleMethod>, _> =
                toml::from_str(&text);
            let refused = read.unwrap_err().to_string();
            assert!(
                refused.contains("expected a number from"),
                "{text}: {refused}"
            );
        }
    }
}
