//! Which lines of a grid the next one keeps.
//!
//! Trilinear functions do not bend where rock changes from stiff to soft, so such planes stay lines of the coarse grids
//! as long as that leaves coarse grids at all. Fractures need no lines of their own.

use super::grid::Grid;
use crate::elasticity::Elastic;
use crate::mesh::HexMesh;

/// Ratio of shear moduli from which an interface is kept. Unit: 1.
const CONTRAST: f64 = 8.0;

/// Largest ratio of mean spacings up to which an axis is halved together with the finest one. Beyond √2 cells are nearer to cubes if only
/// the finest is: cells of 1:2 (`layered_crossing`, 64 × 32 × 32) take 16 iterations in place of 25, ν = 0.49 there 18 of 36. Unit: 1.
const SAME_SPACING: f64 = 1.5;

/// The same where interfaces leave the finest axes as they are. Unit: 1.
const SIMILAR_SPACING: f64 = 2.0;

/// Share of the cells of an axis that may remain; more is no coarsening. Unit: 1.
const REMAINING: f64 = 0.75;

/// Unknowns up to which algebraic multigrid takes over where only interfaces are left; a larger level drops them.
const HYBRID: usize = 150_000;

/// Lines of the finest grid that lie between stiff and soft rock.
#[derive(Debug)]
pub(super) struct CoarseLines {
    kept: [Vec<bool>; 3],
}

impl CoarseLines {
    pub(super) fn new(mesh: &HexMesh, materials: &[Elastic]) -> Self {
        let Some(grid) = &mesh.grid else {
            return Self {
                kept: Default::default(),
            };
        };
        let shear: Vec<f64> = materials.iter().map(Elastic::shear).collect();
        let mut kept = grid.cells.map(|n| vec![false; n + 1]);
        let low = shear.iter().copied().fold(f64::INFINITY, f64::min);
        let high = shear.iter().copied().fold(0.0, f64::max);
        if high > CONTRAST * low {
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
                        kept[d][at[d] + 1] |= a.max(b) > CONTRAST * a.min(b);
                    }
                }
            }
        }
        Self { kept }
    }

    /// The lines of the next grid, if there is one: every second one, and interfaces where that still coarsens.
    pub(super) fn next(&self, grid: &Grid<'_>) -> Option<[Vec<usize>; 3]> {
        let choose = |ratio: f64, drop: bool| {
            let halved = grid.finest_axes(ratio);
            [0, 1, 2].map(|d: usize| {
                let all = || (0..=grid.cells[d]).collect();
                if !halved[d] {
                    return all();
                }
                let kept =
                    every_second(grid.cells[d], |i| self.kept[d][grid.origin[d][i] as usize]);
                let most = REMAINING * grid.cells[d] as f64;
                // three cells become two
                if kept.len() - 1 <= (most as usize).max(grid.cells[d].div_ceil(2)) {
                    kept
                } else if drop {
                    every_second(grid.cells[d], |_| false)
                } else {
                    all()
                }
            })
        };
        let fewer = |lines: &[Vec<usize>; 3]| (0..3).any(|d| lines[d].len() <= grid.cells[d]);
        let is_large = 3 * grid.nodes > HYBRID;
        [
            (SAME_SPACING, false),
            (SIMILAR_SPACING, false),
            (SIMILAR_SPACING, true),
        ]
        .into_iter()
        .filter(|(_, drop)| is_large || !drop)
        .map(|(ratio, drop)| choose(ratio, drop))
        .find(fewer)
    }
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
