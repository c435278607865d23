//! A fault in a pressed and sheared plate, meshed with a fracture or with a layer of weak cells.

use super::run::Run;
use fracas::nonlinear::Simulation;
use fracas::scene::{Body, Scene};

/// Half size of the plate, and half length of the fault [m].
const HALF: f64 = 4.0;
const TIP: f64 = 2.0;

/// What every version has in common, after the mesh and the materials: pressed by 1 mm, sheared by 2 mm.
const LOADS: &str = r#"
[[boundary]]
side = "y-"
hold = "roller"
[[boundary]]
side = "y+"
hold = "roller"
[[boundary]]
side = "x-"
hold = "fixed"
[[boundary]]
side = "x+"
displacement = { x = "-1 mm" }
[[boundary]]
side = "x+"
displacement = { z = "2 mm" }
[solver]
tolerance = 1e-10
inner = "exact"
"#;

const ROCK: &str = r#"
[[material]]
name = "rock"
young = "25 GPa"
poisson = 0.25
"#;

fn mesh(n: usize, x: &str) -> String {
    let y = (n / 8).max(1);
    format!(
        "title = \"Fault in a plate\"\n[mesh]\nx = {x}\ny = {{ from = \"0 m\", to = \"1 m\", cells = {y} }}\n\
         z = {{ from = \"-{HALF} m\", to = \"{HALF} m\", cells = {n} }}\n"
    )
}

/// With a fracture of friction angle 20 deg; n cells across the plate, a multiple of 8.
pub(super) fn fractured(n: usize) -> anyhow::Result<Scene> {
    let x = format!("{{ from = \"-{HALF} m\", to = \"{HALF} m\", cells = {n} }}");
    let fault = format!(
        "[[fracture]]\nname = \"fault\"\nplane = \"x\"\nat = \"0 m\"\nz = [\"-{TIP} m\", \"{TIP} m\"]\nfriction_angle = \"20 deg\"\n"
    );
    let text = format!("{}{ROCK}{fault}{LOADS}", mesh(n, &x));
    Ok(Scene::from_toml(&text, "fault.toml")?)
}

/// Without a fracture: one layer of cells of this thickness [m] has the stiffness of the rock times `ratio`.
pub(super) fn layered(n: usize, thickness: f64, ratio: f64) -> anyhow::Result<Scene> {
    let (half, side) = (0.5 * thickness, n / 2);
    let left = (0..=side).map(|i| -HALF + (HALF - half) * i as f64 / side as f64);
    let right = (0..=side).map(|i| half + (HALF - half) * i as f64 / side as f64);
    let lines: Vec<String> = left.chain(right).map(|x| format!("\"{x} m\"")).collect();
    let x = format!("{{ lines = [{}] }}", lines.join(", "));
    let weak = format!(
        "[[material]]\nname = \"weak\"\nyoung = \"{:e} Pa\"\npoisson = 0.25\nboxes = [{{ x = [\"-{half} m\", \"{half} m\"], z = [\"-{TIP} m\", \"{TIP} m\"] }}]\n",
        25e9 * ratio
    );
    let text = format!("{}{ROCK}{weak}{LOADS}", mesh(n, &x));
    Ok(Scene::from_toml(&text, "layer.toml")?)
}

/// Jump and traction along the fault: one (t_N, t_y, t_z) and (g_N, g_y, g_z) per face, in the axes of the plate.
pub(super) struct Profile {
    pub(super) centers: Vec<[f64; 2]>,
    pub(super) areas: Vec<f64>,
    pub(super) jump: Vec<[f64; 3]>,
    pub(super) traction: Vec<[f64; 3]>,
}

impl Profile {
    /// Of a finished run.
    pub(super) fn of(run: &Run) -> anyhow::Result<Self> {
        let simulation = Simulation::new(&run.body)?;
        let last = run.steps.last().ok_or_else(|| anyhow::anyhow!("no step"))?;
        let fields = simulation.face_fields(&last.state);
        let faces = &run.body.fractures.faces;
        let in_axes = |field: &[f64]| -> Vec<[f64; 3]> {
            let rotate = |(f, face): (usize, &fracas::mesh::FractureFace)| {
                std::array::from_fn(|i| (0..3).map(|k| field[3 * f + k] * face.frame[k][i]).sum())
            };
            faces.iter().enumerate().map(rotate).collect()
        };
        // the normal points along x or against it: jump and traction turn together
        let jump = in_axes(&fields.jump);
        let traction = in_axes(&fields.traction);
        let sign = |f: usize| faces[f].frame[0][0].signum();
        let turned = |field: Vec<[f64; 3]>| {
            let turn = |(f, v): (usize, [f64; 3])| v.map(|v| sign(f) * v);
            field.into_iter().enumerate().map(turn).collect()
        };
        Ok(Self {
            centers: faces.iter().map(|f| [f.center[1], f.center[2]]).collect(),
            areas: faces.iter().map(|f| f.area).collect(),
            jump: turned(jump),
            traction: turned(traction),
        })
    }

    /// Means over the faces of a coarser mesh whose centres are nearest.
    pub(super) fn onto(&self, coarse: &Self) -> Self {
        let mut sum = vec![[0.0; 7]; coarse.centers.len()];
        for (f, c) in self.centers.iter().enumerate() {
            let distance = |o: &[f64; 2]| (o[0] - c[0]).hypot(o[1] - c[1]);
            let nearest = (0..coarse.centers.len()).min_by(|a, b| {
                distance(&coarse.centers[*a]).total_cmp(&distance(&coarse.centers[*b]))
            });
            if let Some(nearest) = nearest {
                let values = self.jump[f].iter().chain(&self.traction[f]);
                for (s, v) in sum[nearest].iter_mut().zip(values.chain(&[1.0])) {
                    *s += self.areas[f] * v;
                }
            }
        }
        let mean = |from: usize| {
            sum.iter()
                .map(|s| std::array::from_fn(|k| s[from + k] / s[6]))
                .collect()
        };
        Self {
            centers: coarse.centers.clone(),
            areas: coarse.areas.clone(),
            jump: mean(0),
            traction: mean(3),
        }
    }

    /// `‖g_T − g_T ref‖/‖g_T ref‖` and `‖t − t_ref‖/‖t_ref‖` over the fault, L².
    pub(super) fn errors(&self, reference: &Self) -> [f64; 2] {
        let norm = |field: &dyn Fn(usize) -> f64| -> f64 {
            (0..self.areas.len())
                .map(|f| self.areas[f] * field(f))
                .sum::<f64>()
                .sqrt()
        };
        let square = |a: [f64; 3], b: [f64; 3], from: usize| -> f64 {
            (from..3).map(|k| (a[k] - b[k]).powi(2)).sum()
        };
        let zero = [0.0; 3];
        [
            norm(&|f| square(self.jump[f], reference.jump[f], 1))
                / norm(&|f| square(reference.jump[f], zero, 1)),
            norm(&|f| square(self.traction[f], reference.traction[f], 0))
                / norm(&|f| square(reference.traction[f], zero, 0)),
        ]
    }

    /// Mean of the jump (g_N, g_z) of faces within `reach` of the middle [m].
    pub(super) fn middle(&self, reach: f64) -> [f64; 2] {
        let near: Vec<usize> = (0..self.areas.len())
            .filter(|f| self.centers[*f][1].abs() < reach)
            .collect();
        let area: f64 = near.iter().map(|f| self.areas[*f]).sum();
        [0, 2].map(|k| {
            near.iter()
                .map(|f| self.areas[*f] * self.jump[*f][k])
                .sum::<f64>()
                / area
        })
    }
}

/// Jump (x, z) across a layer in the middle of the fault: displacements of its right less its left, mean over the nodes at z = 0.
pub(super) fn across(body: &Body, displacement: &[f64], thickness: f64) -> [f64; 2] {
    let half = 0.5 * thickness;
    let mut jump = [0.0; 2];
    let mut nodes = 0.0;
    for (node, x) in body.mesh.nodes.iter().enumerate() {
        let at = (x[0].abs() - half).abs() < 1e-9 && x[2].abs() < 1e-9;
        if at {
            let sign = x[0].signum();
            jump[0] += sign * displacement[3 * node];
            jump[1] += sign * displacement[3 * node + 2];
            nodes += 0.5;
        }
    }
    jump.map(|j| j / nodes)
}
