//! What can be wrong with a mesh or its materials.

use super::element::Inverted;

/// A mesh from which no stiffness can be computed.
#[derive(Clone, Debug, PartialEq, thiserror::Error)]
pub enum ElasticityError {
    /// An element folds over.
    #[error("element {element} near ({:.6e}, {:.6e}, {:.6e}) m is inverted: {source}", center[0], center[1], center[2])]
    Inverted {
        /// The element.
        element: usize,
        /// Mean of its corners [m].
        center: [f64; 3],
        /// Where it folds.
        source: Inverted,
    },
    /// A region without a material.
    #[error("element {element} lies in region {region}, but only {materials} materials are given")]
    NoMaterial {
        /// The element.
        element: usize,
        /// Its region.
        region: usize,
        /// Materials given.
        materials: usize,
    },
    /// An element that is not where the structured numbering of an axis-aligned grid puts it.
    #[error("element {element} is not a brick of an axis-aligned grid")]
    NotBricks {
        /// The first such element.
        element: usize,
    },
}
