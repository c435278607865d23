//! Sweeps, what they leave and products against the equations that define them, entry by entry.

use super::{Forward, Sweeps};
use crate::amg::finest::Sum;
use crate::amg::node_map::NodeMap;
use crate::elastic_sample::clamped_box;
use fracas_operators::laws::probe;
use fracas_operators::simd::Level;
use fracas_operators::{LinearOperator, Real};

/// The whole matrix in f64, row by row, with whether an entry is visited before its row (−1), with it (0) or after it (1).
struct Reference(Vec<Vec<(usize, f64, i8)>>);

impl Reference {
    /// `Σ a_ij x_j` over the parts that are asked for.
    fn times(&self, parts: &[i8], x: &[f64]) -> Vec<f64> {
        let row = |row: &Vec<(usize, f64, i8)>| {
            let asked = row.iter().filter(|entry| parts.contains(&entry.2));
            asked.map(|(j, a, _)| a * x[*j]).sum()
        };
        self.0.iter().map(row).collect()
    }
}

/// A long box of 18 chunks, each coupled to the next ones.
fn sample<R: Real>(level: Level) -> (Sweeps<R>, Reference) {
    let young = |cell: [usize; 3]| 1.0 + (cell[2] % 3) as f64;
    let (a, at) = clamped_box([30, 4, 60], [1.0, 0.8, 1.2], young);
    let map = NodeMap::new(&a, Some(&at));
    let sum = Sum::new(&a, None).unwrap();
    let matrix = sum.blocks::<f64>(&map, sum.pattern(&map)).unwrap().matrix;
    let mut sweeps = Sweeps::<R>::new(&matrix);
    sweeps.half.level = level;
    let schedule = &sweeps.half.schedule;
    assert!(schedule.groups().len() > 2 && schedule.groups()[0].len() > 3);
    let part = |i: usize, j: usize| match (i / 3, j / 3) {
        (i, j) if i == j => 0,
        (i, j) if schedule.before(j, i) => -1,
        _ => 1,
    };
    let row = |i: usize| {
        let blocks = matrix.row(i / 3);
        let entries = blocks.flat_map(|(j, b)| (0..3).map(move |c| (3 * j + c, b[i % 3][c])));
        entries.map(|(j, v)| (j, v, part(i, j))).collect()
    };
    let reference = Reference((0..3 * matrix.rows()).map(row).collect());
    (sweeps, reference)
}

fn exact<R: Real>(x: &[R]) -> Vec<f64> {
    x.iter().map(|x| x.to_f64_exact()).collect()
}

fn near<R: Real>(found: &[f64], expected: &[f64]) -> bool {
    let size = expected.iter().fold(0.0f64, |m, v| m.max(v.abs()));
    let tolerance = 60.0 * R::epsilon().to_f64_exact() * size.max(1.0);
    let mut pairs = found.iter().zip(expected);
    found.len() == expected.len() && pairs.all(|(f, e)| (f - e).abs() <= tolerance)
}

fn sums(parts: [Vec<f64>; 2]) -> Vec<f64> {
    let [a, b] = parts;
    a.iter().zip(b).map(|(a, b)| a + b).collect()
}

fn check<R: Real>(level: Level) {
    let (sweeps, a) = sample::<R>(level);
    let n = 3 * sweeps.rows();
    let of = |v: Vec<f64>| v.into_iter().map(R::of).collect::<Vec<R>>();
    let (b, mut x) = (of(probe(n, 1)), of(vec![f64::NAN; n]));
    let mut r = x.clone();
    // (D + L) x = b, r = −Lᵀx
    let mut settings = Forward {
        from_zero: true,
        residual: false,
    };
    sweeps.forward(&b, &mut x, &mut r, settings);
    assert!(near::<R>(&a.times(&[-1, 0], &exact(&x)), &exact(&b)));
    let opposite = |v: Vec<f64>| v.into_iter().map(|v| -v).collect::<Vec<f64>>();
    assert!(near::<R>(&exact(&r), &opposite(a.times(&[1], &exact(&x)))));
    // (D + L) x' + Lᵀx = b, r = b − A x'
    let old = exact(&x);
    settings = Forward {
        from_zero: false,
        residual: true,
    };
    sweeps.forward(&b, &mut x, &mut r, settings);
    let image = sums([a.times(&[-1, 0], &exact(&x)), a.times(&[1], &old)]);
    assert!(near::<R>(&image, &exact(&b)));
    let image = sums([exact(&r), a.times(&[-1, 0, 1], &exact(&x))]);
    assert!(near::<R>(&image, &exact(&b)));
    // (D + Lᵀ) x' + L x = b
    let old = exact(&x);
    sweeps.backward(&b, &mut x, &mut r);
    let image = sums([a.times(&[0, 1], &exact(&x)), a.times(&[-1], &old)]);
    assert!(near::<R>(&image, &exact(&b)));
    // y + 2 A x
    let mut y = b.clone();
    sweeps.apply_add(R::of(2.0), &x, &mut y, &mut []);
    let twice = a
        .times(&[-1, 0, 1], &exact(&x))
        .into_iter()
        .map(|v| 2.0 * v);
    let image = sums([exact(&b), twice.collect()]);
    assert!(near::<R>(&exact(&y), &image));
}

#[test]
fn sweeps_and_products_meet_their_equations_on_every_instruction_set() {
    for level in Level::supported() {
        check::<f32>(level);
        check::<f64>(level);
    }
}

#[test]
fn half_a_matrix_is_the_same_in_memory_of_its_own_and_in_that_of_all() {
    let (a, at) = clamped_box([30, 4, 60], [1.0, 0.8, 1.2], |cell| 1.0 + cell[2] as f64);
    let map = NodeMap::new(&a, Some(&at));
    let sum = Sum::new(&a, None).unwrap();
    let matrix = sum.blocks::<f32>(&map, sum.pattern(&map)).unwrap().matrix;
    let (new, of) = (Sweeps::<f32>::new(&matrix), Sweeps::of(matrix));
    assert_eq!(new.half.pattern, of.half.pattern);
    assert_eq!(new.half.blocks, of.half.blocks);
    assert_eq!(new.half.diagonal, of.half.diagonal);
    assert_eq!(new.inverse, of.inverse);
}

#[test]
fn bits_do_not_depend_on_the_number_of_threads() {
    let (sweeps, _) = sample::<f32>(Level::best());
    let n = 3 * sweeps.rows();
    let b: Vec<f32> = probe::<f64>(n, 2).iter().map(|v| *v as f32).collect();
    let work = || {
        let (mut x, mut r) = (vec![0.0; n], vec![0.0; n]);
        let settings = Forward {
            from_zero: true,
            residual: true,
        };
        sweeps.forward(&b, &mut x, &mut r, settings);
        sweeps.backward(&b, &mut x, &mut r);
        sweeps.apply_add(1.0, &b, &mut x, &mut []);
        x
    };
    let on = |threads: usize| {
        let pool = rayon::ThreadPoolBuilder::new().num_threads(threads);
        pool.build().unwrap().install(work)
    };
    let first = on(1);
    assert!((2..5).all(|threads| on(threads) == first));
}
