//! Lines of equal ‖(zI − T)⁻¹‖, and GMRES under its bounds.

use super::figure::{Figure, Mark, Series};
use super::{Axis, Spectrum};
use fracas_solvers::spectrum::NonNormal;
use fracas_solvers::spectrum::non_normal::Pseudospectra;
use serde::{Deserialize, Serialize};
use std::collections::BTreeMap;

/// Distance of two levels, in powers of ten.
const STEP: f64 = 0.5;

/// Most levels that are drawn, from the outermost inwards: as many as there are colours beside those of eigenvalues.
const LEVELS: usize = 5;

/// Boundaries of an ε-pseudospectrum.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Level {
    /// log₁₀ ε.
    pub log10_epsilon: f64,
    /// Lines, in both half planes.
    pub lines: Vec<Vec<[f64; 2]>>,
}

/// ‖r_k‖/‖r_0‖ of GMRES and what it can at most be.
#[derive(Clone, Debug, PartialEq, Serialize, Deserialize)]
pub struct Gmres {
    /// In which inner product.
    pub inner_product: String,
    /// That of an iteration.
    pub measured: Vec<f64>,
    /// By the resolvent on curves.
    pub resolvent: Vec<f64>,
    /// By the field of values.
    pub field_of_values: Vec<f64>,
}

impl From<&NonNormal> for Gmres {
    fn from(found: &NonNormal) -> Self {
        Self {
            inner_product: found.inner_product.to_owned(),
            measured: found.gmres.measured.clone(),
            resolvent: found.gmres.resolvent.clone(),
            field_of_values: found.gmres.field_of_values.clone(),
        }
    }
}

impl Gmres {
    /// All three over the steps.
    pub fn figure(&self, id: &str, title: &str) -> Figure {
        let caption = format!("Inner product: {}.", self.inner_product);
        let axes = (Axis::linear("step k"), Axis::log("‖r_k‖/‖r_0‖"));
        let points = |values: &[f64]| -> Vec<[f64; 2]> {
            values
                .iter()
                .enumerate()
                .map(|(k, v)| [k as f64, *v])
                .collect()
        };
        let curve = |name: &str, mark, values: &[f64]| Series::new(name, mark, points(values));
        let least = self
            .measured
            .iter()
            .copied()
            .filter(|v| *v > 0.0)
            .fold(1.0, f64::min);
        Figure::new(id, title, &caption, axes.0, axes.1.range(0.5 * least, 2.0))
            .with(curve("GMRES", Mark::LinePoints, &self.measured))
            .with(curve("bound by the resolvent", Mark::Line, &self.resolvent))
            .with(curve(
                "bound by the field of values",
                Mark::Dashed,
                &self.field_of_values,
            ))
    }
}

/// The levels of a grid, outermost first; none that closes only around the grid.
pub(super) fn levels(grid: &Pseudospectra) -> Vec<Level> {
    let top = grid.log10_epsilon.last().into_iter().flatten();
    let sides = grid
        .log10_epsilon
        .iter()
        .flat_map(|row| [row.first(), row.last()]);
    let rim = top
        .chain(sides.flatten())
        .copied()
        .fold(f64::INFINITY, f64::min);
    let least = grid
        .log10_epsilon
        .iter()
        .flatten()
        .copied()
        .fold(f64::INFINITY, f64::min);
    // lines that lie between two points of the grid have no shape
    let finest = (0.5 * (grid.re[1] - grid.re[0])).log10();
    let first = (rim / STEP).floor();
    let levels = (0..LEVELS).map(|k| (first - k as f64) * STEP);
    levels
        .filter(|level| *level > least.max(finest))
        .map(|level| Level {
            log10_epsilon: level,
            lines: lines(grid, level),
        })
        .filter(|level| !level.lines.is_empty())
        .collect()
}

/// An edge of a cell: its lower or left end, and whether it goes up.
type Edge = (usize, usize, bool);

/// Lines of one level, by the crossings of the edges of cells (marching squares), mirrored at the real axis.
fn lines(grid: &Pseudospectra, level: f64) -> Vec<Vec<[f64; 2]>> {
    let (columns, half) = (grid.re.len(), grid.im.len());
    let rows = 2 * half - 1;
    let y = |j: usize| match j < half {
        true => -grid.im[half - 1 - j],
        false => grid.im[j + 1 - half],
    };
    // −∞ at an eigenvalue
    let value = |i: usize, j: usize| grid.log10_epsilon[(half - 1).abs_diff(j)][i].max(-300.0);
    let crossing = |(i, j, up): Edge| {
        let (p, q) = if up { (i, j + 1) } else { (i + 1, j) };
        let (a, b) = (value(i, j), value(p, q));
        let share = (level - a) / (b - a);
        [
            grid.re[i] + share * (grid.re[p] - grid.re[i]),
            y(j) + share * (y(q) - y(j)),
        ]
    };
    let mut neighbours: BTreeMap<Edge, Vec<Edge>> = BTreeMap::new();
    for j in 0..rows - 1 {
        for i in 0..columns - 1 {
            let inside = |di: usize, dj: usize| value(i + di, j + dj) < level;
            let edges: [(Edge, bool); 4] = [
                ((i, j, false), inside(0, 0) != inside(1, 0)),
                ((i + 1, j, true), inside(1, 0) != inside(1, 1)),
                ((i, j + 1, false), inside(0, 1) != inside(1, 1)),
                ((i, j, true), inside(0, 0) != inside(0, 1)),
            ];
            let mut crossed: Vec<Edge> = edges.iter().filter(|e| e.1).map(|e| e.0).collect();
            // a saddle: each line goes around one of the corners that are inside
            if crossed.len() == 4 && inside(0, 0) {
                crossed.swap(1, 3);
            }
            for pair in crossed.chunks_exact(2) {
                neighbours.entry(pair[0]).or_default().push(pair[1]);
                neighbours.entry(pair[1]).or_default().push(pair[0]);
            }
        }
    }
    // ends of open lines first, then what is closed
    let ends = neighbours
        .iter()
        .filter(|(_, n)| n.len() == 1)
        .map(|(e, _)| *e);
    let starts: Vec<Edge> = ends.chain(neighbours.keys().copied()).collect();
    let mut lines = Vec::new();
    for start in starts {
        let mut line = Vec::new();
        let mut here = Some(start);
        while let Some(edge) = here {
            line.push(crossing(edge));
            let next = neighbours.get_mut(&edge).and_then(Vec::pop);
            if let Some(next) = next
                && let Some(back) = neighbours.get_mut(&next)
                && let Some(place) = back.iter().position(|e| *e == edge)
            {
                back.swap_remove(place);
            }
            here = next;
        }
        if line.len() > 1 {
            lines.push(line);
        }
    }
    lines
}

impl Spectrum {
    /// The lines of every level behind what is drawn already.
    pub(super) fn contours(&self, figure: &mut Figure) {
        if self.levels.is_empty() {
            return;
        }
        for (k, series) in figure.series.iter_mut().enumerate() {
            series.tone.get_or_insert(k);
        }
        let behind = self.levels.iter().enumerate().flat_map(|(k, level)| {
            let name = format!("ε = {}", power_of_ten(level.log10_epsilon));
            level.lines.iter().enumerate().map(move |(i, line)| {
                let name = if i == 0 { name.as_str() } else { "" };
                Series::new(name, Mark::Line, line.clone()).tone(2 + k)
            })
        });
        let mut series: Vec<Series> = behind.collect();
        figure.series.retain(|series| !series.points.is_empty());
        series.append(&mut figure.series);
        figure.series = series;
    }
}

fn power_of_ten(exponent: f64) -> String {
    let value = 10.0_f64.powf(exponent);
    match exponent.fract() == 0.0 {
        true => format!("1e{exponent}"),
        false => format!("{value:.1e}"),
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// σ = |z − 1|: the pseudospectra of the number 1.
    fn grid() -> Pseudospectra {
        let re: Vec<f64> = (0..41).map(|i| -1.0 + 0.1 * f64::from(i)).collect();
        let im: Vec<f64> = (0..21).map(|j| 0.1 * f64::from(j)).collect();
        let row = |y: &f64| re.iter().map(|x| (x - 1.0).hypot(*y).log10()).collect();
        Pseudospectra {
            log10_epsilon: im.iter().map(row).collect(),
            re,
            im,
        }
    }

    #[test]
    fn levels_of_a_distance_are_closed_circles() {
        let found = levels(&grid());
        assert_eq!(found[0].log10_epsilon, 0.0);
        assert!(found.len() >= 2);
        for level in &found[..2] {
            let radius = 10.0_f64.powf(level.log10_epsilon);
            assert_eq!(level.lines.len(), 1);
            let line = &level.lines[0];
            assert_eq!(line.first(), line.last());
            for [x, y] in line {
                let far = (x - 1.0).hypot(*y);
                assert!((far - radius).abs() < 0.03 * radius, "{far} {radius}");
            }
        }
    }

    #[test]
    fn two_eigenvalues_have_two_lines_until_they_meet() {
        let mut two = grid();
        let (re, im) = (two.re.clone(), two.im.clone());
        for (row, y) in two.log10_epsilon.iter_mut().zip(&im) {
            for (value, x) in row.iter_mut().zip(&re) {
                let far = (x - 0.5).hypot(*y).min((x - 1.5).hypot(*y));
                *value = far.log10();
            }
        }
        assert_eq!(lines(&two, -0.5).len(), 2);
        assert_eq!(lines(&two, -0.2).len(), 1);
    }
}
