//! What can be wrong with layers and the faults in them.

/// Layers or faults that make no sense.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum GeologyProblem {
    /// No layer.
    #[error(
        "[geology] has no layer; give at least one, e.g. {{ top = \"0 m\", material = \"rock\" }}"
    )]
    NoLayer,
    /// Layers out of order.
    #[error(
        "the top of \"{name}\" at {top} m does not lie below the top of \"{above}\" at {limit} m; list layers from the top down"
    )]
    Order {
        /// Material of the layer.
        name: String,
        /// Its top [m].
        top: f64,
        /// The layer above.
        above: String,
        /// Its top [m].
        limit: f64,
    },
    /// A bottom above the last top.
    #[error("`bottom` at {bottom} m does not lie below the top of the last layer at {top} m")]
    Bottom {
        /// Its level [m].
        bottom: f64,
        /// Top of the last layer [m].
        top: f64,
    },
    /// A box of other levels than the layers.
    #[error(
        "[mesh.z] has `{key}` at {value} m and [geology] at {level} m; leave it out, the box reaches as far as the layers"
    )]
    Extent {
        /// `from` or `to`.
        key: &'static str,
        /// As written [m].
        value: f64,
        /// Of the layers [m].
        level: f64,
    },
    /// Tops that cross.
    #[error(
        "at x = {} m, y = {} m {lower} at {} m lies above {upper} at {} m; tops may meet, where a layer ends, and not cross", at[0], at[1], heights[1], heights[0]
    )]
    TopsCross {
        /// The one that is written first.
        upper: String,
        /// The one that should lie below it.
        lower: String,
        /// Where they cross most [m].
        at: [f64; 2],
        /// Their heights there [m].
        heights: [f64; 2],
    },
    /// Two surfaces that the lines of a grid cannot both follow.
    #[error(
        "{first} at {:.3} m and {second} at {:.3} m come too close or cross at x = {:.3} m, y = {:.3} m: their levels of the grid are z = {:.3} m and {:.3} m, and it cannot follow both; move one of them, change a `throw`, take a smaller `size` in [mesh.z], or take a mesh from Gmsh", heights[0], heights[1], at[0], at[1], lines[0], lines[1]
    )]
    Tangled {
        /// That of the lower line.
        first: String,
        /// That of the upper one.
        second: String,
        /// Where [m].
        at: [f64; 2],
        /// Their heights there [m].
        heights: [f64; 2],
        /// Their lines [m].
        lines: [f64; 2],
    },
    /// Layers that leave the grid no height.
    #[error(
        "at x = {:.3} m, y = {:.3} m the layers are {height:.3} m thick together, too little for the cells of all of them, which keep a tenth of their height; lower `bottom` or raise the tops there", at[0], at[1]
    )]
    NoRoom {
        /// Where [m].
        at: [f64; 2],
        /// Height from the bottom to the ground [m].
        height: f64,
    },
    /// A top that climbs with the faults.
    #[error(
        "{what} is as steep as the lines of the grid that lean with faults around x = {:.3} m, y = {:.3} m; make it less steep, or raise the dips", at[0], at[1]
    )]
    Steep {
        /// Which top.
        what: String,
        /// Where [m].
        at: [f64; 2],
    },
    /// Something that needs level tops.
    #[error("{what} does not go with tops of [geology] that are not level: {why}")]
    NeedsLevel {
        /// What.
        what: String,
        /// Why, and what to do.
        why: &'static str,
    },
    /// A name that is not there.
    #[error("no {kind} is named \"{name}\"{}; there are: {}", nearest.as_ref().map_or(String::new(), |n| format!(", did you mean \"{n}\"?")), known.join(", "))]
    Unknown {
        /// Material, layer or fracture.
        kind: &'static str,
        /// As written.
        name: String,
        /// The one most like it.
        nearest: Option<String>,
        /// All of them.
        known: Vec<String>,
    },
    /// A material without a place.
    #[error(
        "material \"{name}\" fills no layer and no compartment of [geology] and has no `boxes`; give it a place or leave it out"
    )]
    Unplaced {
        /// Its name.
        name: String,
    },
    /// A layer that offsets leave nothing of.
    #[error(
        "around x = {} m, y = {} m the top of \"{name}\" lies at {top} m and its base at {base} m: the throws of faults leave nothing of it; lower a `throw`, or let its fault cut all layers that it moves", at[0], at[1]
    )]
    Eaten {
        /// Material of the layer.
        name: String,
        /// In the middle of a block [m].
        at: [f64; 2],
        /// Its top [m].
        top: f64,
        /// Its base [m].
        base: f64,
    },
    /// A layer or a fault between two grid lines.
    #[error(
        "{what} from {from} m to {to} m is thinner than a quarter of the cells and has no grid line of its own; make `size` of [mesh.z] smaller"
    )]
    Thin {
        /// Which layer or fracture.
        what: String,
        /// Lower end [m].
        from: f64,
        /// Upper end [m].
        to: f64,
    },
    /// A key of faults on something else.
    #[error(
        "fracture \"{name}\" has `{key}`, which is for fractures across x or y with `at`; leave it out"
    )]
    NoFault {
        /// Its name.
        name: String,
        /// The key.
        key: &'static str,
    },
    /// An empty list of layers.
    #[error(
        "`cuts` of fracture \"{name}\" is an empty list; name the layers that it cuts, e.g. cuts = [\"clay\"], or leave `cuts` out where it cuts all of them"
    )]
    NoCut {
        /// Its name.
        name: String,
    },
    /// A throw that moves nothing.
    #[error(
        "fracture \"{name}\" has a throw of {throw} m and moves no top: none between the top and the bottom of the box is written from {from} m to {to} m{}; let its depth range reach one, or leave `throw` out", tops.iter().map(|top| format!("{top} m")).reduce(|a, b| format!("{a}, {b}")).map_or(String::new(), |tops| format!(", they are at {tops}"))
    )]
    IdleThrow {
        /// Its name.
        name: String,
        /// As written [m].
        throw: f64,
        /// Lower end of its depth range [m].
        from: f64,
        /// Upper end [m].
        to: f64,
        /// Tops that could move [m].
        tops: Vec<f64>,
    },
    /// A throw smaller than the grid can tell.
    #[error(
        "the throw of {throw} m of fracture \"{name}\" is lost: the tops that it offsets lie on the same grid lines on both of its sides; take cells of less than {size} m in [mesh.z], or leave `throw` out"
    )]
    LostThrow {
        /// Its name.
        name: String,
        /// As written [m].
        throw: f64,
        /// Size of cells with which it is not lost [m].
        size: f64,
    },
    /// An angle too flat.
    #[error(
        "fracture \"{name}\" dips by {dip:.4} deg; the grid follows dips of 30 to 150 deg (90 is upright)"
    )]
    Dip {
        /// Its name.
        name: String,
        /// As written [deg].
        dip: f64,
    },
    /// A fault without height.
    #[error(
        "fracture \"{name}\" has no height: its depth range from {from} m to {to} m is empty; write the lower end first"
    )]
    NoHeight {
        /// Its name.
        name: String,
        /// Lower end [m].
        from: f64,
        /// Upper end [m].
        to: f64,
    },
    /// Planes that would meet.
    #[error(
        "{first} and {second}, {distance} m apart where they have their positions, come within {left:.1} m of each other at z = {level} m: the grid is sheared between them, and cannot follow planes that cross; change dips, depth ranges or positions, or take a mesh from Gmsh"
    )]
    Cross {
        /// One of them.
        first: String,
        /// The other.
        second: String,
        /// Distance as written [m].
        distance: f64,
        /// What is left of it [m]; negative beyond a crossing.
        left: f64,
        /// Where [m].
        level: f64,
    },
    /// Two planes in one place.
    #[error(
        "fractures \"{first}\" and \"{second}\" have one position and different planes; give both the same `dip` and `level`"
    )]
    SamePlace {
        /// One of them.
        first: String,
        /// The other.
        second: String,
    },
    /// A compartment between fractures that bound nothing.
    #[error(
        "`between` needs two fractures across one axis, with one position each, that differ; \"{first}\" and \"{second}\" are not"
    )]
    Between {
        /// One of them.
        first: String,
        /// The other.
        second: String,
    },
}
