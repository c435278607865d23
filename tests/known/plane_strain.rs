//! Bodies in plane strain in (x, z): their equilibrium, and their fractures as pieces of a line.

use fracas::contact::ContactState;
use fracas::nonlinear::{FaceFields, Simulation, State};
use fracas::scene::Body;
use fracas_solvers::Silent;

/// A face along a line through the origin with the tangent t; its normal n = (−t_z, t_x) lies to the left.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Piece {
    /// Where it starts and ends along the line [m].
    pub(crate) span: [f64; 2],
    /// Area [m²].
    pub(crate) area: f64,
    /// Traction σ·n along (n, t) [Pa].
    pub(crate) traction: [f64; 2],
    /// u(left) − u(right) along (n, t) [m].
    pub(crate) jump: [f64; 2],
    /// Contact state.
    pub(crate) state: ContactState,
}

impl Piece {
    pub(crate) fn middle(&self) -> f64 {
        0.5 * (self.span[0] + self.span[1])
    }
}

/// What is around cracks in a scene: a stress (xx, zz) [Pa], sides along x and z that do not move, none across y, and AMG beside other
/// lines of the solver.
pub(crate) fn surroundings([xx, zz]: [f64; 2], solver: &str) -> String {
    let mut toml = format!("[initial_stress]\nconstant = {{ xx = '{xx} Pa', zz = '{zz} Pa' }}\n");
    for (side, hold) in [
        ("x-", "fixed"),
        ("x+", "fixed"),
        ("z-", "fixed"),
        ("z+", "fixed"),
        ("y-", "roller"),
        ("y+", "roller"),
    ] {
        toml += &format!("[[boundary]]\nside = '{side}'\nhold = '{hold}'\n");
    }
    toml + "[solver]\ntolerance = 1e-10\nracp = { augmentation = 'local_h', inner = { amg = {} } }\n"
        + solver
}

/// The body under its last loads.
pub(crate) fn solved(body: &Body) -> (State, FaceFields) {
    let mut simulation = Simulation::new(body).unwrap();
    let state = simulation.run(&mut Silent, |_, _, _| ()).unwrap();
    let fields = simulation.face_fields(&state);
    (state, fields)
}

/// The faces of one fracture by increasing position along t = (t_x, t_z); rows across the thickness follow each other.
pub(crate) fn pieces(
    body: &Body,
    (state, fields): &(State, FaceFields),
    fracture: usize,
    t: [f64; 2],
) -> Vec<Piece> {
    let t = [t[0], 0.0, t[1]];
    let left = [-t[2], 0.0, t[0]];
    let dot = |a: &[f64; 3], b: &[f64; 3]| (0..3).map(|d| a[d] * b[d]).sum::<f64>();
    let mut pieces: Vec<Piece> = Vec::new();
    for (f, face) in body.fractures.faces.iter().enumerate() {
        if usize::from(face.fracture) != fracture {
            continue;
        }
        let places = face
            .minus
            .nodes
            .map(|a| dot(&body.mesh.nodes[a as usize], &t));
        let sign = dot(&face.frame[0], &left).signum();
        assert!((dot(&face.frame[0], &left).abs() - 1.0).abs() < 1e-9);
        let two = |v: &[f64]| {
            let along: f64 = (1..3).map(|k| v[3 * f + k] * dot(&face.frame[k], &t)).sum();
            [v[3 * f], sign * along]
        };
        pieces.push(Piece {
            span: [
                places.into_iter().fold(f64::INFINITY, f64::min),
                places.into_iter().fold(f64::NEG_INFINITY, f64::max),
            ],
            area: face.area,
            traction: two(&fields.traction),
            jump: two(&fields.jump),
            state: state.states[f],
        });
    }
    pieces.sort_by(|a, b| a.middle().total_cmp(&b.middle()));
    pieces
}
