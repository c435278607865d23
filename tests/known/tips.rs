//! Cells of the crack scenes that grow away from the tips.

/// Overrides of the axes of a mesh: cells of s²/2 m at its fine places that grow by e^s, so that twice as many of them resolve
/// the square root at a tip twice as well.
pub(crate) fn fine_tips(axes: &[&str], s: f64) -> Vec<String> {
    let of = |axis: &&str| {
        [
            format!("mesh.{axis}.size={} m", 0.5 * s * s),
            format!("mesh.{axis}.growth={}", s.exp()),
        ]
    };
    axes.iter().flat_map(of).collect()
}
