//! Where unknowns live.

/// Where a displacement unknown lives: position in metres and component 0–2.
#[derive(Clone, Copy, Debug, PartialEq)]
pub struct DofCoordinate {
    /// Position of the node, in metres.
    pub position: [f64; 3],
    /// Direction x, y, z = 0, 1, 2.
    pub component: u8,
}
