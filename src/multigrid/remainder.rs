//! What of a coarse matrix is not bricks: `Σ P_eᵀ K_e P_e` of cut or mixed cells, and `Pᵀ R P` of the level above.
#![allow(unsafe_code, reason = "writes of tasks that share no entry")]

use super::coarsening::{Coarsening, for_each_fine};
use super::elements::{BrickCache, ElementBlocks, Elements};
use super::grid::{Grid, STEPS};
use super::interpolation::{Owners, weights};
use crate::elasticity::ElasticityError;
use fracas_operators::shared::Colours;
use fracas_operators::simd::{Kernel, Lanes, Level};
use fracas_operators::small::{Matrix3, add};
use fracas_operators::sparse::{Block3, Pattern, SparseRows};

/// A level and the way to the next one.
#[derive(Clone, Copy)]
pub(super) struct Step<'a> {
    pub(super) fine: &'a Grid<'a>,
    pub(super) elements: &'a Elements<'a>,
    pub(super) coarsening: &'a Coarsening,
    pub(super) owners: &'a Owners,
    /// Fixed components of the fine nodes.
    pub(super) fixed: &'a [u8],
    /// Coarse elements that are bricks.
    pub(super) kinds: &'a [u16],
}

/// Block rows under assembly, in f64 whatever the level is applied in: rounding every sum would cost a stiff body between
/// soft ones its free motions, which carry `(h/L)²/contrast` of its stiffness.
pub(super) struct Rows {
    pub(super) pattern: Pattern,
    pub(super) blocks: Vec<Matrix3<f64>>,
}

impl Rows {
    pub(super) fn new(pattern: Pattern) -> Self {
        let blocks = vec![[[0.0; 3]; 3]; pattern.columns.len()];
        Self { pattern, blocks }
    }

    /// Adds to block (row, column), which the pattern holds.
    pub(super) fn add(&mut self, row: usize, column: u32, block: &Matrix3<f64>) {
        let at = self.pattern.place(row, column);
        add(&mut self.blocks[at], 1.0, block);
    }

    /// Adds `Σ P_eᵀ K_e P_e` over the fine elements with a matrix in coarse elements that are no bricks.
    pub(super) fn add_elements(&mut self, step: Step<'_>) -> Result<(), ElasticityError> {
        let coarse = &step.coarsening.coarse;
        let layers = |from: usize| (from..coarse.cells[2]).step_by(2).collect::<Vec<_>>();
        // SAFETY: every second layer of cells has nodes, so rows, of its own.
        let colours = unsafe { Colours::new(vec![layers(0), layers(1)]) };
        let pattern = &self.pattern;
        let failed = std::sync::OnceLock::new();
        colours.run(&mut self.blocks, &|k, blocks| {
            let mut cache = BrickCache::default();
            let plane = coarse.cells[0] * coarse.cells[1];
            for cell in k * plane..(k + 1) * plane {
                for piece in coarse.elements_in(cell) {
                    if step.kinds[piece] != Elements::NONE {
                        continue;
                    }
                    let sum = match galerkin(step, cell, piece, &mut cache) {
                        Ok(sum) => sum,
                        Err(error) => {
                            let _ = failed.set(error);
                            return;
                        }
                    };
                    let corners = &coarse.elements[piece];
                    for (row, node) in sum.iter().zip(corners) {
                        let range = pattern.range(*node as usize);
                        // SAFETY: a row of this layer.
                        let to = unsafe { blocks.part(range.start, range.len()) };
                        let columns = &pattern.columns[range];
                        for (block, column) in row.iter().zip(corners) {
                            let at = columns.partition_point(|c| c < column);
                            add(&mut to[at], 1.0, block);
                        }
                    }
                }
            }
        });
        failed.into_inner().map_or(Ok(()), Err)
    }

    /// Adds `Pᵀ R P`.
    pub(super) fn add_product(&mut self, step: Step<'_>, above: &Block3<f64>) {
        let coarse = &step.coarsening.coarse;
        let mut slot = vec![u32::MAX; coarse.nodes];
        let mut columns: Vec<u32> = Vec::new();
        let mut images: Vec<Matrix3<f64>> = Vec::new();
        let parents = |node: usize| {
            let corners = coarse.elements[step.owners.element[node] as usize];
            let weights = step.owners.weights(coarse, node);
            corners.into_iter().zip(weights).filter(|(_, w)| *w != 0.0)
        };
        for i in 0..above.block_rows() {
            // (R P)_i
            for (j, block) in above.block_row(i) {
                for (column, weight) in parents(j) {
                    let slot = &mut slot[column as usize];
                    if *slot == u32::MAX {
                        *slot = columns.len() as u32;
                        columns.push(column);
                        images.push([[0.0; 3]; 3]);
                    }
                    add(&mut images[*slot as usize], weight, block);
                }
            }
            if columns.is_empty() {
                continue;
            }
            for (row, weight) in parents(i) {
                for (column, image) in columns.iter().zip(&images) {
                    self.add(
                        row as usize,
                        *column,
                        &image.map(|row| row.map(|v| weight * v)),
                    );
                }
            }
            columns.drain(..).for_each(|c| slot[c as usize] = u32::MAX);
            images.clear();
        }
    }

    /// The matrix without rows and columns of fixed components, and without blocks of zeros.
    pub(super) fn finish(mut self, fixed: &[u8]) -> Block3<f64> {
        let rows = self.pattern.rows();
        let mut kept = 0;
        let mut begin = 0;
        for i in 0..rows {
            let end = self.pattern.offsets[i + 1];
            for at in begin..end {
                let column = self.pattern.columns[at];
                let mut block = self.blocks[at];
                mask(&mut block, fixed[i], fixed[column as usize]);
                if block != [[0.0; 3]; 3] {
                    self.pattern.columns[kept] = column;
                    self.blocks[kept] = block;
                    kept += 1;
                }
            }
            begin = end;
            self.pattern.offsets[i + 1] = kept;
        }
        self.pattern.columns.truncate(kept);
        self.blocks.truncate(kept);
        // room for the zero block that a product needs
        self.blocks.shrink_to(kept + 1);
        self.pattern.columns.shrink_to_fit();
        let (pattern, values) = (self.pattern, self.blocks);
        Block3::new(SparseRows { pattern, values }, rows)
    }
}

/// `Σ P_eᵀ K_e P_e` over the fine elements in one coarse element.
fn galerkin(
    step: Step<'_>,
    cell: usize,
    piece: usize,
    cache: &mut BrickCache,
) -> Result<ElementBlocks, ElasticityError> {
    let Coarsening {
        coarse,
        parent,
        starts,
    } = step.coarsening;
    let level = Level::best();
    let mut sum = [[[[0.0; 3]; 3]; 8]; 8];
    let place = coarse.place(cell);
    let mut outcome = Ok(());
    for_each_fine(place, starts, |at| {
        for e in step.fine.elements_in(step.fine.cell(at)) {
            if parent[e] as usize != piece || !step.elements.has(e) || outcome.is_err() {
                continue;
            }
            match step.elements.matrix(step.fine, e, at, cache) {
                Err(error) => outcome = Err(error),
                Ok(mut k) => {
                    let fixed = step.fine.elements[e].map(|n| step.fixed[n as usize]);
                    if fixed != [0; 8] {
                        (0..64).for_each(|n| {
                            mask(&mut k[n / 8][n % 8], fixed[n / 8], fixed[n % 8]);
                        });
                    }
                    let w = STEPS.map(|up| {
                        let local = [0, 1, 2].map(|d: usize| at[d] - starts[d][place[d]] + up[d]);
                        weights(step.owners.shares(place, local))
                    });
                    level.run(Congruent {
                        sum: &mut sum,
                        k: &k,
                        w: &w,
                    });
                }
            }
        }
    });
    outcome.map(|()| sum)
}

/// Zeros in the rows and columns of a block whose components are fixed.
fn mask(block: &mut Matrix3<f64>, rows: u8, columns: u8) {
    if rows | columns == 0 {
        return;
    }
    for (i, row) in block.iter_mut().enumerate() {
        for (j, v) in row.iter_mut().enumerate() {
            if (rows >> i | columns >> j) & 1 == 1 {
                *v = 0.0;
            }
        }
    }
}

/// `sum ← sum + Wᵀ K W` for weights `w[fine node][coarse corner]`: the same bits on all registers.
struct Congruent<'a> {
    sum: &'a mut ElementBlocks,
    k: &'a ElementBlocks,
    w: &'a [[f64; 8]; 8],
}

impl Kernel<f64> for Congruent<'_> {
    #[inline(always)]
    fn run<L: Lanes<f64>>(self) {
        for a in 0..8 {
            // K W, one row of it
            let mut row = [0.0; 72];
            for b in 0..8 {
                let k = self.k[a][b].as_flattened();
                for c in 0..8 {
                    let w = self.w[b][c];
                    if w != 0.0 {
                        for i in 0..9 {
                            row[9 * c + i] += w * k[i];
                        }
                    }
                }
            }
            for c in 0..8 {
                let w = self.w[a][c];
                if w != 0.0 {
                    let to = self.sum[c].as_flattened_mut().as_flattened_mut();
                    for i in 0..72 {
                        to[i] += w * row[i];
                    }
                }
            }
        }
    }
}
