//! Unknowns grouped into nodes of three components.

use crate::DofCoordinate;
use crate::multigrid::{Places, Slots};
use fracas_operators::sparse::SparseMatrix;
use std::sync::Arc;

/// No unknown, no node.
pub(crate) use crate::multigrid::NONE;

/// Share of nodes with a single unknown above which the unknowns are not taken to be stored node by node.
const SCATTERED: f64 = 0.1;

/// Which node and component every unknown is: unknown i sits in slot `3·node + component`. Slots of constrained
/// components stay empty.
#[derive(Clone, Debug)]
pub(crate) struct NodeMap {
    slots: Arc<Slots>,
    /// Position of every node; empty without coordinates.
    positions: Vec<[f64; 3]>,
}

impl NodeMap {
    /// Nodes of the unknowns of `a`, by their coordinates where these are known.
    ///
    /// Without coordinates the unknowns are taken as triples if there are 3·k of them, as one component each otherwise.
    pub(crate) fn new(a: &SparseMatrix<f64>, coordinates: Option<&[DofCoordinate]>) -> Self {
        let n = a.rows();
        match coordinates {
            Some(coordinates) => Self::of_coordinates(a, coordinates),
            None if n.is_multiple_of(3) => Self::from_slots((0..n as u32).collect(), n / 3, vec![]),
            None => Self::from_slots((0..n as u32).map(|i| 3 * i).collect(), n, vec![]),
        }
    }

    fn from_slots(slots: Vec<u32>, nodes: usize, positions: Vec<[f64; 3]>) -> Self {
        Self {
            slots: Arc::new(Slots::new(slots, 3 * nodes)),
            positions,
        }
    }

    fn of_coordinates(a: &SparseMatrix<f64>, coordinates: &[DofCoordinate]) -> Self {
        let (slots, positions) = consecutive(coordinates);
        let mut sizes = vec![0_u8; positions.len()];
        slots.iter().for_each(|slot| sizes[*slot as usize / 3] += 1);
        let single = sizes.iter().filter(|size| **size == 1).count();
        let (slots, positions) = if single as f64 > SCATTERED * positions.len() as f64 {
            by_position(a, coordinates)
        } else {
            (slots, positions)
        };
        Self::from_slots(slots, positions.len(), positions)
    }

    /// Unknowns.
    pub(crate) fn unknowns_len(&self) -> usize {
        self.slots.of_unknown.len()
    }

    /// Where every unknown is.
    pub(crate) fn places(&self) -> Places {
        Places::Slots(self.slots.clone())
    }

    /// Nodes.
    pub(crate) fn nodes(&self) -> usize {
        self.slots.unknowns.len() / 3
    }

    /// Slot of every unknown.
    pub(crate) fn slots(&self) -> &[u32] {
        &self.slots.of_unknown
    }

    /// Unknowns of a node, [`NONE`] for a constrained component.
    pub(crate) fn of_node(&self, node: usize) -> &[u32] {
        &self.slots.unknowns[3 * node..][..3]
    }

    /// Positions of the nodes, if known.
    pub(crate) fn positions(&self) -> Option<&[[f64; 3]]> {
        (!self.positions.is_empty() || self.unknowns_len() == 0).then_some(&self.positions)
    }
}

/// Nodes as runs of unknowns at one position with ascending components.
fn consecutive(coordinates: &[DofCoordinate]) -> (Vec<u32>, Vec<[f64; 3]>) {
    let mut slots = Vec::with_capacity(coordinates.len());
    let mut positions: Vec<[f64; 3]> = Vec::with_capacity(coordinates.len() / 3);
    let mut last: Option<&DofCoordinate> = None;
    for dof in coordinates {
        let same = last.is_some_and(|l| l.position == dof.position && l.component < dof.component);
        if !same {
            positions.push(dof.position);
        }
        slots.push(3 * (positions.len() as u32 - 1) + u32::from(dof.component));
        last = Some(dof);
    }
    (slots, positions)
}

/// Nodes of unknowns in any order. Copies of a split node share their position; their unknowns are told apart by which
/// of them A couples.
fn by_position(a: &SparseMatrix<f64>, coordinates: &[DofCoordinate]) -> (Vec<u32>, Vec<[f64; 3]>) {
    let key = |i: &u32| {
        let dof = &coordinates[*i as usize];
        (dof.position.map(|x| (x + 0.0).to_bits()), dof.component, *i)
    };
    let mut order: Vec<u32> = (0..coordinates.len() as u32).collect();
    order.sort_unstable_by_key(key);
    let mut slots = vec![NONE; coordinates.len()];
    let mut positions = Vec::new();
    for group in order.chunk_by(|i, j| key(i).0 == key(j).0) {
        for (k, i) in group.iter().enumerate() {
            if slots[*i as usize] != NONE {
                continue;
            }
            let node = positions.len() as u32;
            positions.push(coordinates[*i as usize].position);
            slots[*i as usize] = 3 * node + u32::from(coordinates[*i as usize].component);
            for component in coordinates[*i as usize].component + 1..3 {
                let free = group[k..].iter().filter(|j| {
                    slots[**j as usize] == NONE && coordinates[**j as usize].component == component
                });
                let coupling = |j: &u32| a.get(*i as usize, *j as usize).map_or(0.0, |v| v.abs());
                // the strongest coupling; among equals the first
                let best = free.fold(None, |best: Option<(u32, f64)>, j| match best {
                    Some((_, strongest)) if strongest >= coupling(j) => best,
                    _ => Some((*j, coupling(j))),
                });
                if let Some((j, _)) = best {
                    slots[j as usize] = 3 * node + u32::from(component);
                }
            }
        }
    }
    (slots, positions)
}
