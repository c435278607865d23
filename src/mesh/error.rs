//! What can be wrong with a mesh: which part, where, what to do.

/// Letters of the axes, for messages.
pub(super) const AXES: [char; 3] = ['x', 'y', 'z'];

/// Most nodes of a grid: indices have 32 bits, and fractures may give a node eight copies.
pub const MAX_NODES: u128 = (u32::MAX / 8) as u128;

/// Three coordinates with six digits.
pub(super) fn point(x: &[f64; 3]) -> String {
    format!("({:.6}, {:.6}, {:.6}) m", x[0], x[1], x[2])
}

/// A mesh that cannot be built.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum MeshError {
    /// From a mesh file.
    #[error(transparent)]
    Gmsh(#[from] super::GmshError),
    /// An axis whose end does not lie beyond its start.
    #[error("axis {axis}: from {from} m to {to} m is empty; `to` must be greater than `from`")]
    EmptyAxis {
        /// x, y or z.
        axis: char,
        /// Start [m].
        from: f64,
        /// End [m].
        to: f64,
    },
    /// No cell at all.
    #[error("axis {axis} has no cell; give at least one")]
    NoCells {
        /// x, y or z.
        axis: char,
    },
    /// Lines that do not increase.
    #[error(
        "axis {axis}: line {index} at {value} m does not lie beyond the one before it at {before} m; lines must increase"
    )]
    LinesNotIncreasing {
        /// x, y or z.
        axis: char,
        /// Position in the list, counted from 1.
        index: usize,
        /// Its value [m].
        value: f64,
        /// The value before it [m].
        before: f64,
    },
    /// A grading that cannot be met.
    #[error("axis {axis}: grading ratio {ratio} cannot be met with {cells} cells; {advice}")]
    Grading {
        /// x, y or z.
        axis: char,
        /// The ratio asked for.
        ratio: f64,
        /// Number of cells.
        cells: usize,
        /// What to change.
        advice: &'static str,
    },
    /// A field of cell sizes that makes no sense.
    #[error("axis {axis}: {parameter} is {value}; it must be {requirement}")]
    SizeField {
        /// x, y or z.
        axis: char,
        /// Which one.
        parameter: &'static str,
        /// Its value.
        value: f64,
        /// What it must be.
        requirement: &'static str,
    },
    /// More nodes than 32-bit indices count when each of them gets eight copies.
    #[error(
        "{nodes} nodes are more than {MAX_NODES}, the most this mesh can number; use fewer cells"
    )]
    TooManyNodes {
        /// Nodes asked for.
        nodes: u128,
    },
    /// A fracture plane between two grid lines.
    #[error(
        "fracture \"{fracture}\": {axis} = {value} m is not a grid line; the nearest are {below} m and {above} m"
    )]
    OffGrid {
        /// Its name.
        fracture: String,
        /// Axis of the plane or of the span.
        axis: char,
        /// The coordinate asked for [m].
        value: f64,
        /// Grid line below [m].
        below: f64,
        /// Grid line above [m].
        above: f64,
    },
    /// A fracture that reaches out of the box.
    #[error(
        "fracture \"{fracture}\" leaves the box: {axis} = {value} m is outside [{from} m, {to} m]"
    )]
    OutsideBox {
        /// Its name.
        fracture: String,
        /// Axis of the plane or of the span.
        axis: char,
        /// The coordinate asked for [m].
        value: f64,
        /// Start of the box [m].
        from: f64,
        /// End of the box [m].
        to: f64,
    },
    /// A fracture on the surface of the box.
    #[error(
        "fracture \"{fracture}\" lies on the boundary {axis} = {value} m of the box, where there is rock on one side only; move it inside"
    )]
    OnBoundary {
        /// Its name.
        fracture: String,
        /// Axis of the plane.
        axis: char,
        /// Its coordinate [m].
        value: f64,
    },
    /// A span without a face.
    #[error(
        "fracture \"{fracture}\" selects no face: its span in {axis} from {from} m to {to} m is empty"
    )]
    SelectsNothing {
        /// Its name.
        fracture: String,
        /// Axis of the span.
        axis: char,
        /// Start [m].
        from: f64,
        /// End [m].
        to: f64,
    },
    /// Two fractures on one face.
    #[error(
        "fractures \"{first}\" and \"{second}\" share the face at {}; let one of them end where the other begins",
        point(center)
    )]
    Overlap {
        /// The earlier one.
        first: String,
        /// The later one.
        second: String,
        /// Centre of the first shared face, before any map [m].
        center: [f64; 3],
    },
    /// More fractures than 16-bit indices count.
    #[error("{count} fractures or regions are more than 65,535")]
    TooManyParts {
        /// Their number.
        count: usize,
    },
    /// A region that contains no element.
    #[error("material \"{region}\" selects no element: no cell centre lies in its box")]
    EmptyRegion {
        /// Name of the material.
        region: String,
    },
    /// An element that no region covers.
    #[error(
        "element {element} at {} has no material; let the first material have no box, so that it fills the rest",
        point(center)
    )]
    NoRegion {
        /// Its index.
        element: usize,
        /// Its centre before any map [m].
        center: [f64; 3],
    },
    /// An element turned inside out.
    #[error(
        "element {element} at {} is inverted: min det J = {min_jacobian:e} m^3; {advice}",
        point(center)
    )]
    Inverted {
        /// Its index.
        element: usize,
        /// Its centre [m].
        center: [f64; 3],
        /// Smallest Jacobian determinant on [−1, 1]³ over corners and Gauss points [m³].
        min_jacobian: f64,
        /// What to change.
        advice: &'static str,
    },
    /// A map whose parameters make no sense.
    #[error("map {map}: {parameter} is {value}, but it must be {requirement}")]
    BadWarp {
        /// Which map.
        map: &'static str,
        /// Which parameter.
        parameter: &'static str,
        /// Its value.
        value: f64,
        /// The condition.
        requirement: &'static str,
    },
    /// Levels of a grid whose surfaces meet or cross.
    #[error(
        "map lift: the levels z = {} m and z = {} m would lie at {} m and {} m at x = {} m, y = {} m; the upper one has to stay above the lower one", levels[0], levels[1], heights[0], heights[1], at[0], at[1]
    )]
    SurfacesMeet {
        /// Lower and upper level before the map [m].
        levels: [f64; 2],
        /// Where [m].
        at: [f64; 2],
        /// Where they would lie [m].
        heights: [f64; 2],
    },
}
