//! Smoothed aggregation: aggregates of nodes, with as many unknowns each as there are modes.

use super::Amg;
use super::aggregation::{Aggregates, Strong, aggregate};
use super::coarse::{Coarsener, Frame, Known, NotPositive, Planned, STAGNATED, Values};
use super::extension::Extension;
use super::matrix::NodeMatrix;
use super::prolongation;
use super::reach::Reach;
use super::tentative::Tentative;
use fracas_operators::Real;
use fracas_operators::small::Matrix3;

/// Entries of a coarse matrix over those of the fine one above which the prolongation stays unsmoothed: where fractures cut
/// the rock into pieces of a few elements, smoothing across them fills the coarse matrix and gains little. Unit: 1.
const FILL: f64 = 0.5;

/// Entries of the coarse matrix of a smoothed prolongation over those of an unsmoothed one that it takes, too: chains of three nodes
/// in flat cells fill half of the fine matrix smoothed (1.0) or not; graded slabs have 1.7 to 2.9, `analogue_c` and
/// `analogue_c_blocks` 4.8 and 4.9. Small scenes: with 0 `stretched`, `line_crack`, `inclined_crack` take 22, 47, 51 iterations for
/// 20, 36, 40; with no limit C_s of `analogue_c` is 480 for 322. Unit: 1.
const SPREAD: f64 = 3.0;

/// Factor per level on the strength from which nodes are gathered. Coarse connections spread and weaken, but what a contrast of
/// 10³ separates must stay apart: at ½ a stiff plate on a soft layer joins it on the third level, and iterations double. Unit: 1.
const EASING: f64 = 0.7;

/// Unknowns up to which a network of pieces of rock is solved directly instead of being coarsened further. Pieces turn against each other
/// like gears, which no aggregate of several pieces can do. Columns do so by torsion, which costs no slip, and aggregates of three layers that
/// turn as a whole take three times its energy per level: λ_min(S̃_u⁻¹S_u) is 0.12 with one such level and 0.025 with two. `analogue_c` with 32³
/// cells takes 39 iterations in 3.4 s for 144 in 19.6 s, and 3.9 s of set-up for 2.0 s; its second level has 57,000 unknowns. With 48³ cells
/// (190,000 there) it takes 237.
const NETWORK: usize = 100_000;

/// A planned step.
#[derive(Clone, Debug)]
pub(super) struct SmoothedAggregation<const K: usize> {
    group: usize,
    /// Rows of P_0.
    tentative: Vec<[[f64; K]; 3]>,
    /// Where P leaves out far nodes.
    extension: Option<Extension<K>>,
    frame: Frame,
    /// True when fractures cut the rock into pieces of a few elements, so that P_0 is not smoothed.
    network: bool,
}

impl<const K: usize> Coarsener<K, K> for SmoothedAggregation<K> {
    fn plan<S: Real>(
        settings: &Amg,
        depth: usize,
        a: &NodeMatrix<S>,
        known: &Known<K>,
        group: usize,
    ) -> Option<Planned<Self, K>> {
        let (bonds, modes, positions) = (known.bonds.as_ref(), &known.modes, &known.positions);
        let theta = settings.strength * EASING.powi(depth as i32);
        let nodes = a.rows() / group;
        let coarser = |aggregates: &Aggregates| {
            aggregates.count > 0 && (aggregates.count as f64) < STAGNATED * nodes as f64
        };
        let mut reach = Reach::new(a, bonds, positions, group);
        let gathered = |bonds, reach: &Reach<'_>| {
            aggregate(a, &Strong::new(a, bonds, reach, group, theta), group)
        };
        let mut aggregates = gathered(bonds, &reach);
        let bonds = bonds.filter(|_| coarser(&aggregates));
        if bonds.is_none() && !coarser(&aggregates) {
            // every piece of rock is one aggregate: from here on across the fractures
            reach = Reach::new(a, None, positions, group);
            aggregates = gathered(None, &reach);
        }
        if !coarser(&aggregates) {
            return None;
        }
        let bonds = bonds.map(|bonds| aggregates.bonds(bonds));
        let Tentative { rows, coarse } = Tentative::new(&aggregates, group, modes);
        let pattern = prolongation::pattern(a, group, &aggregates, &reach);
        let mut frame = Frame::new(a, aggregates, pattern);
        let entries = K * K * frame.patterns.coarse().columns.len();
        let mut network = false;
        if entries as f64 > FILL * (9 * a.block_count()) as f64 {
            let pattern = prolongation::tentative_pattern(a.rows(), group, &frame.aggregates);
            let plain = Frame::new(a, frame.aggregates.clone(), pattern);
            let least = K * K * plain.patterns.coarse().columns.len();
            network = entries as f64 > SPREAD * least as f64;
            if network {
                frame = plain;
            }
        }
        let parts = !network && reach.parts(a, &frame.aggregates, group);
        let known = Known {
            bonds,
            modes: coarse
                .iter()
                .flat_map(|rows| rows.as_chunks::<3>().0.iter().copied())
                .collect(),
            positions: frame.aggregates.centres(positions),
        };
        let step = Self {
            group,
            tentative: rows,
            extension: parts.then(|| Extension {
                modes: modes.clone(),
                bases: coarse,
            }),
            frame,
            network,
        };
        Some(Planned { step, known })
    }

    fn values<S: Real, R: Real>(
        &self,
        a: &NodeMatrix<S>,
        defect: Vec<Matrix3<f64>>,
        lambda_max: f64,
    ) -> Result<Values<R, K>, NotPositive> {
        let (aggregates, pattern) = (&self.frame.aggregates, &self.frame.transfer.p);
        let blocks = if self.network {
            prolongation::tentative(self.group, aggregates, &self.tentative)
        } else {
            let (group, tentative) = (self.group, &self.tentative);
            prolongation::smoothed(
                a,
                group,
                aggregates,
                tentative,
                self.extension.as_ref(),
                pattern,
                lambda_max,
            )
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
        let extension = self.extension.as_ref().map_or(0, Extension::bytes);
        size_of_val(&*self.tentative) + extension + self.frame.bytes()
    }
}
