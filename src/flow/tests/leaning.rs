//! Faces that are no rectangles: what is linear is exact, and what is not converges.

use super::super::network::{Network, ends, meeting};
use super::super::vertex::{LEAST, dissipation, exact, flat};
use super::*;
use crate::mesh::{Distort, FractureFace, MeshError, Warp, WarpContext};
use fracas_operators::random::{signed, splitmix64};

/// Moves nodes of the planes z = const along them and, where `junction` stands, those of the plane with that index of x along it; then
/// an affine map.
#[derive(Clone, Debug)]
pub(super) struct Skewed {
    pub(super) seed: u64,
    /// Of a cell; below ¼ every face stays convex.
    pub(super) amplitude: f64,
    pub(super) junction: Option<usize>,
    /// Rows of the affine map.
    pub(super) map: [[f64; 3]; 3],
}

impl Warp for Skewed {
    fn advice(&self) -> &'static str {
        "lower the amplitude"
    }

    fn apply(&self, nodes: &mut [[f64; 3]], context: &WarpContext) -> Result<(), MeshError> {
        let line = |d: usize| &context.lines[d];
        for (a, x) in nodes.iter_mut().enumerate() {
            let index = context.index(a);
            let size = |d: usize| {
                let i = index[d].clamp(1, line(d).len() - 2);
                (line(d)[i + 1] - line(d)[i]).min(line(d)[i] - line(d)[i - 1])
            };
            let [i, j, k] = index.map(|i| i as u64);
            let noise = |d: u64, p: u64, q: u64| {
                signed(splitmix64(splitmix64(self.seed + d) ^ (1000 * p + q)))
            };
            let along = [noise(0, i, j), noise(1, i, j), noise(2, j, k)];
            let [on_junction, on_plane] = [self.junction == Some(index[0]), index[2] == 2];
            let free = [!on_junction, true, self.junction.is_some() && !on_plane];
            for d in (0..3).filter(|d| free[*d]) {
                x[d] += self.amplitude * size(d) * along[d];
            }
            *x = self.map.map(|row| (0..3).map(|d| row[d] * x[d]).sum());
        }
        Ok(())
    }
}

/// Planes that lean and nodes beside where they were, so that faces are general quadrilaterals, some of them warped.
pub(super) fn maps(seed: u64, tilt: f64) -> Vec<Box<dyn Warp>> {
    let distort = Distort {
        amplitude: 0.2,
        seed,
        smooth: false,
        planar: seed % 4 == 1,
    };
    let incline = |along: usize| Incline {
        plane: 0,
        along,
        tilt,
        pivot: [3.0, 0.0, 2.0],
        fade: true,
    };
    vec![Box::new(distort), Box::new(incline(2))]
}

/// Edges of one face alone.
fn rim(built: &BuiltMesh) -> Vec<[u32; 2]> {
    let faces = &built.fractures.faces;
    let all = faces
        .iter()
        .flat_map(|face| (0..4).map(|a| ends(face, &built.mesh, a)));
    let mut all: Vec<[u32; 2]> = all.collect();
    all.sort_unstable();
    let alone = all.chunk_by(|a, b| a == b).filter(|list| list.len() == 1);
    alone.map(|list| list[0]).collect()
}

pub(super) fn dot(a: [f64; 3], b: [f64; 3]) -> f64 {
    (0..3).map(|i| a[i] * b[i]).sum()
}

/// Largest size of a potential at the centres of faces [Pa].
pub(super) fn highest(faces: &[FractureFace], potential: impl Fn([f64; 3]) -> f64) -> f64 {
    let sizes = faces.iter().map(|face| potential(face.center).abs());
    sizes.fold(0.0, f64::max)
}

/// Potentials at centres of faces and flow per width, where the rim has this potential in the middles of its edges.
pub(super) fn driven(
    built: &BuiltMesh,
    fluid: Fluid,
    potential: impl Fn([f64; 3]) -> f64,
) -> (Vec<f64>, Vec<f64>) {
    let mut fluid = fluid;
    for edge in rim(built) {
        let [p, q] = edge.map(|n| built.mesh.nodes[n as usize]);
        let x = [0, 1, 2].map(|i| 0.5 * (p[i] + q[i]));
        let source = held(vec![edge], potential(x) + fluid.head(x));
        fluid.sources.push(source);
    }
    let balance = balance(&fluid, built);
    let n = built.fractures.faces.len();
    let step = step(&balance, n, 1.0);
    let p = rigid(&balance, &step);
    let q = balance.fluxes(&vec![ContactState::Stick; n], &vec![0.0; 3 * n], &p, &step);
    let faces = built.fractures.faces.iter().zip(&p);
    let potential = faces.map(|(face, p)| p - fluid.head(face.center));
    (potential.collect(), q)
}

/// True where W of every corner is the exact one.
fn all_exact(built: &BuiltMesh) -> bool {
    let mut corners = built
        .fractures
        .faces
        .iter()
        .map(|face| flat(face, &built.mesh));
    corners.all(is_exact)
}

/// The same of a face with these corners.
pub(super) fn is_exact(x: [[f64; 2]; 4]) -> bool {
    (0..4).all(|a| {
        let (w, normals) = exact(x, a);
        dissipation(w, normals).1 >= LEAST
    })
}

/// Shear in the plane z = const by up to 60°, cells of up to 1:`flat`, and the plane turned.
pub(super) fn affine(r: &mut Random, flat: f64) -> [[f64; 3]; 3] {
    let slope = |r: &mut Random, most: f64| r.between(-most, most).to_radians().tan();
    let (lean, stretch) = (slope(r, 60.0), r.scale(1.0 / flat, flat));
    let (a, b) = (slope(r, 50.0), slope(r, 50.0));
    [[stretch, lean, 0.0], [0.0, 1.0, 0.0], [a * stretch, b, 1.0]]
}

#[test]
fn linear_potentials_are_exact_on_leaning_and_on_general_quadrilaterals() {
    let mut exact_ones = 0;
    for seed in 0..120 {
        let r = &mut Random::new(seed + 4100);
        let mut grid = grid([7, 6, 4], vec![PlaneFracture::through("F", 2, 2.0)]);
        // flat parallelograms, and quadrilaterals of every shape
        let (amplitude, flat) = match r.chance(0.3) {
            true => (0.0, 50.0),
            false => (r.between(0.0, 0.24), 3.0),
        };
        grid.warps = vec![Box::new(Skewed {
            seed,
            amplitude,
            junction: None,
            map: affine(r, flat),
        })];
        let built = grid.build().unwrap();
        let exact_here = all_exact(&built);
        let faces = &built.fractures.faces;
        let c = 10f64.powf(r.between(-18.0, -8.0));
        let mut fluid = fluid(&[c], Vec::new());
        if r.chance(0.5) {
            (fluid.density, fluid.gravity) = (1e3, [0.3, 0.0, -9.81]);
        }
        let [_, t1, t2] = faces[0].frame;
        let along = [r.between(-1e6, 1e6), r.between(-1e6, 1e6)];
        let gradient = [0, 1, 2].map(|i| along[0] * t1[i] + along[1] * t2[i]);
        let exact = |x: [f64; 3]| 1e6 + dot(gradient, x);
        let (potential, q) = driven(&built, fluid, exact);
        let range = highest(faces, exact);
        for ((face, found), q) in faces.iter().zip(&potential).zip(q.chunks_exact(3)) {
            let off = (found - exact(face.center)).abs() / range;
            let size = c / 1e-3 * along[0].hypot(along[1]);
            let beside = (0..3).map(|i| (q[i] + c / 1e-3 * gradient[i]).abs() / size);
            let beside = beside.fold(0.0, f64::max);
            // elsewhere, too, an even gradient remains one by and large
            let [least, most] = if exact_here {
                [1e-9, 1e-6]
            } else {
                [0.02, 1.0]
            };
            assert!(
                off < least && beside < most,
                "seed {seed}: {off:e} {beside:e}"
            );
        }
        exact_ones += usize::from(exact_here);
    }
    assert!(exact_ones >= 100, "{exact_ones} of 120");
}

#[test]
fn rectangles_have_two_point_fluxes_whoever_decides() {
    for seed in (0..40).step_by(2) {
        let case = case(seed, true);
        let mut balance = balance(&case.fluid, &case.built);
        let [pressure, aperture] = case.before.clone();
        let step = balance.step([0.0, 7.0], pressure, aperture, |_, _| 1.0);
        let two_point = balance.evaluate(&case.states, &case.jumps, &case.p, &step);
        let flow = balance.fluxes(&case.states, &case.jumps, &case.p, &step);
        assert_eq!(balance.network.around().count(), 0, "seed {seed}");
        let (mesh, faces) = (&case.built.mesh, &case.built.fractures.faces);
        let edges = case
            .fluid
            .sources
            .iter()
            .filter_map(|source| match &source.place {
                Place::Edges(edges) => Some(edges.clone()),
                Place::Faces(_) => None,
            });
        let edges = edges.flatten().collect::<Vec<_>>();
        // all nodes decide, or some
        for every in [1, 3] {
            let nodes = faces.iter().flat_map(|face| face.minus.nodes);
            let mut nodes: Vec<u32> = nodes.map(|n| mesh.origin[n as usize]).collect();
            nodes.sort_unstable();
            nodes.dedup();
            let nodes = meeting(faces, mesh, nodes.into_iter().step_by(every).collect());
            balance.network = Network::deciding(faces, mesh, &edges, &case.fluid, &nodes);
            assert!(balance.network.around().count() > 10);
            let point = balance.evaluate(&case.states, &case.jumps, &case.p, &step);
            for (a, b) in two_point.residual.iter().zip(&point.residual) {
                assert!(
                    (a - b).abs() < 1e-12 * point.size,
                    "seed {seed}: {a:e} {b:e}"
                );
            }
            let others = balance.fluxes(&case.states, &case.jumps, &case.p, &step);
            let size = flow.iter().fold(0.0f64, |m, q| m.max(q.abs()));
            for (a, b) in flow.iter().zip(&others) {
                assert!((a - b).abs() < 1e-10 * size, "seed {seed}: {a:e} {b:e}");
            }
        }
    }
}

#[test]
fn parallelograms_have_symmetric_fluxes_that_dissipate_whatever_the_conductivities() {
    for seed in 0..40 {
        let r = &mut Random::new(seed + 4200);
        let mut grid = grid([6, 5, 4], vec![PlaneFracture::through("F", 2, 2.0)]);
        grid.warps = vec![Box::new(Skewed {
            seed,
            amplitude: 0.0,
            junction: None,
            map: affine(r, 50.0),
        })];
        let built = grid.build().unwrap();
        let n = built.fractures.faces.len();
        let fluid = fluid(&[10f64.powf(r.between(-18.0, -10.0))], Vec::new());
        let balance = balance(&fluid, &built);
        let step = step(&balance, n, 1.0);
        // no two open faces are neighbours, so that no pressure is stabilized
        let mut open =
            |f: usize| f == 0 || [f, f / 6].iter().all(|i| i.is_multiple_of(2)) && r.chance(0.6);
        let states: Vec<ContactState> = (0..n)
            .map(|f| {
                if open(f) {
                    ContactState::Open
                } else {
                    ContactState::Stick
                }
            })
            .collect();
        let jumps: Vec<f64> = (0..3 * n)
            .map(|_| 10f64.powf(r.between(-6.0, -2.0)))
            .collect();
        let t = balance.tangent(&states, &jumps, &vec![0.0; n], &step).t;
        let largest = t.data().iter().fold(0.0f64, |m, v| m.max(v.abs()));
        for (value, (k, l)) in &t {
            let mirrored = t.get(l as usize, k as usize).copied().unwrap_or(0.0);
            assert!(
                (value - mirrored).abs() < 1e-12 * largest,
                "seed {seed}: ({k}, {l})"
            );
        }
        for _ in 0..20 {
            let x: Vec<f64> = (0..n).map(|_| r.between(-1.0, 1.0)).collect();
            let work: f64 = (t.iter())
                .map(|(v, (k, l))| x[k as usize] * v * x[l as usize])
                .sum();
            assert!(work > 0.0, "seed {seed}: {work:e}");
        }
    }
}

#[test]
fn flow_goes_down_the_potential_on_flat_and_rough_quadrilaterals() {
    let mut rough = 0;
    for seed in 0..60 {
        let r = &mut Random::new(seed + 4500);
        let mut grid = grid([6, 5, 4], vec![PlaneFracture::through("F", 2, 2.0)]);
        grid.warps = vec![Box::new(Skewed {
            seed,
            amplitude: r.between(0.0, 0.24),
            junction: None,
            map: affine(r, 50.0),
        })];
        let built = grid.build().unwrap();
        rough += usize::from(!all_exact(&built));
        let n = built.fractures.faces.len();
        let fluid = fluid(&[1e-18], Vec::new());
        let balance = balance(&fluid, &built);
        let step = step(&balance, n, 1.0);
        let mobility: Vec<f64> = (0..n).map(|_| 10f64.powf(r.between(-4.0, 4.0))).collect();
        for _ in 0..40 {
            // one face, or all
            let of = |f: usize, r: &mut Random| f64::from(f % 7 == 3) + r.between(-1.0, 1.0);
            let x: Vec<f64> = (0..n).map(|f| of(f, r)).collect();
            let (_, driven) = balance.potentials(&x, &step);
            let (mut work, mut size) = (0.0, 0.0);
            balance.network.visit(&mobility, &x, &driven, |edge| {
                for (f, flux) in edge.fluxes() {
                    work += x[f] * flux;
                    size += (x[f] * flux).abs();
                }
            });
            assert!(work > 0.0, "seed {seed}: {work:e} of {size:e}");
        }
    }
    assert!((20..60).contains(&rough), "{rough} of 60");
}

/// Two planes of random conductivities that meet along a line, whole or not, in random quadrilaterals, both leaning.
#[test]
fn junctions_of_leaning_planes_split_flow_as_their_conductivities_say() {
    for seed in 0..60 {
        let r = &mut Random::new(seed + 4300);
        let mut planes = vec![
            PlaneFracture::through("F", 2, 2.0),
            PlaneFracture::through("G", 0, 3.0),
        ];
        let ends_there = r.chance(0.5);
        if ends_there {
            planes[1].spans[2] = Some([2.0, 4.0]);
        }
        let mut grid = grid([6, 5, 4], planes);
        grid.axes[2] = Axis::Cells {
            from: 0.0,
            to: 4.0,
            cells: 4,
            grading: Grading::Uniform,
        };
        let slope = |r: &mut Random| r.between(-45.0, 45.0f64).to_radians().tan();
        let (a, b, c) = (slope(r), slope(r), slope(r));
        let map = [[1.0, a, c], [0.0, 1.0, 0.0], [0.0, b, 1.0]];
        grid.warps = vec![Box::new(Skewed {
            seed,
            amplitude: r.between(0.0, 0.24),
            junction: Some(3),
            map,
        })];
        let built = grid.build().unwrap();
        let mapped = |x: [f64; 3]| map.map(|row| dot(row, x));
        let (on_line, line) = (mapped([3.0, 0.0, 2.0]), mapped([0.0, 1.0, 0.0]));
        let unit = |v: [f64; 3]| v.map(|x| x / dot(v, v).sqrt());
        let line = unit(line);
        // away from the line, in F and in G
        let away = [mapped([1.0, 0.0, 0.0]), mapped([0.0, 0.0, 1.0])]
            .map(|v| unit([0, 1, 2].map(|i| v[i] - dot(v, line) * line[i])));
        let conductivity = [0, 1].map(|_| 10f64.powf(r.between(-16.0, -10.0)));
        // what leaves the line in each arm per width: F to both sides, G up, G down
        let mut out = [0, 1, 2, 3].map(|_| r.between(-1.0, 1.0));
        if ends_there {
            out[3] = 0.0;
        }
        out[1] = -out[0] - out[2] - out[3];
        let scale = 1e6 * conductivity[0].min(conductivity[1]);
        let slopes = [0, 1, 2, 3].map(|k| -out[k] * scale / conductivity[k / 2]);
        let drift = r.between(-1e6, 1e6);
        // in which arm a point lies, and how far from the line
        let arm = |x: [f64; 3], plane: usize| {
            let s = dot([0, 1, 2].map(|i| x[i] - on_line[i]), away[plane]);
            (2 * plane + usize::from(s < 0.0), s.abs())
        };
        let normals = [0u16, 1].map(|f| {
            let mut faces = built.fractures.faces.iter();
            faces.find(|face| face.fracture == f).unwrap().frame[0]
        });
        let exact = |x: [f64; 3]| {
            let to = [0, 1, 2].map(|i| x[i] - on_line[i]);
            let plane = usize::from(dot(to, normals[0]).abs() > dot(to, normals[1]).abs());
            let (k, s) = arm(x, plane);
            drift * dot(to, line) + slopes[k] * s
        };
        let (potential, q) = driven(&built, fluid(&conductivity, Vec::new()), exact);
        let faces = &built.fractures.faces;
        let range = highest(faces, exact);
        for ((face, found), q) in faces.iter().zip(&potential).zip(q.chunks_exact(3)) {
            let off = (found - exact(face.center)).abs() / range;
            let plane = usize::from(face.fracture);
            let (k, _) = arm(face.center, plane);
            let sign = if k % 2 == 0 { 1.0 } else { -1.0 };
            let by = conductivity[plane] / 1e-3;
            for i in 0..3 {
                let flow = -by * (drift * line[i] + sign * slopes[k] * away[plane][i]);
                let size = by * (drift.abs() + slopes[k].abs()) + by * range * 1e-4;
                assert!(
                    (q[i] - flow).abs() < 1e-7 * size,
                    "seed {seed}: {} {flow}",
                    q[i]
                );
            }
            assert!(off < 1e-9, "seed {seed}: {off:e}");
        }
    }
}

/// Radial flow, whose centre lies beside the plane.
#[test]
fn radial_flow_converges_on_leaning_grids_as_on_upright_ones() {
    for seed in 0..12 {
        let r = &mut Random::new(seed + 4400);
        let lean =
            r.between(20.0, 60.0f64).to_radians().tan() * if r.chance(0.5) { 1.0 } else { -1.0 };
        let amplitude = if r.chance(0.5) { 0.0 } else { 0.2 };
        let centre = [-1.0 + (if lean < 0.0 { 5.0 * lean } else { 0.0 }), -1.0];
        let radial = |x: [f64; 3]| 1e6 * (x[0] - centre[0]).hypot(x[1] - centre[1]).ln();
        let error = |cells: usize| {
            let mut grid = grid([cells, cells, 4], vec![PlaneFracture::through("F", 2, 2.0)]);
            grid.warps = vec![Box::new(Skewed {
                seed,
                amplitude,
                junction: None,
                map: [[1.0, lean, 0.0], [0.0, 1.0, 0.0], [0.0, 0.0, 1.0]],
            })];
            let built = grid.build().unwrap();
            let (potential, _) = driven(&built, fluid(&[1e-12], Vec::new()), radial);
            let faces = built.fractures.faces.iter().zip(&potential);
            let squares = faces.map(|(face, p)| face.area * (p - radial(face.center)).powi(2));
            squares.sum::<f64>().sqrt() / 30f64.sqrt()
        };
        let errors = [8, 16, 32].map(error);
        let order = (errors[0] / errors[2]).log2() / 2.0;
        assert!(order > 1.5, "seed {seed}: {order} of {errors:?}");
    }
}
