//! `coords.mtx` in both of its forms.

use super::FolderError;
use crate::saddle::DofCoordinate;
use fracas_operators::{Dense, LinearOperator, Shape};

const FILE: &str = "coords.mtx";

/// `n_u` rows `x y z component`, or `n_u / 3` rows `x y z` with components 0, 1, 2 node by node.
pub(super) fn from_table(
    table: &Dense<f64>,
    n_u: usize,
) -> Result<Vec<DofCoordinate>, FolderError> {
    let shape = table.shape();
    let position = |row: usize| [0, 1, 2].map(|k| table.entry(row, k));
    if shape == Shape::new(n_u, 4) {
        let mut components = (0..n_u).map(|i| table.entry(i, 3));
        let from_one = n_u > 0 && components.all(|c| [1.0, 2.0, 3.0].contains(&c));
        if from_one && (0..n_u).any(|i| table.entry(i, 3) == 3.0) {
            return Err(FolderError::ComponentsFromOne { file: FILE });
        }
        (0..n_u)
            .map(|i| match table.entry(i, 3) {
                value if [0.0, 1.0, 2.0].contains(&value) => Ok(DofCoordinate {
                    position: position(i),
                    component: value as u8,
                }),
                value => Err(FolderError::Component {
                    file: FILE,
                    row: i + 1,
                    value,
                }),
            })
            .collect()
    } else if shape.cols == 3 && 3 * shape.rows == n_u {
        Ok((0..n_u)
            .map(|i| DofCoordinate {
                position: position(i / 3),
                component: (i % 3) as u8,
            })
            .collect())
    } else {
        Err(FolderError::CoordinateShape { found: shape, n_u })
    }
}

/// The form with a component per unknown: it also holds when some directions are constrained.
pub(super) fn to_table(coordinates: &[DofCoordinate]) -> Dense<f64> {
    Dense::from_fn(Shape::new(coordinates.len(), 4), |i, j| match j {
        3 => f64::from(coordinates[i].component),
        _ => coordinates[i].position[j],
    })
}
