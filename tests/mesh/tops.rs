//! Claim: tops of `[geology]` that are not level lie where they are written: layers have their volumes, faults their planes and ends, no element
//! is inverted, and the scene that it becomes is the same mesh.
//!
//! `FRACAS_RUNS=2000 FRACAS_SEED=1000 cargo test --release --test mesh tops:: -- --nocapture` tries more of them.

use crate::geology::HELD;
use fracas::mesh::min_jacobian;
use fracas::scene::{Body, Scene};
use fracas_operators::random::Random;

/// Geologies where nobody asks for more.
const RUNS: u64 = 60;

const X: [f64; 2] = [-2000.0, 2000.0];

/// A height over x and y: a lattice of points, straight between them and constant beyond.
#[derive(Clone, Debug)]
struct Top {
    x: Vec<f64>,
    y: Vec<f64>,
    /// A row per y.
    z: Vec<Vec<f64>>,
}

impl Top {
    fn at(&self, x: f64, y: f64) -> f64 {
        let place = |lines: &[f64], value: f64| -> (usize, usize, f64) {
            let last = lines.len() - 1;
            let after = lines
                .iter()
                .position(|line| *line > value)
                .unwrap_or(last + 1);
            match after {
                0 => (0, 0, 0.0),
                after if after > last => (last, last, 0.0),
                after => {
                    let (a, b) = (lines[after - 1], lines[after]);
                    (after - 1, after, (value - a) / (b - a))
                }
            }
        };
        let ((i, k, u), (j, l, v)) = (place(&self.x, x), place(&self.y, y));
        let row = |j: usize| self.z[j][i] + u * (self.z[j][k] - self.z[j][i]);
        row(j) + v * (row(l) - row(j))
    }

    fn toml(&self) -> String {
        let m = |v: &f64| format!("'{v} m'");
        let list = |values: &[f64]| values.iter().map(m).collect::<Vec<_>>().join(", ");
        match (self.x.len(), self.y.len()) {
            (1, 1) => m(&self.z[0][0]),
            (_, 1) => {
                let pairs = self.x.iter().zip(&self.z[0]);
                let pairs: Vec<String> = pairs
                    .map(|(x, z)| format!("[{}, {}]", m(x), m(z)))
                    .collect();
                format!("{{ x = [{}] }}", pairs.join(", "))
            }
            (1, _) => {
                let pairs = self.y.iter().zip(&self.z);
                let pairs: Vec<String> = pairs
                    .map(|(y, z)| format!("[{}, {}]", m(y), m(&z[0])))
                    .collect();
                format!("{{ y = [{}] }}", pairs.join(", "))
            }
            _ => {
                let rows: Vec<String> = self
                    .z
                    .iter()
                    .map(|row| format!("[{}]", list(row)))
                    .collect();
                format!(
                    "{{ x = [{}], y = [{}], z = [{}] }}",
                    list(&self.x),
                    list(&self.y),
                    rows.join(", ")
                )
            }
        }
    }
}

#[derive(Debug)]
struct Fault {
    axis: usize,
    at: f64,
    throw: f64,
    /// Depth range, the whole box where it is none.
    z: Option<[f64; 2]>,
    cuts: Vec<bool>,
}

#[derive(Debug)]
struct Case {
    y: [f64; 2],
    slab: bool,
    tops: Vec<Top>,
    bottom: f64,
    faults: Vec<Fault>,
}

/// Numbers that differ by 100 m at least, increasing.
fn hundreds(r: &mut Random, [from, to]: [f64; 2], most: u32) -> Vec<f64> {
    let cells = ((to - from) / 100.0) as u32;
    let mut all: Vec<u32> = (0..r.whole(2, most)).map(|_| r.whole(0, cells)).collect();
    all.sort_unstable();
    all.dedup();
    all.into_iter()
        .map(|k| from + 100.0 * f64::from(k))
        .collect()
}

impl Case {
    fn new(seed: u64) -> Self {
        let r = &mut Random::new(seed.wrapping_mul(0x9E37_79B9) + 11);
        let slab = r.chance(0.4);
        let y = [0.0, if slab { 100.0 } else { 2000.0 }];
        let slope = [
            r.between(-0.08, 0.08),
            if slab { 0.0 } else { r.between(-0.01, 0.01) },
        ];
        let count = r.whole(2, 5);
        let (mut base, mut tops) = (r.between(-50.0, 50.0), Vec::new());
        for k in 0..count {
            let form = if k == 0 && r.chance(0.5) {
                0
            } else {
                r.whole(1, 3)
            };
            let x = match form {
                1 | 3 => hundreds(r, X, 5),
                _ => vec![0.0],
            };
            let own_y = match form {
                2 | 3 if !slab => hundreds(r, y, 4),
                _ => vec![0.0],
            };
            let rough = r.one_of(&[0.0, 15.0]);
            let height = |x: f64, y: f64, r: &mut Random| {
                base + slope[0] * x + slope[1] * (y - 1000.0) + r.between(-rough, rough)
            };
            let z = (own_y.iter())
                .map(|y| x.iter().map(|x| height(*x, *y, r)).collect())
                .collect();
            tops.push(Top { x, y: own_y, z });
            base -= r.between(380.0, 600.0);
        }
        let bottom = base - 300.0;
        let mut faults: Vec<Fault> = Vec::new();
        for axis in [0, 1] {
            if axis == 1 && slab {
                break;
            }
            let ends = [X, y][axis];
            let mut at = ends[0];
            for _ in 0..r.whole(0, 2 - axis as u32) {
                at += 100.0 * f64::from(r.whole(4, 14));
                if at >= ends[1] {
                    break;
                }
                let point = if axis == 0 {
                    [at, 0.5 * (y[0] + y[1])]
                } else {
                    [0.0, at]
                };
                // ends a hundred metres above one top and below another
                let heights: Vec<f64> = tops.iter().map(|t| t.at(point[0], point[1])).collect();
                let z = r.chance([0.6, 0.2][axis]).then(|| {
                    let high = r.below(heights.len());
                    let low = high + r.below(heights.len() - high);
                    [
                        (heights[low] - 130.0).round(),
                        (heights[high] - 40.0).round(),
                    ]
                });
                let is_cut = heights
                    .iter()
                    .map(|h| z.is_none_or(|[low, high]| low <= *h && *h <= high));
                let cuts: Vec<bool> = is_cut.collect();
                let moves = cuts[1..].contains(&true) && r.chance(0.7);
                let throw = if moves {
                    r.one_of(&[-1.0, 1.0]) * r.between(22.0, 90.0).round()
                } else {
                    0.0
                };
                faults.push(Fault {
                    axis,
                    at,
                    throw,
                    z,
                    cuts,
                });
            }
        }
        Self {
            y,
            slab,
            tops,
            bottom,
            faults,
        }
    }

    fn toml(&self, more: &str) -> String {
        let y = match self.slab {
            true => "from = '0 m', to = '100 m', cells = 1".to_owned(),
            false => {
                "from = '0 m', to = '2 km', size = '100 m', growth = 1.5, largest = '500 m'".into()
            }
        };
        let mut text = format!(
            "title = 'tops'\n[mesh]\nx = {{ from = '-2 km', to = '2 km', size = '100 m', growth = 1.4 }}\ny = {{ {y} }}\n\
             z = {{ size = '40 m', largest = '90 m' }}\n[geology]\nbottom = '{} m'\nlayers = [\n",
            self.bottom
        );
        for (k, top) in self.tops.iter().enumerate() {
            text += &format!("  {{ top = {}, material = 'layer {k}' }},\n", top.toml());
        }
        text += "]\n";
        for k in 0..self.tops.len() {
            text += &format!(
                "[[material]]\nname = 'layer {k}'\nyoung = '10 GPa'\npoisson = 0.2\ndensity = '{} kg/m3'\n",
                2000 + 100 * k
            );
        }
        for (k, f) in self.faults.iter().enumerate() {
            let axis = ["x", "y"][f.axis];
            text += &format!(
                "[[fracture]]\nname = 'f{k}'\nplane = '{axis}'\nat = '{} m'\nthrow = '{} m'\n",
                f.at, f.throw
            );
            if let Some([low, high]) = f.z {
                text += &format!("z = ['{low} m', '{high} m']\n");
            }
        }
        text + more + HELD
    }

    /// How much lower top k lies at a point because of faults.
    fn offset(&self, k: usize, point: [f64; 2]) -> f64 {
        let own = self
            .faults
            .iter()
            .filter(|f| k > 0 && f.cuts[k] && point[f.axis] > f.at);
        own.map(|f| f.throw).sum()
    }

    /// Volumes of the layers: tops are bilinear between all their points, and faults.
    fn volumes(&self) -> Vec<f64> {
        let lines = |axis: usize| {
            let ends = [X, self.y][axis];
            let of_tops = self.tops.iter().flat_map(|t| [&t.x, &t.y][axis]).copied();
            let faults = self.faults.iter().filter(|f| f.axis == axis).map(|f| f.at);
            let mut all: Vec<f64> = of_tops.chain(faults).chain(ends).collect();
            all.retain(|x| ends[0] <= *x && *x <= ends[1]);
            all.sort_by(f64::total_cmp);
            all.dedup();
            all
        };
        let count = self.tops.len();
        let mut below = vec![0.0; count + 1];
        for y in lines(1).windows(2) {
            for x in lines(0).windows(2) {
                let area = (x[1] - x[0]) * (y[1] - y[0]);
                let middle = [0.5 * (x[0] + x[1]), 0.5 * (y[0] + y[1])];
                for (k, top) in self.tops.iter().enumerate() {
                    let corners = [
                        top.at(x[0], y[0]),
                        top.at(x[1], y[0]),
                        top.at(x[0], y[1]),
                        top.at(x[1], y[1]),
                    ];
                    let height = corners.iter().sum::<f64>() / 4.0 - self.offset(k, middle);
                    below[k] += area * (height - self.bottom);
                }
            }
        }
        (0..count).map(|k| below[k] - below[k + 1]).collect()
    }

    fn judge(&self, body: &Body, exact: bool, seed: u64) {
        let count = self.tops.len();
        let mut volumes = vec![0.0; count];
        for (e, region) in body.mesh.regions.iter().enumerate() {
            let corners = body.mesh.elements[e].map(|a| body.mesh.nodes[a as usize]);
            assert!(min_jacobian(&corners) > 0.0, "seed {seed}, element {e}");
            volumes[usize::from(*region)] += body.mesh.element_volume(e);
        }
        let expected = self.volumes();
        let whole: f64 = expected.iter().sum();
        assert!(
            (volumes.iter().sum::<f64>() / whole - 1.0).abs() < 1e-12,
            "seed {seed}"
        );
        if exact {
            for (found, expected) in volumes.iter().zip(&expected) {
                assert!(
                    (found - expected).abs() < 1e-12 * whole,
                    "seed {seed}: {volumes:?} {expected:?}"
                );
            }
        }
        let mut seen = vec![[f64::INFINITY, f64::NEG_INFINITY]; self.faults.len()];
        for face in &body.fractures.faces {
            let number = usize::from(face.fracture);
            let fault = &self.faults[number];
            for a in face.plus.nodes.iter().chain(&face.minus.nodes) {
                let x = body.mesh.nodes[*a as usize];
                assert_eq!(x[fault.axis], fault.at, "seed {seed}");
                seen[number] = [seen[number][0].min(x[2]), seen[number][1].max(x[2])];
            }
            assert_eq!(face.frame[0][fault.axis].abs(), 1.0, "seed {seed}");
        }
        for (fault, seen) in self.faults.iter().zip(seen) {
            if let (Some(z), true) = (fault.z, exact) {
                let apart = (seen[0] - z[0]).abs().max((seen[1] - z[1]).abs());
                assert!(apart < 1e-9, "seed {seed}: {seen:?} {fault:?}");
            }
        }
    }
}

#[test]
fn random_tops_have_the_volumes_of_their_layers() {
    let number = |name: &str, default: u64| {
        std::env::var(name).map_or(default, |value| value.parse().unwrap())
    };
    let (first, runs) = (number("FRACAS_SEED", 0), number("FRACAS_RUNS", RUNS));
    let (mut built, mut exact, mut refused, mut thrown) = (0, 0, 0, 0);
    for seed in first..first + runs {
        let case = Case::new(seed);
        let text = case.toml("");
        let scene = match Scene::from_toml(&text, "t.toml") {
            Ok(scene) => scene,
            Err(error) => {
                let error = error.to_string();
                let known = [
                    "cannot follow both",
                    "is lost",
                    "of its own",
                    "leave nothing of it",
                ];
                assert!(
                    known.iter().any(|k| error.contains(k)),
                    "seed {seed}: {error}\n{text}"
                );
                refused += 1;
                continue;
            }
        };
        let body = scene
            .build()
            .unwrap_or_else(|e| panic!("seed {seed}: {e}\n{text}"));
        let geology = scene.geology().unwrap();
        let is_exact = geology.warnings().next().is_none();
        case.judge(&body, is_exact, seed);
        built += 1;
        exact += u64::from(is_exact);
        thrown += u64::from(case.faults.iter().any(|f| f.throw != 0.0));
        if seed % 5 == 0 {
            let again = Scene::from_toml(&scene.to_toml().unwrap(), "again.toml").unwrap();
            assert!(again.geology().is_none());
            let other = again.build().unwrap();
            assert_eq!(other.mesh, body.mesh, "seed {seed}");
            assert_eq!(other.fractures, body.fractures, "seed {seed}");
        }
    }
    println!("{built} built, {exact} to the last digit, {thrown} with throws; {refused} refused");
    assert!(4 * built >= 3 * runs && 2 * exact >= runs && 3 * thrown >= runs);
}

/// σ_v is the weight of the column above, at points anywhere.
#[test]
fn weight_is_that_of_the_column_above() {
    let mut points = 0;
    for seed in 0..12 {
        let case = Case::new(seed);
        let weight = "[gravity]\nz = '-10 m/s2'\n[initial_stress]\nweight = { horizontal = [0.7, 0.8], fluid = '1000 kg/m3' }\n";
        let Ok(scene) = Scene::from_toml(&case.toml(weight), "t.toml") else {
            continue;
        };
        if scene.geology().unwrap().warnings().next().is_some() {
            continue;
        }
        let body = scene.build().unwrap();
        let r = &mut Random::new(seed + 500);
        for _ in 0..200 {
            let [x, y] = [X, case.y].map(|[from, to]| r.between(from, to));
            let tops: Vec<f64> = (case.tops.iter().enumerate())
                .map(|(k, top)| top.at(x, y) - case.offset(k, [x, y]))
                .chain([case.bottom])
                .collect();
            let z = r.between(case.bottom, tops[0]);
            let column: f64 = (tops.windows(2).enumerate())
                .map(|(k, ends)| (1000.0 + 100.0 * k as f64) * (ends[0] - z.max(ends[1])).max(0.0))
                .sum();
            let [xx, yy, zz, ..] = body.initial_stress_at(0, [x, y, z]);
            for (found, share) in [(xx, 0.7), (yy, 0.8), (zz, 1.0)] {
                let expected = -10.0 * share * column;
                assert!(
                    (found - expected).abs() < 1e-9 * 1e7,
                    "seed {seed}: {found} {expected}"
                );
            }
            points += 1;
        }
    }
    assert!(points > 1000, "{points}");
}
