//! Grid lines along one axis.

use super::error::AXES;
use super::{MeshError, SizeField};

/// How cell sizes vary along an axis.
#[derive(Clone, Debug, PartialEq)]
pub enum Grading {
    /// All equal.
    Uniform,
    /// Geometric: h_{i+1} = q h_i with q = ratio^{1/(cells−1)}, so that `ratio` = last size / first size.
    Geometric {
        /// Last size over first size.
        ratio: f64,
    },
    /// Fine at `center`, growing geometrically to both sides; `ratio` = size at the farther end / size at `center`.
    Toward {
        /// Where cells are finest; becomes a grid line [m].
        center: f64,
        /// Coarsest over finest size, at least 1.
        ratio: f64,
    },
}

/// One axis of a box.
#[derive(Clone, Debug, PartialEq)]
pub enum Axis {
    /// A number of cells between two ends.
    Cells {
        /// Start [m].
        from: f64,
        /// End [m].
        to: f64,
        /// Number of cells.
        cells: usize,
        /// Their sizes.
        grading: Grading,
    },
    /// Cells of a size in zones, growing away from them.
    Sized(SizeField),
    /// Every grid line given [m].
    Lines(Vec<f64>),
}

impl Axis {
    /// `cells` equal cells from `from` to `to` [m].
    pub fn uniform(from: f64, to: f64, cells: usize) -> Self {
        Self::Cells {
            from,
            to,
            cells,
            grading: Grading::Uniform,
        }
    }

    /// Grid lines, increasing [m]; `index` (0–2) names the axis in errors.
    ///
    /// # Errors
    /// [`MeshError`] if the axis is empty, has no cell, or cannot be graded as asked.
    pub fn lines(&self, index: usize) -> Result<Vec<f64>, MeshError> {
        let axis = AXES[index];
        let lines = match self {
            Self::Lines(lines) => lines.clone(),
            Self::Sized(field) => field.lines(index)?,
            Self::Cells { cells: 0, .. } => return Err(MeshError::NoCells { axis }),
            Self::Cells { from, to, .. } if !(to > from && (to - from).is_finite()) => {
                return Err(MeshError::EmptyAxis {
                    axis,
                    from: *from,
                    to: *to,
                });
            }
            Self::Cells {
                from,
                to,
                cells,
                grading,
            } => match grading {
                Grading::Uniform => (0..=*cells)
                    .map(|i| from + (to - from) * (i as f64 / *cells as f64))
                    .collect(),
                Grading::Geometric { ratio } => {
                    let q = growth(axis, *ratio, *cells)?;
                    stretched(*from, *to, *cells, q)
                }
                Grading::Toward { center, ratio } => {
                    toward(axis, [*from, *to], *cells, *center, *ratio)?
                }
            },
        };
        if lines.len() < 2 {
            return Err(MeshError::NoCells { axis });
        }
        for (i, pair) in lines.windows(2).enumerate() {
            if !(pair[1] > pair[0] && (pair[1] - pair[0]).is_finite()) {
                return Err(MeshError::LinesNotIncreasing {
                    axis,
                    index: i + 2,
                    value: pair[1],
                    before: pair[0],
                });
            }
        }
        Ok(lines)
    }
}

/// q with q^{cells−1} = ratio.
fn growth(axis: char, ratio: f64, cells: usize) -> Result<f64, MeshError> {
    let advice = match (ratio > 0.0 && ratio.is_finite(), cells) {
        (false, _) => "the ratio must be positive",
        (true, 1) if ratio != 1.0 => "use at least two cells",
        _ => return Ok(ratio.powf(1.0 / (cells.max(2) - 1) as f64)),
    };
    Err(MeshError::Grading {
        axis,
        ratio,
        cells,
        advice,
    })
}

/// Σ_{i<n} q^i.
fn geometric_sum(q: f64, n: usize) -> f64 {
    (0..n).fold(0.0, |sum, _| 1.0 + q * sum)
}

/// Lines from `from` to `to` whose sizes grow by q; the ends are exact.
fn stretched(from: f64, to: f64, cells: usize, q: f64) -> Vec<f64> {
    let total = geometric_sum(q, cells);
    let sums = std::iter::successors(Some(0.0), |sum| Some(1.0 + q * sum));
    let mut lines: Vec<f64> = sums
        .take(cells)
        .map(|sum| from + (to - from) * (sum / total))
        .collect();
    lines.push(to);
    lines
}

/// Both sides of `center` share the finest size h; the longer side reaches `ratio`·h, and the cells are divided so that
/// the growth of the shorter side comes nearest to that of the longer one.
fn toward(
    axis: char,
    [from, to]: [f64; 2],
    cells: usize,
    center: f64,
    ratio: f64,
) -> Result<Vec<f64>, MeshError> {
    let fail = |advice| MeshError::Grading {
        axis,
        ratio,
        cells,
        advice,
    };
    if !(ratio >= 1.0 && ratio.is_finite()) {
        return Err(fail("the ratio must be at least 1"));
    }
    if center <= from {
        return Ok(stretched(from, to, cells, growth(axis, ratio, cells)?));
    }
    if center >= to {
        return Ok(stretched(
            from,
            to,
            cells,
            1.0 / growth(axis, ratio, cells)?,
        ));
    }
    let (left, right) = (center - from, to - center);
    let (long, short) = (left.max(right), left.min(right));
    let divided = |m: usize| -> Result<_, MeshError> {
        let q_long = growth(axis, ratio, m)?;
        let h = long / geometric_sum(q_long, m);
        let q_short = solve_growth(short / h, cells - m);
        Ok(((q_short / q_long).ln(), m, q_long, q_short))
    };
    if cells < 3 {
        return Err(fail("use at least three cells"));
    }
    // the more cells the longer side has, the slower they grow there and the faster on the other one
    let (mut low, mut high) = (2, cells - 1);
    while low < high {
        let m = low.midpoint(high);
        match divided(m)?.0 < 0.0 {
            true => low = m + 1,
            false => high = m,
        }
    }
    let (last, first) = (divided(low)?, divided((low - 1).max(2))?);
    let (_, m, q_long, q_short) = match first.0.abs() <= last.0.abs() {
        true => first,
        false => last,
    };
    let (n_left, q_left, q_right) = match left >= right {
        true => (m, q_long, q_short),
        false => (cells - m, q_short, q_long),
    };
    let mut lines = stretched(from, center, n_left, 1.0 / q_left);
    lines.extend_from_slice(&stretched(center, to, cells - n_left, q_right)[1..]);
    Ok(lines)
}

/// q with Σ_{i<n} q^i = total, by bisection on ln q.
fn solve_growth(total: f64, n: usize) -> f64 {
    if n == 1 {
        return total; // a single cell: its size is the whole mismatch
    }
    let (mut low, mut high) = (-20.0f64, 20.0f64);
    for _ in 0..200 {
        let middle = 0.5 * (low + high);
        if middle == low || middle == high {
            break;
        }
        match geometric_sum(middle.exp(), n) < total {
            true => low = middle,
            false => high = middle,
        }
    }
    low.exp()
}

#[cfg(test)]
mod tests {
    use super::*;
    use fracas_operators::random::signed;

    fn cells(from: f64, to: f64, cells: usize, grading: Grading) -> Axis {
        Axis::Cells {
            from,
            to,
            cells,
            grading,
        }
    }

    #[test]
    fn geometric_sizes_have_the_ratio() {
        let x = cells(1.0, 3.0, 5, Grading::Geometric { ratio: 16.0 })
            .lines(0)
            .unwrap();
        let h: Vec<f64> = x.windows(2).map(|p| p[1] - p[0]).collect();
        approx::assert_relative_eq!(h[4] / h[0], 16.0, max_relative = 1e-12);
        approx::assert_relative_eq!(h[2] / h[1], 2.0, max_relative = 1e-12);
        assert_eq!((x[0], x[5]), (1.0, 3.0));
    }

    #[test]
    fn toward_has_its_center_as_a_line_and_the_ratio_on_the_longer_side() {
        let x = cells(
            -4.0,
            10.0,
            24,
            Grading::Toward {
                center: 0.5,
                ratio: 20.0,
            },
        )
        .lines(1)
        .unwrap();
        assert_eq!(x.len(), 25);
        let at = x.iter().position(|v| *v == 0.5).unwrap();
        let h: Vec<f64> = x.windows(2).map(|p| p[1] - p[0]).collect();
        approx::assert_relative_eq!(h[23] / h[at], 20.0, max_relative = 1e-9);
        approx::assert_relative_eq!(h[at - 1], h[at], max_relative = 1e-9);
        assert!(h.iter().all(|v| *v > 0.0));
    }

    /// The division between both sides is the best of all, and lines are their sums, for seeded axes.
    #[test]
    fn no_other_division_has_a_growth_that_is_nearer() {
        let uniform = |k: u64| 0.5 * (1.0 + signed(k));
        for case in 0..60 {
            let count = 3 + (40.0 * uniform(5 * case)) as usize;
            let center = 0.05 + 0.9 * uniform(5 * case + 1);
            let ratio = 1.0 + 10.0f64.powf(3.0 * uniform(5 * case + 2));
            let toward = Grading::Toward { center, ratio };
            let x = cells(0.0, 1.0, count, toward).lines(0).unwrap();
            let (long, short) = (center.max(1.0 - center), center.min(1.0 - center));
            let mismatch = |m: usize| {
                let q = growth('x', ratio, m).unwrap();
                let h = long / geometric_sum(q, m);
                (solve_growth(short / h, count - m) / q).ln().abs()
            };
            let best = (2..count).min_by(|a, b| mismatch(*a).total_cmp(&mismatch(*b)));
            let at = x.iter().position(|v| *v == center).unwrap();
            let long_side = if center >= 0.5 { at } else { count - at };
            assert_eq!(Some(long_side), best, "case {case}");
        }
    }

    #[test]
    fn bad_axes_are_named() {
        let text = |a: Axis| a.lines(2).unwrap_err().to_string();
        assert_eq!(
            text(Axis::uniform(1.0, 1.0, 2)),
            "axis z: from 1 m to 1 m is empty; `to` must be greater than `from`"
        );
        assert_eq!(
            text(Axis::uniform(0.0, 1.0, 0)),
            "axis z has no cell; give at least one"
        );
        assert!(
            text(Axis::Lines(vec![0.0, 2.0, 2.0])).contains("line 3 at 2 m does not lie beyond")
        );
        assert!(text(Axis::Lines(vec![0.0])).contains("no cell"));
        assert!(
            text(cells(0.0, 1.0, 1, Grading::Geometric { ratio: 2.0 }))
                .contains("at least two cells")
        );
        assert!(
            text(cells(0.0, 1.0, 4, Grading::Geometric { ratio: -2.0 }))
                .contains("must be positive")
        );
        assert!(
            text(cells(
                0.0,
                1.0,
                4,
                Grading::Toward {
                    center: 0.5,
                    ratio: 0.5
                }
            ))
            .contains("at least 1")
        );
        assert!(
            text(cells(
                0.0,
                1.0,
                2,
                Grading::Toward {
                    center: 0.5,
                    ratio: 2.0
                }
            ))
            .contains("at least three")
        );
    }
}
