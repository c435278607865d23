//! Below the coarsest grid: a direct solver, algebraic multigrid where a large grid no longer shrinks.

use super::elements::Elements;
use super::grid::Grid;
use super::hierarchy::position;
use super::pattern::pattern;
use super::{Geometric, GeometricError};
use crate::mesh::HexMesh;
use fracas_operators::Real;
use fracas_operators::sparse::{Block3, Pattern, SparseMatrix};
use fracas_solvers::DofCoordinate;
use fracas_solvers::amg::Amg;
use fracas_solvers::multigrid::{Bottom, Direct};

/// The solver of the coarsest level.
pub(super) fn bottom<R: Real>(
    settings: &Geometric,
    mesh: &HexMesh,
    grid: &Grid<'_>,
    matrix: &Block3<f64>,
    fixed: &[u8],
) -> Result<Bottom<R>, GeometricError> {
    let n = 3 * grid.nodes;
    let diagonal = |i: usize| entry(matrix, i, i);
    let is_free = |i: &u32| {
        let i = *i as usize;
        fixed[i / 3] >> (i % 3) & 1 == 0 && diagonal(i) > 0.0
    };
    let free: Vec<u32> = (0..n as u32).filter(is_free).collect();
    let mut index = vec![u32::MAX; n];
    free.iter()
        .enumerate()
        .for_each(|(k, i)| index[*i as usize] = k as u32);
    let (mut starts, mut columns, mut values) = (vec![0], Vec::new(), Vec::new());
    for i in &free {
        let i = *i as usize;
        for (j, value) in matrix.row(i) {
            let value = 0.5 * (value + entry(matrix, j, i));
            if index[j] != u32::MAX && value != 0.0 {
                columns.push(index[j]);
                values.push(value);
            }
        }
        starts.push(columns.len());
    }
    let a = SparseMatrix::new((free.len(), free.len()), starts, columns, values);
    if free.len() <= settings.coarsest.max(settings.direct) {
        let direct = Direct::semidefinite(a).map_err(|error| error.in_block("S_u"))?;
        return Ok(Bottom::semidefinite(direct, free, n));
    }
    let coordinates: Vec<DofCoordinate> = free
        .iter()
        .map(|i| DofCoordinate {
            position: position(mesh, grid, *i as usize / 3),
            component: (i % 3) as u8,
        })
        .collect();
    let amg = Amg {
        precision: settings.precision,
        over_correction: 1.0,
        ..Amg::default()
    };
    let joined = joined(grid, &free, &index);
    let build = |amg: Amg| amg.build_joined(&a, &joined, Some(&coordinates));
    // functions of narrow blocks on wide cells differ by less than f32 tells
    let inverse = build(amg).or_else(|error| amg.in_double().map_or(Err(error), build));
    let inverse = inverse.map_err(|error| error.in_block("S_u"))?;
    let levels = inverse.summary().levels;
    Ok(Bottom::new(Box::new(inverse), levels, free, n))
}

/// The free unknowns that an element joins: aggregates are pieces of rock before they reach across fractures. Bars between cuts along two
/// axes took 400 iterations without, and take 61.
fn joined(grid: &Grid<'_>, free: &[u32], index: &[u32]) -> Pattern {
    let kinds = vec![Elements::NONE; grid.elements.len()];
    let nodes = pattern(grid, &kinds, &[]);
    Pattern::collect(
        free.len(),
        || (),
        |k, (), columns| {
            for j in nodes.row(free[k] as usize / 3) {
                let own = &index[3 * *j as usize..][..3];
                columns.extend(own.iter().filter(|j| **j != u32::MAX));
            }
        },
    )
}

/// Entry (i, j).
fn entry(matrix: &Block3<f64>, i: usize, j: usize) -> f64 {
    let block = matrix.block(i / 3, j / 3);
    block.map_or(0.0, |block| block[i % 3][j % 3])
}
