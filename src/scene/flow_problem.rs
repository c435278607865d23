//! What can be wrong with a fluid and what drives it.

/// A fluid, or a source, that makes no sense.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum FlowProblem {
    /// Nothing to flow in.
    #[error("[fluid] has no fracture to flow in; give a [[fracture]], or leave the section out")]
    NoFracture,
    /// Heights that gravity does not go along.
    #[error(
        "[gravity] acts along z alone beside a [fluid] with a `density`, whose `reference` and `level` are heights; turn the scene, or leave the density out"
    )]
    TiltedGravity,
    /// Two meanings of pressure.
    #[error(
        "fracture \"{name}\" has a `pressure`, which nothing would change, beside [fluid], in which pressures are unknown; give `initial_pressure`, or a [[source]] with a pressure"
    )]
    FixedPressure {
        /// Its name.
        name: String,
    },
    /// A direction that the plane of a face does not have.
    #[error(
        "fracture \"{name}\" has no `direction` in its face at ({:.6}, {:.6}, {:.6}) m, which the given one meets at a right angle; give one that lies in the fracture",
        center[0], center[1], center[2]
    )]
    NoDirection {
        /// Its name.
        name: String,
        /// Centre of the face [m].
        center: [f64; 3],
    },
    /// Not a direction.
    #[error(
        "fracture \"{name}\" has a `direction` of zero length or of what is no number; give e.g. [0.0, 0.0, 1.0]"
    )]
    ZeroDirection {
        /// Its name.
        name: String,
    },
    /// A source of a fracture that is not there.
    #[error("no fracture is named \"{name}\"{}; there are: {}", nearest.as_ref().map_or(String::new(), |n| format!(", did you mean \"{n}\"?")), known.join(", "))]
    UnknownFracture {
        /// As written.
        name: String,
        /// The one most like it.
        nearest: Option<String>,
        /// All of them.
        known: Vec<String>,
    },
    /// A point beside the fracture.
    #[error(
        "no face of fracture \"{name}\" holds the point ({:.6}, {:.6}, {:.6}) m; the centre of the nearest face is ({:.6}, {:.6}, {:.6}) m",
        point[0], point[1], point[2], nearest[0], nearest[1], nearest[2]
    )]
    NoFace {
        /// Its name.
        name: String,
        /// The point [m].
        point: [f64; 3],
        /// Centre of the nearest face [m].
        nearest: [f64; 3],
    },
    /// An edge where the fracture has none.
    #[error(
        "no outer edge of fracture \"{name}\" lies along its side {side}: it is normal to that axis, or ends there in a point; give another side"
    )]
    NoEdge {
        /// Its name.
        name: String,
        /// As written.
        side: &'static str,
    },
    /// A point and an edge.
    #[error("{name} has both `at` and `edge`; give one of them, or neither for the whole fracture")]
    FaceAndEdge {
        /// Which.
        name: String,
    },
    /// A name that cannot head a column.
    #[error(
        "\"{name}\" cannot be the name of a well: names are of letters, digits, `_` and `-`, each well has its own"
    )]
    WellName {
        /// As written.
        name: String,
    },
    /// A limit without a rate.
    #[error(
        "[[well]] \"{name}\" has a `limit` beside `pressure`, which needs none; give it with `rate`"
    )]
    LimitedPressure {
        /// Which.
        name: String,
    },
    /// A well of no width.
    #[error("[[well]] \"{name}\" has a radius of {radius} m; give a `radius` above 0")]
    NoRadius {
        /// Which.
        name: String,
        /// As written [m].
        radius: f64,
    },
    /// A well that is a point.
    #[error("[[well]] \"{name}\" goes from a point to the same point; give two ends")]
    ShortWell {
        /// Which.
        name: String,
    },
    /// A well along a fracture.
    #[error(
        "[[well]] \"{name}\" lies in fracture \"{fracture}\" around ({:.6}, {:.6}, {:.6}) m, where a well has to cut through; turn it out of the plane, or give a [[source]] to the face it reaches",
        center[0], center[1], center[2]
    )]
    WellInPlane {
        /// Which.
        name: String,
        /// The fracture that it lies in.
        fracture: String,
        /// Centre of a face that it runs along [m].
        center: [f64; 3],
    },
    /// A well wider than the faces it cuts.
    #[error(
        "[[well]] \"{name}\" has a radius of {radius} m where the faces that it cuts resolve less than {most:.3} m; give a smaller `radius`"
    )]
    WideWell {
        /// Which.
        name: String,
        /// Its radius [m].
        radius: f64,
        /// Equivalent radius of a face [m].
        most: f64,
    },
    /// A well beside the fractures.
    #[error(
        "[[well]] \"{name}\" cuts no fracture; the nearest is \"{nearest}\", with the centre of a face at ({:.6}, {:.6}, {:.6}) m",
        center[0], center[1], center[2]
    )]
    NothingCut {
        /// Which.
        name: String,
        /// The fracture nearest to it.
        nearest: String,
        /// Centre of its nearest face [m].
        center: [f64; 3],
    },
    /// A rate on an edge.
    #[error(
        "{name} gives a rate to an edge, which takes pressures alone; give `at`, a point on a face, or neither for the whole fracture"
    )]
    RateOnEdge {
        /// Which.
        name: String,
    },
    /// Two conditions at one place.
    #[error(
        "the pressure of this [[source]] meets the {other} of [[source]] number {number} at ({:.6}, {:.6}, {:.6}) m on fracture \"{name}\"; a face takes one pressure, or rates alone",
        center[0], center[1], center[2]
    )]
    TwoOnOne {
        /// Its name.
        name: String,
        /// Of the face or edge [m].
        center: [f64; 3],
        /// `rate` or `pressure`.
        other: &'static str,
        /// The other source, from 1.
        number: usize,
    },
}
