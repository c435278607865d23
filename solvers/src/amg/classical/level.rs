//! One step of classical coarsening between levels.

use super::{Modes, NodeBlocks, coarsen};
use crate::amg::Amg;
use crate::amg::aggregation::Aggregates;
use crate::amg::coarse::{Coarse, Coarsener, NotPositive, STAGNATED, coarse_matrix};
use crate::amg::galerkin::{self, Patterns};
use crate::amg::lambda::largest_eigenvalue;
use crate::amg::node_map::NONE;
use crate::amg::prolongation::Prolongation;
use crate::amg::rows::Pattern;
use crate::amg::sweeps::SweepMatrix;
use fracas_operators::Real;

/// Coarse nodes are fine ones, chosen and interpolated without thresholds from the settings.
pub(in crate::amg) struct Classical;

impl<const K: usize> Coarsener<3, K> for Classical {
    fn coarsen<R: Real>(
        _settings: &Amg,
        _depth: usize,
        a: &SweepMatrix<R>,
        defect: &[[f64; 9]],
        mut bonds: Option<&Pattern>,
        _group: usize,
        modes: &Modes<K>,
    ) -> Result<Option<Coarse<3, K>>, NotPositive> {
        let nodes = NodeBlocks::of_level(a);
        let inverse: Vec<[f64; 9]> = (0..a.rows())
            .map(|i| a.inverse(i).map(R::to_f64_exact))
            .collect();
        let coarser = |count: usize| count > 0 && (count as f64) < STAGNATED * a.rows() as f64;
        let mut coarse = coarsen(&nodes, &inverse, bonds, modes);
        if bonds.is_some() && !coarser(coarse.nodes.len()) {
            // every piece of rock is one node: from here on across the fractures
            bonds = None;
            coarse = coarsen(&nodes, &inverse, None, modes);
        }
        let count = coarse.nodes.len();
        if !coarser(count) {
            return Ok(None);
        }
        let p = coarse.interpolation;
        let square = |b: &[f64; 9]| b.iter().map(|v| v * v).sum::<f64>();
        let closest = |i: usize| {
            let strongest = p.row(i).max_by(|x, y| square(x.1).total_cmp(&square(y.1)));
            strongest.map_or(NONE, |(j, _)| j as u32)
        };
        let closest = Aggregates {
            of: (0..p.len()).map(closest).collect(),
            count,
        };
        let prolongation = Prolongation {
            blocks: p.blocks.iter().map(by_rows).collect(),
            pattern: Pattern {
                offsets: p.offsets,
                columns: p.columns,
            },
        };
        let patterns = Patterns::new(a, &prolongation.pattern, count);
        let blocks = galerkin::product(a, defect, &prolongation, &patterns);
        let matrix = coarse_matrix(patterns.coarse(), blocks).map_err(|NotPositive(row)| {
            NotPositive(3 * coarse.nodes[row / 3] as usize + row % 3)
        })?;
        Ok(Some(Coarse {
            bonds: bonds.map(|bonds| closest.bonds(bonds)),
            aggregates: closest,
            network: false,
            prolongation,
            matrix,
            modes: coarse.nodes.iter().map(|i| modes[*i as usize]).collect(),
            lambda_max: largest_eigenvalue(a),
        }))
    }
}

fn by_rows(b: &[f64; 9]) -> [[f64; 3]; 3] {
    [[b[0], b[1], b[2]], [b[3], b[4], b[5]], [b[6], b[7], b[8]]]
}
