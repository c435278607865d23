//! What can be wrong with fields of pressure and the layers that one diffuses into.

/// A field of pressure that makes no sense.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum PoreProblem {
    /// The file cannot be read.
    #[error("cannot read {file}: {reason}")]
    Unreadable {
        /// The file.
        file: String,
        /// Why.
        reason: String,
    },
    /// Another kind of file, or a damaged one.
    #[error("{file} is no unstructured grid of VTK that can be read: {reason}")]
    Grid {
        /// The file.
        file: String,
        /// What is wrong.
        reason: String,
    },
    /// Data that another program than zlib has compressed.
    #[error(
        "{file} is compressed ({compressor}), and only zlib is read; save it with zlib or as it is: in ParaView and VTK `CompressorType` ZLib or None, in meshio `compression=\"zlib\"`"
    )]
    Compressed {
        /// The file.
        file: String,
        /// As it says.
        compressor: String,
    },
    /// An array that is not there.
    #[error("{file} has no array `{array}` of cells or points; it has: {}", known.join(", "))]
    NoArray {
        /// The file.
        file: String,
        /// As asked for.
        array: String,
        /// Its arrays.
        known: Vec<String>,
    },
    /// One name for cells and for points.
    #[error("{file} has an array `{array}` of cells and one of points; leave one of them out")]
    TwoArrays {
        /// The file.
        file: String,
        /// Their name.
        array: String,
    },
    /// A number that is no pressure, or no coordinate.
    #[error("{file}, {place}: {what} is {value}; {advice}")]
    Value {
        /// The file.
        file: String,
        /// Cell, point or row.
        place: String,
        /// Which number.
        what: String,
        /// As it is there.
        value: f64,
        /// What to do.
        advice: &'static str,
    },
    /// A unit that is none of pressure.
    #[error("`unit` of the array: {reason}")]
    Unit {
        /// Why.
        reason: String,
    },
    /// Two pressures at one place.
    #[error(
        "{file}: {first} and {second} both lie at ({:.6}, {:.6}, {:.6}) m and differ in pressure; leave one of them out", at[0], at[1], at[2]
    )]
    SamePlace {
        /// The file.
        file: String,
        /// Cell, point or row.
        first: String,
        /// The other.
        second: String,
        /// Where [m].
        at: [f64; 3],
    },
    /// No point at all.
    #[error("{file} has no point; give one at least")]
    NoPoint {
        /// The file.
        file: String,
    },
    /// Linear values between points that are no lattice.
    #[error(
        "{file}: `interpolation = \"linear\"` needs a full lattice, and {what} ({points}) are none; leave the key out for the cell that holds an element, or the nearest point"
    )]
    NoLattice {
        /// The file.
        file: String,
        /// Centres of cells, or points.
        what: &'static str,
        /// How many there are.
        points: usize,
    },
    /// An element without data.
    #[error(
        "element {element} of material \"{name}\" around ({:.6}, {:.6}, {:.6}) m is {distance:.6} m from the points of {file}, beyond {bound:.6} m; give points that reach it, or a larger `within`", center[0], center[1], center[2]
    )]
    Far {
        /// Number of the element, from 0.
        element: usize,
        /// Its material.
        name: String,
        /// Its centre [m].
        center: [f64; 3],
        /// From the points [m].
        distance: f64,
        /// The bound [m].
        bound: f64,
        /// The file.
        file: String,
    },
    /// Files that have changed.
    #[error(
        "the files of `pore_pressure` of material \"{name}\" are not those that `digest` was taken of ({digest}, now {found}); bring them back, or leave `digest` out"
    )]
    Changed {
        /// The material.
        name: String,
        /// As written.
        digest: String,
        /// Of the files as they are.
        found: String,
    },
    /// A layer of no one thickness.
    #[error(
        "`drawdown` of material \"{name}\" needs the layer that it diffuses into, and the boxes of the material {}; give its bottom and top, e.g. z = [\"-250 m\", \"-200 m\"], and a material to each block of another depth", found.map_or("have no z in common".to_owned(), |[a, b]| format!("reach from {} m to {} m and elsewhere", a, b))
    )]
    NoLayer {
        /// The material.
        name: String,
        /// z of its first box [m].
        found: Option<[f64; 2]>,
    },
    /// An element that reaches out of it.
    #[error(
        "element {element} of material \"{name}\" around ({:.6}, {:.6}, {:.6}) m reaches from z = {} m to {} m, out of the layer from {} m to {} m; give the layer as `z` of `drawdown`, and a material to each block of another depth", center[0], center[1], center[2], reach[0], reach[1], layer[0], layer[1]
    )]
    OutOfLayer {
        /// Number of the element, from 0.
        element: usize,
        /// Its material.
        name: String,
        /// Its centre [m].
        center: [f64; 3],
        /// Its lowest and highest z [m].
        reach: [f64; 2],
        /// That of the layer [m].
        layer: [f64; 2],
    },
}
