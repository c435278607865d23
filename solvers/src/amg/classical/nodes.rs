//! A symmetric matrix by nodes.

use crate::amg::matrix::NodeMatrix;
use fracas_operators::Real;
use fracas_operators::small::{Matrix3, cast};
use fracas_operators::sparse::SparseRows;

/// Rows of 3×3 blocks, every diagonal block present.
pub(super) type NodeBlocks = SparseRows<Matrix3<f64>>;

/// The matrix of a level, in f64.
pub(super) fn of_level<R: Real>(a: &NodeMatrix<R>) -> NodeBlocks {
    SparseRows::collect(
        a.rows(),
        || (),
        |i, (), row| {
            let start = row.len();
            row.extend(a.row(i).map(|(j, block)| (j as u32, cast(block))));
            row[start..].sort_unstable_by_key(|entry| entry.0);
        },
    )
}

/// A_ii.
pub(super) fn diagonal(a: &NodeBlocks, i: usize) -> &Matrix3<f64> {
    let place = a.pattern.row(i).binary_search(&(i as u32));
    let place = place.unwrap_or_else(|_| panic!("no diagonal block in row {i}"));
    &a.values[a.pattern.offsets[i] + place]
}
