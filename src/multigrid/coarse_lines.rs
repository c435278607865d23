//! Which lines of a grid the next one keeps.
//!
//! Trilinear functions do not bend where rock changes from stiff to soft, so such planes stay lines of the coarse grids
//! as long as that leaves coarse grids at all. Fractures need no lines of their own; where many
//! end at one plane in rock of several kinds, it stays a line.

use super::GridLines;
use super::grid::Grid;
use crate::elasticity::Elastic;
use crate::mesh::HexMesh;

/// Growth of what is small on graded axes, so that `left` is met to a tenth. Unit: 1.
const STEP: f64 = 1.1;

/// Columns of cells between cuts that make a plate: fewer are held by the rock around them. Unit: 1.
const PLATE: usize = 8;

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
    /// Lines at which blocks end that are cut from each other on one side.
    ends: [Vec<bool>; 3],
    /// Width up to which cells become one beside the thinnest plate between cuts [m].
    beside_plates: f64,
}

impl CoarseLines {
    /// Of the finest grid, which is that of the mesh.
    pub(super) fn new(
        rules: GridLines,
        finest: &Grid<'_>,
        mesh: &HexMesh,
        materials: &[Elastic],
    ) -> Self {
        let beside_plates = rules.flat * thinnest_plate(finest, rules.flat);
        let contrast = rules.contrast;
        let shear: Vec<f64> = materials.iter().map(Elastic::shear).collect();
        let mut interfaces = finest.cells.map(|n| vec![Stiffer::default(); n + 1]);
        let low = shear.iter().copied().fold(f64::INFINITY, f64::min);
        let high = shear.iter().copied().fold(0.0, f64::max);
        let is_layered = high > contrast * low;
        if is_layered {
            let [nx, ny, nz] = finest.cells;
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
        let ends = match is_layered && finest.nodes > finest.vertices() {
            true => ends(finest, rules.ending),
            false => finest.cells.map(|n| vec![false; n + 1]),
        };
        Self {
            rules,
            interfaces,
            ends,
            beside_plates,
        }
    }

    /// The lines of the next grid, if there is one: small neighbouring cells become one, except across interfaces where that still
    /// coarsens.
    pub(super) fn next(&self, grid: &Grid<'_>) -> Option<[Vec<usize>; 3]> {
        let fewer = |lines: &[Vec<usize>; 3]| (0..3).any(|d| lines[d].len() <= grid.cells[d]);
        let is_large = 3 * grid.nodes > self.rules.hybrid;
        let rules = &self.rules;
        let sizes = [0, 1, 2].map(|d: usize| sizes(rules, grid, d));
        let flattest = (rules.flat * self.thinnest_sheet(grid)).min(self.beside_plates);
        let small = small(rules, &sizes).min(flattest);
        let beside = (small * rules.beside_interfaces / rules.small).min(self.beside_plates);
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
            let is_end = |i: usize| self.ends[d][grid.origin[d][i] as usize];
            let is_kept = |i: usize| self.interface(grid, d, i).is_kept() || is_end(i);
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

/// Thickness [m] of the thinnest plate of the finest grid between two cuts, or a cut and the surface, beside which there are cells more than
/// `flat` times wider; infinity without one.
///
/// Its nodes are stiff across, and what bends it or strains it along itself is seen by no level on which its cells are that wide: plates of one
/// cell of 1:10 and 1:200 between two cuts took 62 and 924 iterations, with S_u factorized 13 and 16.
///
/// # Cost
/// None where no cell is that wide, else three looks at every element.
fn thinnest_plate(grid: &Grid<'_>, flat: f64) -> f64 {
    let spacings = |d: usize| (0..grid.cells[d]).map(move |i| grid.spacing(d, i));
    let widest = |d: usize| spacings(d).fold(0.0, f64::max);
    let mut thinnest = f64::INFINITY;
    for axis in 0..3 {
        let cells = grid.cells[axis];
        let beside = widest((axis + 1) % 3).max(widest((axis + 2) % 3));
        let is_plate = |thickness: f64| flat * thickness < beside;
        if !spacings(axis).any(is_plate) {
            continue;
        }
        let mut plates = Vec::new();
        for first in grid.layer(axis, 0) {
            let mut place = grid.place(first);
            let (mut thickness, mut is_cut) = (0.0, false);
            for i in 0..cells {
                place[axis] = i;
                let cell = grid.cell(place);
                thickness += grid.spacing(axis, i);
                place[axis] = i + 1;
                let is_surface = i + 1 == cells;
                if !is_surface && grid.joined(cell, grid.cell(place), axis) {
                    continue;
                }
                if is_plate(thickness) && (is_cut || !is_surface) {
                    plates.push(thickness);
                }
                (thickness, is_cut) = (0.0, true);
            }
        }
        if plates.len() >= PLATE {
            thinnest = plates.into_iter().fold(thinnest, f64::min);
        }
    }
    thinnest
}

/// Lines of the finest grid at which fractures end that cut a share of `ending` of the neighbours across an axis or more: on a coarse cell that
/// reaches beyond them all blocks are one, and stiff ones on soft rock lose what moves them against each other.
///
/// In rock of one kind `analogue_c` with 48³ cells would take 34 iterations for 51, with 24³ cells 17 for 16 and half as many operations again.
///
/// # Cost
/// Twelve looks at every element.
fn ends(grid: &Grid<'_>, ending: f64) -> [Vec<bool>; 3] {
    [0, 1, 2].map(|d: usize| {
        (0..=grid.cells[d])
            .map(|line| ending_share(grid, d, line) >= ending)
            .collect()
    })
}

/// Share of the neighbours across one of the other axes that are cut from each other on one side of a line alone, the larger of both; 0 at the
/// surface.
fn ending_share(grid: &Grid<'_>, axis: usize, line: usize) -> f64 {
    if line == 0 || line == grid.cells[axis] {
        return 0.0;
    }
    let share = |across: usize| {
        let is_cut = |mut place: [usize; 3]| {
            let low = grid.cell(place);
            place[across] += 1;
            !grid.joined(low, grid.cell(place), across)
        };
        let (mut pairs, mut ending) = (0.0_f64, 0.0);
        for cell in grid.layer(axis, line) {
            let above = grid.place(cell);
            if above[across] + 1 < grid.cells[across] {
                let mut below = above;
                below[axis] -= 1;
                pairs += 1.0;
                ending += f64::from(u8::from(is_cut(above) != is_cut(below)));
            }
        }
        ending / pairs.max(1.0)
    };
    share((axis + 1) % 3).max(share((axis + 2) % 3))
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
    // share of the cells that would be left if every small one had a neighbour, and whether an axis is halved whole
    let left = |small: f64| {
        let shares = axes.iter().map(|sizes| {
            let count = sizes.iter().filter(|h| **h <= small).count();
            1.0 - 0.5 * count as f64 / sizes.len() as f64
        });
        let whole = shares.clone().any(|share| share == 0.5);
        (shares.product::<f64>(), whole)
    };
    // isolated cells have no neighbour to become one with
    let merges = |small: f64| {
        let pair = |h: &[f64]| h[0] <= small && h[1] <= small;
        axes.iter().any(|sizes| sizes.windows(2).any(pair))
    };
    let mut small = rules.small * finest;
    while small.is_finite() {
        let (share, whole) = left(small);
        // a level that keeps a share s costs up to 1/(1 − s) cycles, functions that no level sees about small/finest times the iterations
        let enough = rules.enough.max(1.0 - finest / small);
        if whole || share <= rules.left {
            break;
        }
        if share <= enough && merges(small) && left(STEP * small).1 {
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
