//! Which lines of a grid the next one keeps.
//!
//! Trilinear functions do not bend where rock changes from stiff to soft, so such planes stay lines of the coarse grids
//! as long as that leaves coarse grids at all. Fractures need no lines of their own.

use super::GridLines;
use super::grid::Grid;
use crate::elasticity::Elastic;
use crate::mesh::HexMesh;

/// Growth of what is small on graded axes, so that `left` is met to a tenth. Unit: 1.
const STEP: f64 = 1.1;

/// Cells w times wider than the finest are halved whole where more than `1 − WORTH/w` of the cells would be left without them. A level
/// that keeps a share s of the cells costs up to `1/(1 − s)` cycles; functions that no level sees cost about w times the iterations.
/// Plates of two cells, 1:10 on the axis next in width, took 67 iterations, and take 16. Unit: 1.
const WORTH: f64 = 2.0;

/// Where the stiffer rock of an interface lies.
#[derive(Clone, Copy, Debug, Default, PartialEq, Eq)]
struct Stiffer {
    below: bool,
    above: bool,
}

impl Stiffer {
    /// Whether there is an interface.
    fn is_kept(self) -> bool {
        self.below || self.above
    }
}

/// Lines of the finest grid that lie between stiff and soft rock.
#[derive(Debug)]
pub(super) struct CoarseLines {
    rules: GridLines,
    interfaces: [Vec<Stiffer>; 3],
}

impl CoarseLines {
    pub(super) fn new(rules: GridLines, mesh: &HexMesh, materials: &[Elastic]) -> Self {
        let contrast = rules.contrast;
        let Some(grid) = &mesh.grid else {
            return Self {
                rules,
                interfaces: Default::default(),
            };
        };
        let shear: Vec<f64> = materials.iter().map(Elastic::shear).collect();
        let mut interfaces = grid.cells.map(|n| vec![Stiffer::default(); n + 1]);
        let low = shear.iter().copied().fold(f64::INFINITY, f64::min);
        let high = shear.iter().copied().fold(0.0, f64::max);
        if high > contrast * low {
            let [nx, ny, nz] = grid.cells;
            let steps = [1, nx, nx * ny];
            for (e, region) in mesh.regions.iter().enumerate() {
                let at = [e % nx, e / nx % ny, e / (nx * ny)];
                for d in 0..3 {
                    if at[d] + 1 < [nx, ny, nz][d] {
                        let (a, b) = (
                            shear[usize::from(*region)],
                            shear[usize::from(mesh.regions[e + steps[d]])],
                        );
                        let interface = &mut interfaces[d][at[d] + 1];
                        interface.below |= a > contrast * b;
                        interface.above |= b > contrast * a;
                    }
                }
            }
        }
        Self { rules, interfaces }
    }

    /// The lines of the next grid, if there is one: small neighbouring cells become one, except across interfaces where that still
    /// coarsens.
    pub(super) fn next(&self, grid: &Grid<'_>) -> Option<[Vec<usize>; 3]> {
        let fewer = |lines: &[Vec<usize>; 3]| (0..3).any(|d| lines[d].len() <= grid.cells[d]);
        let is_large = 3 * grid.nodes > self.rules.hybrid;
        let rules = &self.rules;
        let sizes = [0, 1, 2].map(|d: usize| sizes(rules, grid, d));
        let small = small(rules, &sizes).min(rules.flat * self.thinnest_sheet(grid));
        let beside = small * rules.beside_interfaces / rules.small;
        [(small, false), (beside, false), (beside, true)]
            .into_iter()
            .filter(|(_, drop)| is_large || !drop)
            .map(|(small, drop)| self.lines(grid, &sizes, small, drop))
            .find(fewer)
    }

    /// The interface on a line of a grid.
    fn interface(&self, grid: &Grid<'_>, axis: usize, line: usize) -> Stiffer {
        self.interfaces[axis][grid.origin[axis][line] as usize]
    }

    /// Thickness [m] of the thinnest cell that is stiffer than what is on both sides of it, or infinity.
    fn thinnest_sheet(&self, grid: &Grid<'_>) -> f64 {
        let of_axis = |d: usize| {
            let cells = grid.cells[d];
            let is_sheet = |i: usize| {
                let below = i == 0 || self.interface(grid, d, i).above;
                let above = i + 1 == cells || self.interface(grid, d, i + 1).below;
                cells > 1 && below && above
            };
            let sheets = (0..cells).filter(move |i| is_sheet(*i));
            sheets.fold(f64::INFINITY, |h, i| h.min(grid.spacing(d, i)))
        };
        (0..3).map(of_axis).fold(f64::INFINITY, f64::min)
    }

    /// The lines that are left where cells whose `sizes` are up to `small` become one with their neighbours, across interfaces if
    /// these are to `drop`.
    fn lines(
        &self,
        grid: &Grid<'_>,
        sizes: &[Vec<f64>; 3],
        small: f64,
        drop: bool,
    ) -> [Vec<usize>; 3] {
        [0, 1, 2].map(|d: usize| {
            let cells = grid.cells[d];
            let is_small = |i: usize| sizes[d][i] <= small;
            let apart = |i: usize| !(is_small(i - 1) && is_small(i));
            let free = every_second(cells, apart);
            if drop {
                return free;
            }
            let is_kept = |i: usize| self.interface(grid, d, i).is_kept();
            let kept = every_second(cells, |i| apart(i) || is_kept(i));
            let gone = |lines: &[usize]| cells + 1 - lines.len();
            if 2 * gone(&kept) >= gone(&free) {
                kept
            } else {
                (0..=cells).collect()
            }
        })
    }
}

/// Sizes of the cells of an axis [m], all of them their mean where they differ little.
fn sizes(rules: &GridLines, grid: &Grid<'_>, axis: usize) -> Vec<f64> {
    let mut sizes: Vec<f64> = (0..grid.cells[axis])
        .map(|i| grid.spacing(axis, i))
        .collect();
    let (finest, widest) = sizes
        .iter()
        .fold((f64::INFINITY, 0.0_f64), |(a, b), h| (a.min(*h), b.max(*h)));
    if widest <= rules.alike * finest {
        let mean = sizes.iter().sum::<f64>() / sizes.len() as f64;
        sizes.fill(mean);
    }
    sizes
}

/// The length [m] up to which cells are small, from the sizes of the cells of each axis; a single cell has no neighbour.
fn small(rules: &GridLines, sizes: &[Vec<f64>; 3]) -> f64 {
    let axes: Vec<&Vec<f64>> = sizes.iter().filter(|sizes| sizes.len() > 1).collect();
    let all = axes.iter().copied().flatten().copied();
    let finest = all.fold(f64::INFINITY, f64::min);
    // share of the cells that would be left, and whether an axis is halved whole
    let left = |small: f64| {
        let shares = axes.iter().map(|sizes| {
            let count = sizes.iter().filter(|h| **h <= small).count();
            1.0 - 0.5 * count as f64 / sizes.len() as f64
        });
        let whole = shares.clone().any(|share| share == 0.5);
        (shares.product::<f64>(), whole)
    };
    let mut small = rules.small * finest;
    while small.is_finite() {
        let (share, whole) = left(small);
        let enough = rules.enough.max(1.0 - WORTH * finest / small);
        if whole || share <= rules.left || (share <= enough && left(STEP * small).1) {
            break;
        }
        small *= STEP;
    }
    small
}

/// Every second line, and those that are kept; cells of one or two fine cells.
fn every_second(cells: usize, kept: impl Fn(usize) -> bool) -> Vec<usize> {
    let mut lines = vec![0];
    let mut at = 0;
    while at < cells {
        at = if at + 1 == cells || kept(at + 1) {
            at + 1
        } else {
            at + 2
        };
        lines.push(at);
    }
    lines
}
