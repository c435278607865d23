//! What can be wrong with a scene: where it is written and what to do.

use std::fmt;

use super::{
    FlowProblem, GeologyProblem, OnsetProblem, PartProblem, PoreProblem, ProfileProblem,
    SurfaceProblem, TableProblem,
};
use crate::mesh::MeshError;
use crate::units::MOST;
use fracas_solvers::words::by_number;

/// A place in a scene file.
#[derive(Clone, Debug, PartialEq, Eq)]
pub struct Place {
    /// File name.
    pub file: String,
    /// Line, counted from 1.
    pub line: usize,
    /// Column in characters, counted from 1.
    pub column: usize,
    /// The whole line.
    pub excerpt: String,
    /// Characters to underline.
    pub width: usize,
}

impl Place {
    /// The line with carets under what is meant.
    fn underlined(&self) -> String {
        let gutter = " ".repeat(self.line.to_string().len());
        let indent = " ".repeat(self.column - 1);
        let carets = "^".repeat(self.width);
        format!(
            "{gutter} |\n{} | {}\n{gutter} | {indent}{carets}",
            self.line, self.excerpt
        )
    }
}

impl fmt::Display for Place {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        write!(f, "{}:{}:{}", self.file, self.line, self.column)
    }
}

/// A section that makes no sense.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum Problem {
    /// From the mesh.
    #[error(transparent)]
    Mesh(#[from] MeshError),
    /// From the fluid.
    #[error(transparent)]
    Flow(#[from] FlowProblem),
    /// From layers and the faults in them.
    #[error(transparent)]
    Geology(#[from] GeologyProblem),
    /// From a table of pressures.
    #[error(transparent)]
    Table(#[from] TableProblem),
    /// From levels of a fracture.
    #[error(transparent)]
    Profile(#[from] ProfileProblem),
    /// From the onset of slip that is looked for.
    #[error(transparent)]
    Onset(#[from] OnsetProblem),
    /// From a part of a side.
    #[error(transparent)]
    Part(#[from] PartProblem),
    /// From a height over x and y.
    #[error(transparent)]
    Surface(#[from] SurfaceProblem),
    /// From a field of pressures, or a layer that one diffuses into.
    #[error(transparent)]
    Pores(#[from] PoreProblem),
    /// Two ways to say one thing.
    #[error(
        "material \"{name}\" has `pore_pressure` and `{key}`, which both say how its pressure changes; leave one of them out"
    )]
    TwoPressures {
        /// Its name.
        name: String,
        /// The other key.
        key: &'static str,
    },
    /// A pressure that follows the rock, and another one.
    #[error(
        "fracture \"{name}\" has `pressure_from`, which says what its pressure follows, beside {other}; leave one of them out"
    )]
    TwoFluids {
        /// Its name.
        name: String,
        /// The other one.
        other: &'static str,
    },
    /// A pressure that follows rock in which none changes.
    #[error(
        "fracture \"{name}\" has `pressure_from`, and on neither side of it a pore pressure changes; give a material beside it a `pore_pressure` or `pressure_change`, or leave it out"
    )]
    NoChangeBeside {
        /// Its name.
        name: String,
    },
    /// Weight that has no direction.
    #[error("the initial stress of weight needs [gravity] along z alone")]
    NoWeight,
    /// Rock that gravity asks for a density of.
    #[error(
        "material \"{name}\" has no `density`, by which [gravity] acts on it; give one, e.g. density = \"2500 kg/m3\", or \"0 kg/m3\" for rock without weight"
    )]
    NoDensity {
        /// Its name.
        name: String,
    },
    /// Rock that floats.
    #[error(
        "between z = {from} m and {to} m the rock weighs {rock:.4} kg/m3 and the fluid {fluid} kg/m3: it would be lifted, and its effective stress be a tension; `density` of a material is that of rock and pores together, not below that of `fluid`"
    )]
    Lifted {
        /// Lower end of the level of the mesh [m].
        from: f64,
        /// Upper end [m].
        to: f64,
        /// Mean density of the rock [kg/m³].
        rock: f64,
        /// Density of the fluid [kg/m³].
        fluid: f64,
    },
    /// Keys that are needed together.
    #[error(
        "[mesh.{axis}] needs `from`, `to` and `cells`, or `from`, `to`, `size`, `growth` and `near` or `fine`, or `lines` alone"
    )]
    AxisKeys {
        /// x, y or z.
        axis: &'static str,
    },
    /// A key of a grid beside a mesh file, or the other way round.
    #[error("{what} has `{key}`, which belongs to {belongs}; {instead}")]
    StrayKey {
        /// Which section.
        what: String,
        /// The key.
        key: &'static str,
        /// The kind of mesh that has it.
        belongs: &'static str,
        /// What to do.
        instead: &'static str,
    },
    /// A key that this kind of mesh needs.
    #[error("{what} needs `{key}`")]
    MissingKey {
        /// Which section.
        what: String,
        /// The key.
        key: &'static str,
    },
    /// Not exactly one of several keys.
    #[error("{what} needs exactly one of {keys}; it has {found}")]
    ExactlyOne {
        /// Which section.
        what: String,
        /// The keys.
        keys: &'static str,
        /// How many are there.
        found: usize,
    },
    /// An interval that is empty.
    #[error("{what} from {from} m to {to} m is empty; write the lower end first")]
    EmptyInterval {
        /// Which interval.
        what: String,
        /// Start [m].
        from: f64,
        /// End [m].
        to: f64,
    },
    /// A span along the fracture's own normal.
    #[error(
        "fracture \"{name}\" has the plane {axis}, so it cannot have a span in {axis}; use `at`"
    )]
    SpanAlongNormal {
        /// Its name.
        name: String,
        /// x, y or z.
        axis: &'static str,
    },
    /// A dip for planes that have none.
    #[error("`dip` needs `along = \"z\"` (planes x or y) or planes z; use `tilt` for other shears")]
    NoDip,
    /// Two parts of one name.
    #[error("two {what} are named \"{name}\"; names must differ")]
    DuplicateName {
        /// Materials or fractures.
        what: &'static str,
        /// The name.
        name: String,
    },
    /// No grid plane at all.
    #[error(
        "fracture \"{name}\" selects nothing: no interior grid line in {axis} is a multiple of `every = {every}`"
    )]
    NoPlane {
        /// Its name.
        name: String,
        /// x, y or z.
        axis: &'static str,
        /// The step asked for.
        every: u32,
    },
    /// An empty list of positions.
    #[error(
        "fracture \"{name}\" selects nothing: `at` is an empty list; give a position, e.g. at = \"4 m\""
    )]
    NoPosition {
        /// Its name.
        name: String,
    },
    /// A side that no single component is normal to.
    #[error("a roller needs a side perpendicular to an axis, but after the maps the normal of {side} is ({:.4}, {:.4}, {:.4}), {:.1e} deg off the next axis, at its first face that is not; use `hold = \"fixed\"`, a displacement, or a map that fades", normal[0], normal[1], normal[2], off_axis(*normal))]
    TiltedRoller {
        /// The side.
        side: String,
        /// Unit normal of the first face that is not perpendicular to an axis.
        normal: [f64; 3],
    },
    /// A displacement without components.
    #[error("the displacement of {side} has no component; give `x`, `y` or `z`")]
    NoComponent {
        /// The side.
        side: String,
    },
    /// A history that is no function of time.
    #[error(
        "a history needs at least one [time, factor], finite and with increasing times, e.g. [[\"0 s\", 0], [\"10 s\", 1]]{}",
        early.map_or_else(String::new, |point| format!("; its point {point} is no later than the one before"))
    )]
    BadHistory {
        /// The first point, from 1, that does not come after the one before it.
        early: Option<usize>,
    },
    /// A factor of which products leave the range of f64.
    #[error(
        "the factor {factor:e} of a history is out of range: factors are at most {:e} in size",
        MOST
    )]
    LargeFactor {
        /// As written.
        factor: f64,
    },
    /// Half of the weakening data.
    #[error(
        "fracture \"{name}\" weakens only with all of `friction_angle`, `dynamic_friction_angle` and `weakening_distance` (more than 0)"
    )]
    Weakening {
        /// Its name.
        name: String,
    },
    /// A key that changes nothing without another one.
    #[error("`{key}` of {what} has no effect without `{without}`; give both or neither")]
    Idle {
        /// The key.
        key: &'static str,
        /// Which section.
        what: String,
        /// What it would act on.
        without: &'static str,
    },
    /// Creep so fast that nothing is left of shear.
    #[error(
        "material \"{name}\" relaxes in {relaxation:.3e} s (viscosity over shear modulus), and a step is {step:.3e} s long: that is a fluid; take a viscosity of at least {least:.3e} Pa*s, or shorter steps"
    )]
    Flows {
        /// Its name.
        name: String,
        /// η/G [s].
        relaxation: f64,
        /// Length of a step [s].
        step: f64,
        /// Least viscosity [Pa·s].
        least: f64,
    },
    /// A history of what is zero at all times.
    #[error(
        "`history` of {side} has no effect beside `hold`, which is zero at all times; leave it out, or prescribe a `displacement`"
    )]
    HeldHistory {
        /// The side.
        side: String,
    },
    /// A history where no time passes.
    #[error(
        "`{key}` of {what} varies, but without [time] only the equilibrium at time 0 is solved; give [time] with `end` and `steps`, or leave the history out"
    )]
    Timeless {
        /// The key.
        key: &'static str,
        /// Which section.
        what: String,
    },
    /// A table that begins after the run.
    #[error(
        "`{key}` of {what} begins at {first}, and the run ends at {end}, so that nothing changes; count its times from the start of the run, or give it a row at time 0 where it begins later on purpose"
    )]
    Late {
        /// The key.
        key: &'static str,
        /// Which section.
        what: String,
        /// Its first time, as written.
        first: String,
        /// Of the run, as written.
        end: String,
    },
    /// A load on what is held.
    #[error(
        "`{key}` of {side} has no effect: the displacement along it is prescribed on the whole of it by `hold` or `displacement`; leave one of them out"
    )]
    HeldLoad {
        /// `pressure` or `traction`.
        key: &'static str,
        /// The side.
        side: String,
    },
    /// A last time of zero.
    #[error("`end` must be later than time 0")]
    NoTime,
    /// A number that the solver cannot use.
    #[error("`{key}` is {value}; it must be {requirement}")]
    SolverValue {
        /// Its key.
        key: &'static str,
        /// What is written.
        value: f64,
        /// What it must be.
        requirement: &'static str,
    },
    /// No material at all.
    #[error("the scene has no [[material]]; give at least one with name, young and poisson")]
    NoMaterial,
}

/// A scene that cannot be read or built.
#[derive(Debug, thiserror::Error)]
pub enum SceneError {
    /// The file cannot be read.
    #[error("cannot read {file}: {source}")]
    Read {
        /// File name.
        file: String,
        /// Why.
        source: std::io::Error,
    },
    /// The scene has no TOML form.
    #[error("cannot write the scene as TOML: {0}")]
    Write(#[from] toml::ser::Error),
    /// Not TOML, or a value that cannot be.
    #[error("{place}: {message}\n{}", place.underlined())]
    Syntax {
        /// Where.
        place: Box<Place>,
        /// What the parser or the value's own check says.
        message: String,
    },
    /// A key or a choice that does not exist.
    #[error("{place}: unknown {what} `{found}`{}; known here: {}\n{}", nearest.as_ref().map_or(String::new(), |n| format!(", did you mean `{n}`?")), known.join(", "), place.underlined())]
    Unknown {
        /// Where.
        place: Box<Place>,
        /// Key or value.
        what: &'static str,
        /// What is written.
        found: String,
        /// The known one most like it.
        nearest: Option<String>,
        /// All known ones.
        known: Vec<String>,
    },
    /// A section that makes no sense.
    #[error("{place}: {problem}\n{}", place.underlined())]
    Section {
        /// Where.
        place: Box<Place>,
        /// What is wrong.
        problem: Box<Problem>,
    },
    /// An override without a value.
    #[error("override {text}: write key=value, e.g. mesh.x.cells=8")]
    OverrideForm {
        /// What was written.
        text: String,
    },
    /// An override whose path leads nowhere.
    #[error("override {text}: `{segment}` is not in `{parent}`; there are: {}", known.join(", "))]
    OverridePath {
        /// What was written.
        text: String,
        /// The segment that does not fit.
        segment: String,
        /// What it was looked for in.
        parent: String,
        /// What is there.
        known: Vec<String>,
    },
    /// A body that can move rigidly.
    #[error(
        "body {body} ({elements} elements around ({:.6}, {:.6}, {:.6}) m) is not held by its boundary, nor by closed fractures to a held body: {free} rigid {} free{}; hold it with a [[boundary]] (roller, fixed or displacement)",
        center[0], center[1], center[2], by_number(*free, "motion is", "motions are"), free_axes_text(free_axes)
    )]
    NotHeld {
        /// Its number, in order of its lowest element.
        body: usize,
        /// Elements in it.
        elements: usize,
        /// Its centre [m].
        center: [f64; 3],
        /// Rigid motions left, together with the bodies that it touches.
        free: usize,
        /// Axes along which no displacement of it is prescribed.
        free_axes: [bool; 3],
    },
}

/// `, nothing holds it along x and y`.
fn free_axes_text(free: &[bool; 3]) -> String {
    let axes: Vec<&str> = (0..3)
        .filter(|d| free[*d])
        .map(|d| ["x", "y", "z"][d])
        .collect();
    match axes.is_empty() {
        true => String::new(),
        false => format!(", nothing is prescribed along {}", axes.join(", ")),
    }
}

/// Angle of a unit vector with the next axis [deg].
fn off_axis(n: [f64; 3]) -> f64 {
    let mut sizes = n.map(f64::abs);
    sizes.sort_by(f64::total_cmp);
    sizes[0].hypot(sizes[1]).atan2(sizes[2]).to_degrees()
}
