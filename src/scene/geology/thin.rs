//! Layers that end: where two tops come too close for the cells between them.

use super::blocks::ThinCell;
use super::columns::{Columns, within};
use super::lifts::Stations;
use super::remarks::Remark;
use crate::scene::located::Located;

/// Share of the height that the grid leaves a layer below which its cells take another material: a wedge then keeps its volume. Unit: 1.
const HALF: f64 = 0.5;

/// Numbers of the layers that are thinner somewhere than the grid leaves them; tops are straight between `lines`.
pub(super) fn layers(columns: &Columns, lines: &[Vec<f64>; 2]) -> Result<Vec<usize>, Located> {
    let count = columns.layers.names.len();
    let mut found = vec![false; count];
    let rounding = columns.layers.rounding();
    for block in 0..columns.blocks.count() {
        let rectangle = columns.blocks.rectangle(block);
        let [x, y] = [0, 1].map(|d: usize| within(&lines[d], rectangle[d]));
        for point in y.iter().flat_map(|y| x.iter().map(|x| [*x, *y])) {
            let heights = columns.written(block, point)?;
            for (k, found) in found.iter_mut().enumerate() {
                let thickness = heights[k] - heights[k + 1];
                *found |= thickness < columns.least(block, k) - rounding;
            }
        }
    }
    Ok((0..count).filter(|k| found[*k]).collect())
}

/// Columns of cells of every block in which layers are thin; none for a block without.
pub(super) fn cells(
    columns: &Columns,
    stations: &Stations,
    remarks: &mut Vec<Remark>,
) -> Result<Vec<Vec<ThinCell>>, Located> {
    let count = columns.layers.names.len();
    // per layer: area without its cells, volume of its cells, volume as written
    let mut sums = vec![[0.0; 3]; count];
    let mut all = Vec::new();
    for block in 0..columns.blocks.count() {
        let rectangle = columns.blocks.rectangle(block);
        let [x, y] = [0, 1].map(|d: usize| within(&stations.lines[d], rectangle[d]));
        let mut own = Vec::new();
        for y in y.windows(2) {
            for x in x.windows(2) {
                let middle = [0.5 * (x[0] + x[1]), 0.5 * (y[0] + y[1])];
                let heights = columns.written(block, middle)?;
                let area = (x[1] - x[0]) * (y[1] - y[0]);
                let mut layers = vec![false; count];
                for k in 0..count {
                    let thickness = heights[k] - heights[k + 1];
                    layers[k] = thickness < HALF * columns.least(block, k);
                    sums[k][0] += if layers[k] { area } else { 0.0 };
                }
                // heights are bilinear between the lines: means of the corners
                for corner in y.iter().flat_map(|y| x.iter().map(|x| [*x, *y])) {
                    let heights = columns.written(block, corner)?;
                    let kept = columns.kept(block, corner, heights.clone())?;
                    for k in 0..count {
                        let own = if layers[k] {
                            0.0
                        } else {
                            kept[k] - kept[k + 1]
                        };
                        sums[k][1] += 0.25 * area * own;
                        sums[k][2] += 0.25 * area * (heights[k] - heights[k + 1]);
                    }
                }
                own.push(ThinCell {
                    rectangle: [[x[0], x[1]], [y[0], y[1]]],
                    layers,
                });
            }
        }
        all.push(own);
    }
    let [width, depth] = columns.ends.map(|[from, to]| to - from);
    for k in layers(columns, &stations.lines)? {
        let least = (0..columns.blocks.count()).map(|block| columns.least(block, k));
        let [area, volume, written] = sums[k];
        remarks.push(Remark::Thin {
            layer: columns.layers.names[k].clone(),
            least: least.fold(0.0, f64::max),
            share: area / (width * depth),
            volume: volume / written - 1.0,
        });
    }
    Ok(all)
}
