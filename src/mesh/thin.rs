//! Grids too thin for their cells.

/// Largest cell along an axis over the thickness of the body along another one, beyond which the body is thin; and largest cell over the
/// smallest along both axes beside one that a single cell spans.
///
/// A single layer of cells cannot be made coarser. Where it is flat it holds its two sides together far more than it holds neighbours apart, so
/// that smoothing along it gets nowhere. Slabs of 92 × 200 cells that are 0.5 m thick, and from 0.5 m long at a fault to r times that, take so
/// many iterations with geometric multigrid and with AMG:
///
/// | cells across | r = 30 | 100 | 300 | 1000 |
/// |---|---|---|---|---|
/// | 1 | 52, 31 | 126, 30 | > 150, 36 | > 150, 41 |
/// | 2 | 32, 32 | 59, 36 | 135, 39 | > 150, 50 |
/// | 4 | 19, 36 | 32, 40 | 54, 41 | > 150, 44 |
///
/// Unit: 1.
const THIN: f64 = 100.0;

/// True for a grid with these lines along x, y, z [m] whose largest cells are far larger than the body is thick, or that one cell spans beside cells
/// that grow.
///
/// # Cost
/// O(lines).
pub fn is_thin(lines: &[Vec<f64>; 3]) -> bool {
    let cells = |d: usize| lines[d].windows(2).map(|pair| pair[1] - pair[0]);
    let largest = |d: usize| cells(d).fold(0.0, f64::max);
    let growth = |d: usize| largest(d) / cells(d).fold(f64::INFINITY, f64::min);
    (0..3).any(|d| {
        let [e, f] = [(d + 1) % 3, (d + 2) % 3];
        let thickness: f64 = cells(d).sum();
        let is_single = cells(d).count() == 1;
        largest(e).max(largest(f)) > THIN * thickness
            || is_single && growth(e).min(growth(f)) > THIN
    })
}

#[cfg(test)]
mod tests {
    use super::*;

    fn even(cells: usize, size: f64) -> Vec<f64> {
        (0..=cells).map(|k| k as f64 * size).collect()
    }

    /// Cells from 1 m to `last`.
    fn growing(last: f64) -> Vec<f64> {
        let mut lines = vec![0.0];
        (0..=10).for_each(|k| lines.push(lines[k] + last.powf(k as f64 / 10.0)));
        lines
    }

    #[test]
    fn a_body_is_thin_beside_its_largest_cells_or_as_one_layer_of_cells_that_grow() {
        let plate = |size: f64, across: usize| [even(8, size), even(across, 1.0), even(8, size)];
        assert!(
            is_thin(&plate(200.0, 1)) && !is_thin(&plate(200.0, 2)) && !is_thin(&plate(50.0, 1))
        );
        let slab = |last: f64, across: usize| [growing(last), growing(last), even(across, 50.0)];
        assert!(is_thin(&slab(150.0, 1)) && !is_thin(&slab(150.0, 2)) && !is_thin(&slab(50.0, 1)));
        // along one axis alone they do not turn the layer into needles and plates
        assert!(!is_thin(&[growing(150.0), even(8, 1.0), even(1, 50.0)]));
        // any axis may be the thin one
        assert!(is_thin(&[even(1, 1.0), even(4, 200.0), even(4, 1.0)]));
    }
}
