//! Smoothed aggregation: aggregates of nodes, with as many unknowns each as there are modes.

use super::Amg;
use super::aggregation::{Aggregates, aggregate};
use super::coarse::{Coarsener, Frame, NotPositive, Planned, STAGNATED, Values};
use super::prolongation;
use super::rows::Pattern;
use super::sweeps::SweepMatrix;
use super::tentative::Tentative;
use fracas_operators::Real;

/// Entries of a coarse matrix over those of the fine one above which the prolongation stays unsmoothed: where fractures cut
/// the rock into pieces of a few elements, smoothing across them fills the coarse matrix and gains little. Unit: 1.
const FILL: f64 = 0.5;

/// Factor per level on the strength from which nodes are gathered. Coarse connections spread and weaken, but what a contrast of
/// 10³ separates must stay apart: at ½ a stiff plate on a soft layer joins it on the third level, and iterations double. Unit: 1.
const EASING: f64 = 0.7;

/// Unknowns up to which a network of pieces of rock is solved directly instead of being coarsened further: pieces turn
/// against each other like gears, which no aggregate of several pieces can do.
const NETWORK: usize = 16_000;

/// A planned step.
#[derive(Clone, Debug)]
pub(super) struct SmoothedAggregation<const K: usize> {
    group: usize,
    /// Rows of P_0.
    tentative: Vec<[[f64; K]; 3]>,
    frame: Frame,
    /// True when fractures cut the rock into pieces of a few elements, so that P_0 is not smoothed.
    network: bool,
}

impl<const K: usize> Coarsener<K, K> for SmoothedAggregation<K> {
    fn plan<S: Real>(
        settings: &Amg,
        depth: usize,
        a: &SweepMatrix<S>,
        bonds: Option<&Pattern>,
        group: usize,
        modes: &[[[f64; K]; 3]],
    ) -> Option<Planned<Self, K>> {
        let theta = settings.strength * EASING.powi(depth as i32);
        let nodes = a.rows() / group;
        let coarser = |aggregates: &Aggregates| {
            aggregates.count > 0 && (aggregates.count as f64) < STAGNATED * nodes as f64
        };
        let mut aggregates = aggregate(a, bonds, group, theta);
        let bonds = bonds.filter(|_| coarser(&aggregates));
        if bonds.is_none() && !coarser(&aggregates) {
            // every piece of rock is one aggregate: from here on across the fractures
            aggregates = aggregate(a, None, group, theta);
        }
        if !coarser(&aggregates) {
            return None;
        }
        let bonds = bonds.map(|bonds| aggregates.bonds(bonds));
        let Tentative { rows, coarse } = Tentative::new(&aggregates, group, modes);
        let pattern = prolongation::pattern(a, group, &aggregates);
        let mut frame = Frame::new(a, aggregates, pattern);
        let entries = K * K * frame.patterns.coarse().columns.len();
        let network = entries as f64 > FILL * (9 * a.block_count()) as f64;
        if network {
            let pattern = prolongation::tentative_pattern(a.rows(), group, &frame.aggregates);
            frame = Frame::new(a, frame.aggregates, pattern);
        }
        Some(Planned {
            step: Self {
                group,
                tentative: rows,
                frame,
                network,
            },
            bonds,
            modes: coarse
                .iter()
                .flat_map(|rows| rows.as_chunks::<3>().0.iter().copied())
                .collect(),
        })
    }

    fn values<S: Real, R: Real>(
        &self,
        a: &SweepMatrix<S>,
        defect: &[[f64; 9]],
        lambda_max: f64,
    ) -> Result<Values<R>, NotPositive> {
        let (aggregates, pattern) = (&self.frame.aggregates, &self.frame.transfer.p);
        let blocks = if self.network {
            prolongation::tentative(self.group, aggregates, &self.tentative)
        } else {
            let (group, tentative) = (self.group, &self.tentative);
            prolongation::smoothed(a, group, aggregates, tentative, pattern, lambda_max)
        };
        self.frame.values(a, defect, blocks)
    }

    fn frame(&self) -> &Frame {
        &self.frame
    }

    fn direct_below(&self, settings: &Amg) -> usize {
        match self.network {
            true => settings.coarsest.max(NETWORK),
            false => settings.coarsest,
        }
    }

    fn bytes(&self) -> usize {
        size_of_val(&*self.tentative) + self.frame.bytes()
    }
}
