//! Fractures that are rectangles of grid faces.

use std::collections::HashMap;

use super::error::AXES;
use super::{Cut, MeshError};

/// The rectangle `axis = at`, spanned on the other two axes, of a box grid.
#[derive(Clone, Debug, PartialEq)]
pub struct PlaneFracture {
    /// Its name.
    pub name: String,
    /// Normal axis (0–2).
    pub axis: usize,
    /// Position along it, before any map [m].
    pub at: f64,
    /// Spans [from, to] per axis [m]; `None` = the full width. The entry of the normal axis is not read.
    pub spans: [Option<[f64; 2]>; 3],
    /// The normal points along −axis instead of +axis.
    pub flip: bool,
}

impl PlaneFracture {
    /// A through-going fracture with its normal along +axis.
    pub fn through(name: &str, axis: usize, at: f64) -> Self {
        Self {
            name: name.into(),
            axis,
            at,
            spans: [None; 3],
            flip: false,
        }
    }

    /// Index of the grid line at `value`, to 1e-6 of the adjacent cell.
    fn line(&self, lines: &[f64], axis: usize, value: f64) -> Result<usize, MeshError> {
        let last = lines.len() - 1;
        let cell = lines.partition_point(|x| *x <= value).clamp(1, last);
        let (below, above) = (lines[cell - 1], lines[cell]);
        let tolerance = 1e-6 * (above - below);
        if (value - below).abs() <= tolerance {
            return Ok(cell - 1);
        }
        if (value - above).abs() <= tolerance {
            return Ok(cell);
        }
        Err(
            match value < lines[0] || value > lines[last] || value.is_nan() {
                true => MeshError::OutsideBox {
                    fracture: self.name.clone(),
                    axis: AXES[axis],
                    value,
                    from: lines[0],
                    to: lines[last],
                },
                false => MeshError::OffGrid {
                    fracture: self.name.clone(),
                    axis: AXES[axis],
                    value,
                    below,
                    above,
                },
            },
        )
    }

    /// Line index on the normal axis and cell ranges on the others: the box of cells on the + axis side of the plane.
    ///
    /// # Errors
    /// [`MeshError`] if the rectangle is off the grid, outside, on the boundary or empty.
    pub fn select(&self, lines: &[Vec<f64>; 3]) -> Result<[std::ops::Range<usize>; 3], MeshError> {
        let at = self.line(&lines[self.axis], self.axis, self.at)?;
        if at == 0 || at == lines[self.axis].len() - 1 {
            return Err(MeshError::OnBoundary {
                fracture: self.name.clone(),
                axis: AXES[self.axis],
                value: self.at,
            });
        }
        let mut ranges = [0..0, 0..0, 0..0];
        for d in 0..3 {
            ranges[d] = match (d == self.axis, self.spans[d]) {
                (true, _) => at..at + 1,
                (false, None) => 0..lines[d].len() - 1,
                (false, Some([from, to])) => {
                    let range = self.line(&lines[d], d, from)?..self.line(&lines[d], d, to)?;
                    if range.is_empty() {
                        return Err(MeshError::SelectsNothing {
                            fracture: self.name.clone(),
                            axis: AXES[d],
                            from,
                            to,
                        });
                    }
                    range
                }
            };
        }
        Ok(ranges)
    }
}

/// Faces to cut, fracture by fracture, each in lexicographic order of its cells.
///
/// # Errors
/// [`MeshError`] if a fracture is misplaced or two of them share a face.
pub(super) fn cuts(
    lines: &[Vec<f64>; 3],
    fractures: &[PlaneFracture],
) -> Result<Vec<Cut>, MeshError> {
    let n = [0, 1, 2].map(|d: usize| lines[d].len() - 1);
    let stride = [1, n[0], n[0] * n[1]];
    let mut owner: HashMap<(usize, usize), usize> = HashMap::new();
    let mut cuts = Vec::new();
    for (index, fracture) in fractures.iter().enumerate() {
        let [rx, ry, rz] = fracture.select(lines)?;
        let axis = fracture.axis;
        for k in rz {
            for j in ry.clone() {
                for i in rx.clone() {
                    let above = i + stride[1] * j + stride[2] * k;
                    if let Some(first) = owner.insert((axis, above), index) {
                        let mut center = [(0, i), (1, j), (2, k)]
                            .map(|(d, c): (usize, usize)| 0.5 * (lines[d][c] + lines[d][c + 1]));
                        center[axis] = fracture.at;
                        return Err(MeshError::Overlap {
                            first: fractures[first].name.clone(),
                            second: fracture.name.clone(),
                            center,
                        });
                    }
                    let lower = ((above - stride[axis]) as u32, 2 * axis as u8 + 1);
                    let upper = (above as u32, 2 * axis as u8);
                    let (minus, plus) = match fracture.flip {
                        false => (lower, upper),
                        true => (upper, lower),
                    };
                    cuts.push(Cut {
                        fracture: index as u16,
                        minus,
                        plus,
                    });
                }
            }
        }
    }
    Ok(cuts)
}

#[cfg(test)]
mod tests {
    use super::*;

    fn lines() -> [Vec<f64>; 3] {
        [
            vec![0.0, 1.0, 2.0, 4.0],
            vec![0.0, 1.0, 2.0],
            vec![-1.0, 0.0, 1.0],
        ]
    }

    fn refused(fracture: PlaneFracture) -> String {
        cuts(&lines(), &[fracture]).unwrap_err().to_string()
    }

    #[test]
    fn misplaced_fractures_are_refused() {
        let at = |x| PlaneFracture::through("F", 0, x);
        assert_eq!(
            refused(at(2.5)),
            "fracture \"F\": x = 2.5 m is not a grid line; the nearest are 2 m and 4 m"
        );
        assert_eq!(
            refused(at(5.0)),
            "fracture \"F\" leaves the box: x = 5 m is outside [0 m, 4 m]"
        );
        assert_eq!(
            refused(at(4.0)),
            "fracture \"F\" lies on the boundary x = 4 m of the box, where there is rock on one side only; move it inside"
        );
        assert!(refused(at(f64::NAN)).contains("leaves the box"));
        let mut span = at(1.0);
        span.spans[1] = Some([1.0, 1.0]);
        assert_eq!(
            refused(span.clone()),
            "fracture \"F\" selects no face: its span in y from 1 m to 1 m is empty"
        );
        span.spans[1] = Some([0.0, 3.0]);
        assert!(refused(span.clone()).contains("y = 3 m is outside [0 m, 2 m]"));
        span.spans[1] = Some([0.0, 1.25]);
        assert!(
            refused(span).contains("y = 1.25 m is not a grid line; the nearest are 1 m and 2 m")
        );
    }

    #[test]
    fn two_fractures_on_one_face_are_named_with_the_place() {
        let mut part = PlaneFracture::through("G", 0, 1.0);
        part.spans[2] = Some([0.0, 1.0]);
        let error = cuts(&lines(), &[PlaneFracture::through("F", 0, 1.0), part]).unwrap_err();
        assert_eq!(
            error.to_string(),
            "fractures \"F\" and \"G\" share the face at (1.000000, 0.500000, 0.500000) m; let one of them end where the other begins"
        );
    }
}
