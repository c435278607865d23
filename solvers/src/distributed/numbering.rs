//! Which rank has which displacements and tractions, and where.

use super::{Nodes, Ranks};
use fracas_operators::sparse::SparseMatrix;

/// Owners of all unknowns; the same on every rank.
///
/// Displacements: nodes go from rank to rank, and those of a rank keep their order. Tractions of a face: where the first displacement is
/// that they push. Rows of 𝒜 go with them.
///
/// # Cost
/// 8 bytes per displacement on every rank.
#[derive(Clone, Debug)]
pub struct Numbering {
    ranks: Ranks,
    /// `3·node + component` in the numbering of nodes by ranks.
    slots: Vec<u32>,
    /// First node of every rank, and the number of all.
    first: Vec<u32>,
    /// Place of every displacement among those of its rank.
    place_u: Vec<u32>,
    own_u: Vec<u32>,
    /// Rank and place of every traction.
    of_t: Vec<(u32, u32)>,
    own_t: Vec<u32>,
    /// Places of the nodes of this rank among all, in its order.
    own_nodes: Vec<u32>,
}

impl Numbering {
    /// Of nodes in these parts, and tractions by the columns of B.
    pub fn new(ranks: Ranks, nodes: &Nodes, part: &[u32], b: &SparseMatrix<f64>) -> Self {
        let (size, rank) = (ranks.size(), ranks.rank() as u32);
        let mut first = vec![0u32; size + 1];
        part.iter().for_each(|p| first[*p as usize + 1] += 1);
        for k in 0..size {
            first[k + 1] += first[k];
        }
        let mut next = first.clone();
        let number = |p: &u32| {
            let number = next[*p as usize];
            next[*p as usize] += 1;
            number
        };
        let numbers: Vec<u32> = part.iter().map(number).collect();
        let own_nodes = (0..part.len() as u32).filter(|n| part[*n as usize] == rank);
        let own_nodes = own_nodes.collect();
        let mut counts = vec![0u32; size];
        let (mut place_u, mut own_u) = (Vec::with_capacity(nodes.slots.len()), Vec::new());
        for (i, slot) in nodes.slots.iter().enumerate() {
            let owner = part[*slot as usize / 3];
            place_u.push(counts[owner as usize]);
            counts[owner as usize] += 1;
            if owner == rank {
                own_u.push(i as u32);
            }
        }
        let owner_u = |i: usize| part[nodes.slots[i] as usize / 3];
        let (of_t, own_t) = tractions(b, owner_u, size, rank);
        let slots = nodes.slots.iter();
        Self {
            ranks,
            slots: slots
                .map(|s| 3 * numbers[*s as usize / 3] + s % 3)
                .collect(),
            first,
            place_u,
            own_u,
            of_t,
            own_t,
            own_nodes,
        }
    }

    /// Who they are.
    pub fn ranks(&self) -> Ranks {
        self.ranks
    }

    /// Displacements of all ranks.
    pub fn n_u(&self) -> usize {
        self.slots.len()
    }

    /// Tractions of all ranks.
    pub fn n_t(&self) -> usize {
        self.of_t.len()
    }

    /// Displacements of this rank, ascending.
    pub fn own_u(&self) -> &[u32] {
        &self.own_u
    }

    /// Tractions of this rank, ascending.
    pub fn own_t(&self) -> &[u32] {
        &self.own_t
    }

    /// Nodes of this rank, ascending.
    pub fn own_nodes(&self) -> &[u32] {
        &self.own_nodes
    }

    /// `3·node + component` of every displacement, nodes numbered from rank to rank.
    pub(super) fn slots(&self) -> &[u32] {
        &self.slots
    }

    /// Slots of this rank begin here.
    pub(super) fn first_slot(&self) -> u32 {
        3 * self.first[self.ranks.rank()]
    }

    /// Nodes of all ranks.
    pub(super) fn node_count(&self) -> usize {
        self.first[self.ranks.size()] as usize
    }

    /// Rank and place of a displacement.
    pub(super) fn of_u(&self, i: u32) -> (u32, u32) {
        let node = self.slots[i as usize] / 3;
        let owner = self.first.partition_point(|first| *first <= node) - 1;
        (owner as u32, self.place_u[i as usize])
    }

    /// Rank and place of a traction.
    pub(super) fn of_t(&self, k: u32) -> (u32, u32) {
        self.of_t[k as usize]
    }

    /// The entries of this rank of a vector (u, t).
    pub fn own(&self, whole: &[f64]) -> Vec<f64> {
        let (u, t) = whole.split_at(self.n_u());
        let of =
            |list: &[u32], v: &[f64]| -> Vec<f64> { list.iter().map(|i| v[*i as usize]).collect() };
        [of(&self.own_u, u), of(&self.own_t, t)].concat()
    }

    /// A vector (u, t) of all ranks on the first one, from the entries of each; empty on the others.
    pub fn whole(&self, own: &[f64]) -> Vec<f64> {
        let (u, t) = own.split_at(self.own_u.len());
        let [u, t] = [u, t].map(|own| self.ranks.collect(own));
        if !self.ranks.is_first() {
            return Vec::new();
        }
        let u = in_order(u, self.ranks.size(), self.n_u(), |i| self.of_u(i));
        let t = in_order(t, self.ranks.size(), self.n_t(), |k| self.of_t(k));
        [u, t].concat()
    }
}

/// Entries that came rank after rank, in the order of all.
fn in_order(came: Vec<f64>, ranks: usize, n: usize, place: impl Fn(u32) -> (u32, u32)) -> Vec<f64> {
    let mut first = vec![0usize; ranks + 1];
    (0..n as u32).for_each(|i| first[place(i).0 as usize + 1] += 1);
    for k in 0..ranks {
        first[k + 1] += first[k];
    }
    let entry = |i: u32| {
        let (rank, place) = place(i);
        came[first[rank as usize] + place as usize]
    };
    (0..n as u32).map(entry).collect()
}

/// Rank and place of every traction, and those of `rank`: faces of three, or tractions one by one where they are no triples.
fn tractions(
    b: &SparseMatrix<f64>,
    owner_u: impl Fn(usize) -> u32,
    ranks: usize,
    rank: u32,
) -> (Vec<(u32, u32)>, Vec<u32>) {
    const NOBODY: u32 = u32::MAX;
    let n = b.cols();
    let group = if n.is_multiple_of(3) { 3 } else { 1 };
    let mut owners = vec![NOBODY; n / group];
    for (i, row) in b.outer_iterator().enumerate() {
        for j in row.indices() {
            let owner = &mut owners[*j as usize / group];
            if *owner == NOBODY {
                *owner = owner_u(i);
            }
        }
    }
    let mut counts = vec![0u32; ranks];
    let mut places = Vec::with_capacity(n);
    let mut own = Vec::new();
    for k in 0..n {
        // what pushes nothing is at home anywhere
        let owner = match owners[k / group] {
            NOBODY => 0,
            owner => owner,
        };
        places.push((owner, counts[owner as usize]));
        counts[owner as usize] += 1;
        if owner == rank {
            own.push(k as u32);
        }
    }
    (places, own)
}
