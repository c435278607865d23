//! One step of classical coarsening between levels.

use super::{Start, nodes};
use crate::amg::Amg;
use crate::amg::aggregation::Aggregates;
use crate::amg::coarse::{Coarsener, Frame, Known, NotPositive, Planned, STAGNATED, Values};
use crate::amg::matrix::NodeMatrix;
use crate::amg::node_map::NONE;
use fracas_operators::Real;
use fracas_operators::small::{Matrix3, cast, norm_squared};

/// Coarse nodes are fine ones, chosen and interpolated without thresholds from the settings. Planned are the coarse nodes and
/// the least-squares P; its energy is minimised for each matrix.
#[derive(Clone, Debug)]
pub(in crate::amg) struct Classical<const K: usize> {
    start: Start,
    modes: Vec<[[f64; K]; 3]>,
    frame: Frame,
}

impl<const K: usize> Coarsener<3, K> for Classical<K> {
    fn plan<S: Real>(
        _settings: &Amg,
        _depth: usize,
        a: &NodeMatrix<S>,
        known: &Known<K>,
        _group: usize,
    ) -> Option<Planned<Self, K>> {
        let (mut bonds, modes) = (known.bonds.as_ref(), &known.modes[..]);
        let nodes = nodes::of_level(a);
        let coarser = |count: usize| count > 0 && (count as f64) < STAGNATED * a.rows() as f64;
        let mut start = Start::new(&nodes, bonds, modes);
        if bonds.is_some() && !coarser(start.count()) {
            // every piece of rock is one node: from here on across the fractures
            bonds = None;
            start = Start::new(&nodes, None, modes);
        }
        let count = start.count();
        if !coarser(count) {
            return None;
        }
        let p = &start.interpolation;
        let closest = |i: usize| {
            let strongest = p
                .row(i)
                .max_by(|x, y| norm_squared(x.1).total_cmp(&norm_squared(y.1)));
            strongest.map_or(NONE, |(j, _)| j as u32)
        };
        let closest = Aggregates {
            of: (0..a.rows()).map(closest).collect(),
            count,
        };
        let pattern = p.pattern.clone();
        let coarse = start.splitting.nodes.iter();
        let known = Known {
            bonds: bonds.map(|bonds| closest.bonds(bonds)),
            modes: coarse.clone().map(|i| modes[*i as usize]).collect(),
            positions: Vec::new(),
        };
        Some(Planned {
            known,
            step: Self {
                frame: Frame::new(a, closest, pattern),
                start,
                modes: modes.to_vec(),
            },
        })
    }

    fn values<S: Real, R: Real>(
        &self,
        a: &NodeMatrix<S>,
        defect: Vec<Matrix3<f64>>,
        _lambda_max: f64,
    ) -> Result<Values<R, 3>, NotPositive> {
        let nodes = nodes::of_level(a);
        let inverse: Vec<Matrix3<f64>> = (0..a.rows()).map(|i| cast(a.inverse(i))).collect();
        let p = self.start.minimised(&nodes, &inverse, &self.modes);
        let blocks = p.values.iter().map(cast).collect();
        self.frame.values(a, defect, blocks)
    }

    fn frame(&self) -> &Frame {
        &self.frame
    }

    fn bytes(&self) -> usize {
        self.start.interpolation.bytes() + size_of_val(&*self.modes) + self.frame.bytes()
    }
}
