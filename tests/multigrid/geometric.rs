//! Claim: geometric multigrid is a symmetric positive definite preconditioner of S_u with λ(M⁻¹S_u) in (0, 1], the same for
//! any number of threads; RACP around it needs few iterations wherever fractures run, and no more on finer meshes.

use fracas::contact::JumpStabilization;
use fracas::multigrid::{Geometric, GeometricError, GeometricInverse, Lost};
use fracas::scene::{Body, named};
use fracas_operators::laws::{check_preconditioner, probe};
use fracas_operators::vector::dot;
use fracas_operators::{LinearOperator, Preconditioner, sparse::Csr};
use fracas_solvers::Silent;
use fracas_solvers::direct::DirectChoice;
use fracas_solvers::krylov::{Criteria, KrylovChoice, Outcome, System};
use fracas_solvers::multigrid::{Cycle, Precision};
use fracas_solvers::saddle::{
    AugmentationChoice, AugmentationMatrix, RELAXATION, RacpInverse, SaddleBlocks, SaddleOperator,
    schur,
};

struct Sample {
    body: Body,
    blocks: SaddleBlocks,
    /// C of the blocks, and of B in m².
    c: [AugmentationMatrix; 2],
}

fn sample(scene: &str, overrides: &[&str], augmentation: AugmentationChoice) -> Sample {
    let scene = named(scene).unwrap().small_scene().unwrap();
    of_body(
        scene.with_overrides(overrides).unwrap().build().unwrap(),
        augmentation,
    )
}

/// At the size of the gallery, not small.
fn full_sample(scene: &str, overrides: &[String], augmentation: AugmentationChoice) -> Sample {
    let scene = named(scene).unwrap().scene().unwrap();
    of_body(
        scene.with_overrides(overrides).unwrap().build().unwrap(),
        augmentation,
    )
}

/// With so many cells per axis, and other overrides.
fn with_cells(
    scene: &str,
    cells: [usize; 3],
    mut overrides: Vec<String>,
    augmentation: AugmentationChoice,
) -> Sample {
    let axes = ["x", "y", "z"].into_iter().zip(cells);
    overrides.extend(axes.map(|(axis, n)| format!("mesh.{axis}.cells={n}")));
    let overrides: Vec<&str> = overrides.iter().map(String::as_str).collect();
    sample(scene, &overrides, augmentation)
}

fn of_body(body: Body, augmentation: AugmentationChoice) -> Sample {
    let stabilization = Some(JumpStabilization::default());
    let blocks = body.saddle_blocks(stabilization).unwrap();
    let unit = blocks.traction_unit();
    let direct = DirectChoice::default().solver().unwrap();
    let c = |blocks: &SaddleBlocks| augmentation.compute(blocks, &*direct).unwrap().matrix;
    let in_si = c(&blocks);
    let blocks = blocks.into_traction_unit(unit);
    Sample {
        c: [c(&blocks), in_si],
        body,
        blocks,
    }
}

impl Sample {
    fn build(&self, settings: Geometric) -> GeometricInverse {
        let system = self.body.stick_system(Some(JumpStabilization::default()));
        GeometricInverse::new(&settings, &system, &self.c[1]).unwrap()
    }

    /// Iterations of GMRES around RACP as published, without relaxation.
    fn iterations(&self, settings: Geometric) -> usize {
        self.iterations_around(self.racp(settings))
    }

    /// Iterations of GMRES around RACP with H relaxed on either side.
    fn iterations_relaxed(&self, settings: Geometric) -> usize {
        let h = Csr::new(self.blocks.h.clone().unwrap());
        self.iterations_around(self.racp(settings).relaxed(Box::new(h), RELAXATION))
    }

    fn racp(&self, settings: Geometric) -> RacpInverse<'static> {
        let inverse = self.build(settings);
        RacpInverse::new(self.blocks.b1.clone(), self.c[0].clone(), inverse)
    }

    fn iterations_around(&self, m: RacpInverse<'_>) -> usize {
        let operator = SaddleOperator::new(&self.blocks);
        let b = self.blocks.rhs();
        let system = System {
            operator: &operator,
            preconditioner: &m,
            rhs: &b,
        };
        let criteria = Criteria {
            relative_tolerance: 1e-8,
            max_iterations: 200,
        };
        let choice = KrylovChoice::default().flexible_for(&m);
        let method = choice.method();
        let mut x = vec![0.0; b.len()];
        let report = method
            .solve(&system, &criteria, &mut x, &mut Silent)
            .unwrap();
        assert_eq!(report.outcome, Outcome::Converged);
        report.iterations
    }
}

fn in_precision(precision: Precision) -> Geometric {
    Geometric {
        precision,
        ..Geometric::default()
    }
}

#[test]
fn the_unit_of_the_moduli_means_nothing_to_f32() {
    for scene in ["crossing", "layered_crossing"] {
        for exponent in [-30, -17, 0, 12, 30] {
            let scene = named(scene).unwrap().small_scene().unwrap();
            let mut body = scene.build().unwrap();
            for material in &mut body.materials {
                material.young *= 10_f64.powi(exponent) / 1e9;
            }
            let sample = of_body(body, AugmentationChoice::LocalH);
            let single = in_precision(Precision::F32);
            assert_eq!(sample.build(single).lost(), None);
            assert!(sample.build(single).properties().single);
            let n = sample.iterations(single);
            let double = sample.iterations(in_precision(Precision::F64));
            assert!(n <= double + 2, "1e{exponent}: {n} against {double}");
        }
    }
}

#[test]
fn f32_costs_no_iterations_or_gives_way_to_f64_and_says_so() {
    let cells = ["x", "y", "z"].map(|axis| format!("mesh.{axis}.cells=16"));
    for (soft, gives_way) in [
        ("4", false),
        ("0.4", false),
        ("0.004", true),
        ("0.0004", true),
    ] {
        let mut overrides = cells.to_vec();
        overrides.push(format!("material.soft.young='{soft} GPa'"));
        let overrides: Vec<&str> = overrides.iter().map(String::as_str).collect();
        let sample = sample("layered_crossing", &overrides, AugmentationChoice::LocalH);
        let single = in_precision(Precision::F32);
        let built = sample.build(single);
        let lost = built.lost();
        assert_eq!(
            matches!(lost, Some(Lost::Digits { .. })),
            gives_way,
            "{soft}: {lost:?}"
        );
        assert_eq!(built.properties().single, !gives_way);
        let n = sample.iterations(single);
        let double = sample.iterations(in_precision(Precision::F64));
        assert!(n <= double + 2, "{soft}: {n} against {double}");
    }
}

#[test]
fn what_overflows_in_f32_is_built_in_f64() {
    // a cover on rock 10⁴⁵ times as stiff: regular, because nothing rests on it
    let cover = ["material.soft.layers=[['3 m', '4 m']]"];
    let scene = named("layered_crossing").unwrap().small_scene().unwrap();
    let mut body = scene.with_overrides(&cover).unwrap().build().unwrap();
    let softest = body
        .materials
        .iter_mut()
        .min_by(|a, b| a.young.total_cmp(&b.young));
    softest.unwrap().young = 1e-35;
    let sample = of_body(body, AugmentationChoice::LocalH);
    let m = sample.build(in_precision(Precision::F32));
    assert_eq!(m.lost(), Some(Lost::Range { level: 0 }));
    assert!(!m.properties().single);
    let r = probe::<f64>(m.size(), 1);
    let mut z = vec![f64::NAN; r.len()];
    m.solve(&r, &mut z, &mut vec![f64::NAN; m.work_len()]);
    assert!(z.iter().all(|z| z.is_finite()));
}

/// Small enough a bottom that every scene has several levels.
fn exact() -> Geometric {
    Geometric {
        precision: Precision::F64,
        coarsest: 60,
        direct: 60,
        ..Geometric::default()
    }
}

#[test]
fn it_is_a_symmetric_positive_map_and_no_eigenvalue_exceeds_one() {
    for scene in ["crossing", "floating", "inclined", "layered"] {
        for augmentation in [AugmentationChoice::LocalH, AugmentationChoice::FaceBlock] {
            let sample = sample(scene, &[], augmentation);
            let s_u = schur::primal_schur(&sample.blocks.a, &sample.blocks.b1, &sample.c[0]);
            let operator = Csr::new(s_u.unwrap());
            for settings in [
                exact(),
                Geometric {
                    cycle: Cycle::W,
                    degree: 2,
                    ..exact()
                },
            ] {
                let m = sample.build(settings);
                assert!(m.summary().levels.len() >= 3, "{scene}");
                check_preconditioner(scene, &m, None, 0.0).unwrap();
                let n = m.size();
                let mut work = vec![f64::NAN; m.work_len()];
                let mut solve = |r: &[f64]| {
                    let mut z = vec![f64::NAN; n];
                    m.solve(r, &mut z, &mut work);
                    z
                };
                for seed in 0..5 {
                    let (x, y) = (probe::<f64>(n, seed), probe::<f64>(n, seed + 50));
                    let (mx, my) = (solve(&x), solve(&y));
                    let (left, right) = (dot(&x, &my), dot(&mx, &y));
                    let size = (dot(&x, &mx) * dot(&y, &my)).sqrt();
                    assert!(dot(&x, &mx) > 0.0, "{scene}: not positive");
                    assert!((left - right).abs() < 1e-9 * size, "{scene}: not symmetric");
                    // xᵀS M⁻¹ S x ≤ xᵀS x is λ(M⁻¹S) ≤ 1
                    let mut s_x = vec![0.0; n];
                    operator.apply(&x, &mut s_x, &mut []);
                    let quotient = dot(&s_x, &solve(&s_x)) / dot(&x, &s_x);
                    assert!(
                        quotient < 1.01 * settings.over_correction,
                        "{scene}: {quotient}"
                    );
                }
            }
        }
    }
}

#[test]
fn one_and_two_threads_give_the_same_bits_and_f32_the_digits_of_f32() {
    let cells = ["mesh.x.cells=16", "mesh.y.cells=12", "mesh.z.cells=16"];
    for scene in ["crossing", "inclined"] {
        let sample = sample(scene, &cells, AugmentationChoice::LocalH);
        let build = |threads: usize, settings: Geometric| -> Vec<f64> {
            let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
            pool.build().unwrap().install(|| {
                let m = sample.build(settings);
                let r = probe::<f64>(m.size(), 3);
                let mut z = vec![0.0; m.size()];
                m.solve(&r, &mut z, &mut vec![0.0; m.work_len()]);
                z
            })
        };
        let single = Geometric {
            precision: Precision::F32,
            ..exact()
        };
        let steps = Geometric {
            cycle: Cycle::K,
            ..single
        };
        for settings in [single, exact(), steps] {
            let [one, two] = [1, 2].map(|threads| build(threads, settings));
            assert!(
                one.iter()
                    .zip(&two)
                    .all(|(a, b)| a.to_bits() == b.to_bits())
            );
        }
        let (single, double) = (build(1, single), build(1, exact()));
        let square = |(a, b): (&f64, &f64)| (a - b).powi(2);
        let error: f64 = single.iter().zip(&double).map(square).sum();
        assert!(
            error.sqrt() < 1e-4 * dot(&double, &double).sqrt(),
            "{scene}"
        );
    }
}

#[test]
fn racp_converges_wherever_fractures_run_and_whatever_the_rock_is() {
    // a fifth above what was found; in thin soft layers (contrast 1000) C is not good even with exact S_u
    for (scene, most) in [
        ("crossing", 17),
        ("inclined", 21),
        ("tee", 18),
        ("floating", 14),
        ("analogue_a", 16),
        ("analogue_b", 18),
        ("analogue_c", 20),
        ("incompressible", 14),
        ("stretched", 17),
        ("layered", 30),
    ] {
        let sample = sample(scene, &[], AugmentationChoice::LocalH);
        let single = sample.iterations(Geometric::default());
        assert!(single <= most, "{scene}: {single} iterations");
        let double = sample.iterations(Geometric {
            precision: Precision::F64,
            ..Geometric::default()
        });
        // contrast 1000 leaves f32 too few digits for soft layers between stiff ones: found 31 against 19
        let more = if scene == "layered" { 15 } else { 2 };
        assert!(
            single <= double + more,
            "{scene}: f32 {single}, f64 {double} iterations"
        );
    }
    // fractures off the coarse planes, tips inside coarse cells, odd numbers of cells
    let off = [
        "mesh.x.to='5 m'",
        "mesh.x.cells=9",
        "mesh.y.cells=5",
        "fracture.upright.at='1 m'",
        "fracture.flat.at='-1 m'",
    ];
    let found = sample("crossing", &off, AugmentationChoice::LocalH).iterations(exact());
    assert!(found <= 26, "{found} iterations");
}

#[test]
fn iterations_stay_when_the_mesh_is_refined() {
    for scene in ["crossing", "inclined"] {
        let counts = [8, 16, 24].map(|n| {
            let cells = [n, n / 2, n];
            let sample = with_cells(scene, cells, Vec::new(), AugmentationChoice::LocalH);
            sample.iterations(exact())
        });
        let most = counts.iter().max().unwrap();
        assert!(most - counts[0] <= 5, "{scene}: {counts:?}");
    }
}

/// Between the levels of a K-cycle stands a nonlinear iteration: GMRES becomes FGMRES, and needs as few iterations. On 24³ cells of
/// contrast 4·10³ and ν = 0.49 coarse cycles are poor, and steps beyond 2 would take hundreds.
#[test]
fn a_k_cycle_takes_no_more_iterations_than_a_v_cycle() {
    let soft = ["soft.young='10 MPa'", "stiff.poisson=0.49"].map(|s| format!("material.{s}"));
    let local_h = AugmentationChoice::LocalH;
    for (scene, sample) in [
        ("crossing", sample("crossing", &[], local_h)),
        (
            "inclined",
            sample("inclined", &[], AugmentationChoice::FaceBlock),
        ),
        ("floating", sample("floating", &[], local_h)),
        ("layered", sample("layered", &[], local_h)),
        (
            "unlike",
            with_cells("layered_crossing", [16; 3], soft.into(), local_h),
        ),
    ] {
        let of = |cycle| Geometric { cycle, ..exact() };
        let built = sample.build(of(Cycle::K));
        assert!(!built.properties().linear && sample.build(of(Cycle::W)).properties().linear);
        // not linear, but the same map every time, whatever its scratch contains
        let r = probe::<f64>(built.size(), 4);
        let solved = |dirt: f64| {
            let (mut z, mut work) = (vec![dirt; r.len()], vec![dirt; built.work_len()]);
            built.solve(&r, &mut z, &mut work);
            z
        };
        assert_eq!(solved(f64::NAN), solved(3.0), "{scene}");
        let [v, k] = [Cycle::V, Cycle::K].map(|cycle| sample.iterations(of(cycle)));
        let single = sample.iterations(Geometric {
            precision: Precision::F32,
            ..of(Cycle::K)
        });
        println!("{scene}: V {v}, K {k}, in f32 {single}");
        assert!(k <= v, "{scene}: K {k}, V {v}");
        assert!(single <= k + 2 + k / 20, "{scene}: f32 {single}, f64 {k}");
    }
}

#[test]
fn a_name_says_cycle_and_precision() {
    for settings in Geometric::all() {
        assert_eq!(Geometric::of_name(&settings.to_string()), Some(settings));
    }
    let k = Geometric {
        cycle: Cycle::K,
        precision: Precision::F64,
        ..Geometric::default()
    };
    assert_eq!(Geometric::of_name("geometric:k:f64"), Some(k));
    assert_eq!(Geometric::of_name("geometric"), Some(Geometric::default()));
    for wrong in ["geometric:", "geometric:f64:k", "geometric:x", "k", ""] {
        assert_eq!(Geometric::of_name(wrong), None, "{wrong}");
    }
}

/// Flat and long cells: their finest axes are halved first.
#[test]
fn cells_of_one_to_two_take_the_iterations_of_cubes() {
    let iterations = |cells: [usize; 3]| {
        let c = AugmentationChoice::FittedH;
        let sample = with_cells("layered_crossing", cells, Vec::new(), c);
        sample.iterations_relaxed(Geometric::default())
    };
    let cubes = iterations([16; 3]);
    for cells in [[32, 16, 16], [16, 32, 16], [16, 16, 32], [32, 32, 16]] {
        let found = iterations(cells);
        println!("{cells:?}: {found}, cubes {cubes}");
        assert!(found <= cubes + 2, "{cells:?}: {found}, cubes {cubes}");
    }
}

/// Cells of 1:50: C takes as much of H as it needs, the rest is relaxed.
#[test]
fn cells_of_one_to_fifty_take_hardly_more_iterations_than_cubes() {
    // flat, and long towards the fracture
    let long = [
        "mesh.y.from='-6 m'",
        "mesh.y.to='6 m'",
        "fracture.fault.y=['-4 m','4 m']",
    ];
    for overrides in [&[][..], &long] {
        let overrides: Vec<String> = overrides.iter().map(|o| (*o).to_owned()).collect();
        let iterations = |c| {
            let sample = with_cells("stretched", [24; 3], overrides.clone(), c);
            sample.iterations_relaxed(Geometric::default())
        };
        let [half, fitted] =
            [AugmentationChoice::HalfH, AugmentationChoice::FittedH].map(iterations);
        println!("{overrides:?}: {fitted}, with half of H {half}");
        assert!(
            fitted <= 20 && fitted < half,
            "{overrides:?}: {fitted}, {half}"
        );
    }
}

/// A body that reaches 20 times as far as the fractures, cells that grow by 1.4 away from them: small neighbours become one first.
#[test]
fn graded_cells_take_few_iterations_more_than_cubes() {
    let across = "{from='-40 m',to='40 m',near=['-2 m','0 m','2 m'],size='0.1 m',growth=1.4}";
    let along = "{from='0 m',to='4 m',near='0 m',size='0.1 m',growth=1.4}";
    let axes = [("x", across), ("y", along), ("z", across)];
    let axes = axes.map(|(axis, lines)| format!("mesh.{axis}={lines}"));
    let graded = full_sample("crossing", &axes, AugmentationChoice::FittedH);
    let cubes = sample("crossing", &[], AugmentationChoice::FittedH);
    let [graded, cubes] =
        [graded, cubes].map(|sample| sample.iterations_relaxed(Geometric::default()));
    println!("graded {graded}, cubes {cubes}");
    assert!(graded <= 2 * cubes, "graded {graded}, cubes {cubes}");
}

/// Columns of one cell on an intact base: the grid on which the base joins them all is no coarse grid of theirs.
#[test]
fn columns_are_not_lost_on_the_coarsest_grid() {
    let wide = ["x", "y"].into_iter().flat_map(|axis| {
        [
            format!("mesh.{axis}.to='24 m'"),
            format!("mesh.{axis}.cells=24"),
        ]
    });
    let wide: Vec<String> = wide.collect();
    let sample = full_sample("analogue_c", &wide, AugmentationChoice::FittedH);
    let levels = sample.build(Geometric::default()).summary().levels;
    let coarsest = levels.last().unwrap().n;
    assert!(coarsest > 24 * 24, "{coarsest} unknowns for 576 columns");
    let found = sample.iterations_relaxed(Geometric::default());
    println!("{found} iterations, {coarsest} unknowns at the bottom");
    assert!(found <= 60, "{found} iterations");
}

/// λ → ∞ makes a diagonal block blind to waves that keep the volume; the polynomial reaches them all the same.
#[test]
fn rock_that_hardly_changes_its_volume_takes_few_iterations_more() {
    let iterations = |stiff: f64, soft: f64, cells: usize| {
        let rocks = vec![
            format!("material.stiff.poisson={stiff}"),
            format!("material.soft.poisson={soft}"),
        ];
        let c = AugmentationChoice::LocalH;
        let sample = with_cells("layered_crossing", [cells; 3], rocks, c);
        sample.iterations(Geometric::default())
    };
    let usual = iterations(0.25, 0.3, 16);
    for [stiff, soft] in [[0.49, 0.3], [0.25, 0.49], [0.49; 2], [0.495; 2]] {
        let found = [16, 24].map(|cells| iterations(stiff, soft, cells));
        println!("{stiff}, {soft}: {found:?}, usually {usual}");
        assert!(
            found[0] <= usual + usual / 2,
            "{stiff}, {soft}: {found:?}, usually {usual}"
        );
        assert!(found[1] <= found[0] + 3, "{stiff}, {soft}: {found:?}");
    }
}

#[test]
fn what_it_cannot_take_is_named() {
    let given = sample("crossing", &[], AugmentationChoice::LocalH);
    let system = given.body.stick_system(None);
    let settings = Geometric::default();
    let short = AugmentationMatrix::from_diagonal(vec![1.0; 3]).unwrap();
    let n_t = given.blocks.n_t();
    let error =
        |c: &AugmentationMatrix| GeometricInverse::new(&settings, &system, c).err().unwrap();
    let expected = GeometricError::SizeOfC {
        expected: n_t,
        found: 3,
    };
    assert_eq!(error(&short), expected);
    let dense = faer::Mat::from_fn(n_t, n_t, |i, j| if i == j { 2.0 } else { 0.0 });
    let dense = AugmentationMatrix::from_dense(dense).unwrap();
    assert_eq!(error(&dense), GeometricError::DenseC);
    // C⁻¹ beyond the largest f32: f64 holds it, but not the rock beside it; what the coarsest level leaves out of S_u serves all the same
    let tiny = AugmentationMatrix::from_diagonal(vec![1e-60; n_t]).unwrap();
    let stiff = GeometricInverse::new(&settings, &system, &tiny).unwrap();
    assert!(stiff.lost().is_some(), "f32 cannot hold 1e60");
    let (r, mut z) = (probe::<f64>(stiff.size(), 3), vec![0.0; stiff.size()]);
    stiff.solve(&r, &mut z, &mut vec![f64::NAN; stiff.work_len()]);
    let energy = dot(&r, &z);
    assert!(energy > 0.0 && energy.is_finite(), "rᵀM⁻¹r = {energy}");
    // beyond the largest f64
    let least = AugmentationMatrix::from_diagonal(vec![1e-320; n_t]).unwrap();
    let overflow = GeometricError::Overflow {
        level: 0,
        precision: "f64",
    };
    assert_eq!(error(&least), overflow);
    let mut body = given.body.clone();
    body.mesh.grid = None;
    let system = body.stick_system(None);
    let found = GeometricInverse::new(&settings, &system, &given.c[1]).err();
    assert_eq!(found, Some(GeometricError::NoGrid));
}

#[test]
fn a_number_that_is_none_goes_through() {
    let m = sample("crossing", &[], AugmentationChoice::LocalH).build(Geometric::default());
    let mut r = vec![1.0; m.size()];
    r[5] = f64::NAN;
    let mut z = vec![0.0; m.size()];
    m.solve(&r, &mut z, &mut vec![0.0; m.work_len()]);
    assert!(z.iter().any(|z| z.is_nan()));
    m.solve(
        &vec![0.0; m.size()],
        &mut z,
        &mut vec![f64::NAN; m.work_len()],
    );
    assert!(z.iter().all(|z| *z == 0.0));
}

/// Every block keeps the corners of its coarse cell: grids that go on below the blocks would end singular, and in f32 before that.
#[test]
fn blocks_smaller_than_a_coarse_cell_are_no_obstacle() {
    let cut = |axes: &str, every: usize| {
        let plane =
            |a: char| format!("{{name='c{a}',plane='{a}',every={every},friction_angle='30 deg'}}");
        let planes: Vec<String> = axes.chars().map(plane).collect();
        format!("fracture=[{}]", planes.join(","))
    };
    // cubes of 2³ and of 3³ cells, columns, a bar of slices
    for (cells, axes, every) in [
        ([8, 8, 8], "xyz", 2),
        ([18, 12, 12], "xyz", 3),
        ([16, 8, 16], "xz", 2),
        ([120, 12, 4], "x", 2),
    ] {
        let mut sets = vec![cut(axes, every)];
        for (axis, n) in ["x", "y", "z"].into_iter().zip(cells) {
            sets.push(format!("mesh.{axis}.to={n} m"));
            sets.push(format!("mesh.{axis}.cells={n}"));
        }
        let sample = full_sample("floating", &sets, AugmentationChoice::LocalH);
        let iterations = [Precision::F32, Precision::F64].map(|precision| {
            sample.iterations(Geometric {
                precision,
                ..Geometric::default()
            })
        });
        println!("{cells:?} cut in {axes} every {every}: {iterations:?}");
        assert!(iterations[1] <= 20, "{cells:?} {axes}: {iterations:?}");
        assert!(
            iterations[0] <= iterations[1] + 2,
            "{cells:?} {axes}: {iterations:?}"
        );
    }
}
