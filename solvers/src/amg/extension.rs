//! The motions of an aggregate, carried on beyond it.

/// Near-null vectors B of a level and, on every aggregate, the R of `B = Q R`.
#[derive(Clone, Debug)]
pub(super) struct Extension<const K: usize> {
    /// Three rows per block row.
    pub(super) modes: Vec<[[f64; K]; 3]>,
    /// One per aggregate; a zero on the diagonal where the aggregate cannot move so.
    pub(super) bases: Vec<[[f64; K]; K]>,
}

impl<const K: usize> Extension<K> {
    /// `B_j R⁻¹`: how block row j would move with an aggregate. What the aggregate cannot do is left out.
    #[inline(always)]
    pub(super) fn at(&self, j: usize, aggregate: usize) -> [[f64; K]; 3] {
        let r = &self.bases[aggregate];
        self.modes[j].map(|mut row| {
            for c in 0..K {
                let known: f64 = (0..c).map(|i| row[i] * r[i][c]).sum();
                let scale = r[c][c];
                row[c] = if scale > 0.0 {
                    (row[c] - known) / scale
                } else {
                    0.0
                };
            }
            row
        })
    }

    /// Bytes held.
    pub(super) fn bytes(&self) -> usize {
        size_of_val(&*self.modes) + size_of_val(&*self.bases)
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::amg::tentative::orthonormalise;

    /// Two points on a line, modes 1, x and a multiple of 1; a third point beyond them.
    #[test]
    fn a_rigid_motion_goes_on_outside() {
        let mode = |x: f64| [1.0, x, 3.0];
        let mut q = [mode(1.0), mode(2.0)];
        let bases = vec![orthonormalise(&mut q)];
        let outside = mode(5.0);
        let extension = Extension {
            modes: vec![[outside; 3]],
            bases,
        };
        let [row, ..] = extension.at(0, 0);
        let r = &extension.bases[0];
        for k in 0..3 {
            let value: f64 = (0..3).map(|i| row[i] * r[i][k]).sum();
            assert!((value - outside[k]).abs() < 1e-13, "{k}: {value}");
        }
        assert_eq!(row[2], 0.0);
    }
}
