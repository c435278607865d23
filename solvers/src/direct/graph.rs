//! The undirected graph of a sparse pattern.

use fracas_operators::random::splitmix64;
use fracas_operators::sparse::SparseMatrix;

/// Compressed adjacency of an undirected graph without loops; neighbours are sorted.
#[derive(Clone, Debug, PartialEq, Eq)]
pub(super) struct Graph {
    /// Where the neighbours of a node begin; one more entry than nodes.
    pub(super) offsets: Vec<usize>,
    /// Neighbours of node after node.
    pub(super) neighbours: Vec<usize>,
}

impl Graph {
    /// The graph of `A + Aᵀ` without its diagonal.
    pub(super) fn of_pattern(a: &SparseMatrix<f64>) -> Self {
        let n = a.outer_dims();
        let transpose = transposed_rows(a);
        let mut graph = Self {
            offsets: vec![0],
            neighbours: Vec::with_capacity(a.nnz()),
        };
        for i in 0..n {
            let row = a.outer_view(i);
            let stored = row.iter().flat_map(|row| row.indices());
            merge(
                stored.map(|j| *j as usize),
                transpose.of(i).iter().copied(),
                i,
                &mut graph.neighbours,
            );
            graph.offsets.push(graph.neighbours.len());
        }
        graph
    }

    /// Nodes.
    pub(super) fn nodes(&self) -> usize {
        self.offsets.len() - 1
    }

    /// Neighbours of one node.
    pub(super) fn of(&self, i: usize) -> &[usize] {
        &self.neighbours[self.offsets[i]..self.offsets[i + 1]]
    }

    /// The graph with nodes of equal closed neighbourhood merged, and the members of every merged node.
    pub(super) fn compressed(&self) -> (Self, Vec<Vec<usize>>) {
        let hash = |i: usize| {
            self.of(i)
                .iter()
                .fold(scrambled(i), |sum, &j| sum.wrapping_add(scrambled(j)))
        };
        let hashes: Vec<u64> = (0..self.nodes()).map(hash).collect();
        const NONE: usize = usize::MAX;
        let mut group_of = vec![NONE; self.nodes()];
        let mut members: Vec<Vec<usize>> = Vec::new();
        for i in 0..self.nodes() {
            if group_of[i] != NONE {
                continue;
            }
            group_of[i] = members.len();
            let mut group = vec![i];
            for &j in self.of(i) {
                if group_of[j] == NONE
                    && hashes[j] == hashes[i]
                    && self.same_closed_neighbourhood(i, j)
                {
                    group_of[j] = members.len();
                    group.push(j);
                }
            }
            members.push(group);
        }
        let mut graph = Self {
            offsets: vec![0],
            neighbours: Vec::new(),
        };
        for (g, group) in members.iter().enumerate() {
            let start = graph.neighbours.len();
            let others = self.of(group[0]).iter().map(|&j| group_of[j]);
            graph.neighbours.extend(others.filter(|&other| other != g));
            graph.neighbours[start..].sort_unstable();
            let mut kept = start;
            for k in start..graph.neighbours.len() {
                if kept == start || graph.neighbours[k] != graph.neighbours[kept - 1] {
                    graph.neighbours[kept] = graph.neighbours[k];
                    kept += 1;
                }
            }
            graph.neighbours.truncate(kept);
            graph.offsets.push(kept);
        }
        (graph, members)
    }

    /// Whether two neighbours have the same neighbours, each other aside.
    fn same_closed_neighbourhood(&self, i: usize, j: usize) -> bool {
        let of_i = self.of(i).iter().filter(|&&k| k != j);
        let of_j = self.of(j).iter().filter(|&&k| k != i);
        of_i.eq(of_j)
    }
}

/// Fraction of the off-diagonal entries whose mirror image is stored too; 1 where there are none.
#[cfg(feature = "suitesparse")]
pub(super) fn symmetry(a: &SparseMatrix<f64>) -> f64 {
    let diagonal = (0..a.rows()).filter(|&i| a.get(i, i).is_some()).count();
    let stored = (a.nnz() - diagonal) as f64;
    // every entry without image adds one neighbour more than it is
    let neighbours = Graph::of_pattern(a).neighbours.len() as f64;
    if stored == 0.0 {
        1.0
    } else {
        2.0 - neighbours / stored
    }
}

/// Rows of Aᵀ as an adjacency, loops included.
fn transposed_rows(a: &SparseMatrix<f64>) -> Graph {
    let n = a.inner_dims();
    let mut offsets = vec![0; n + 1];
    for j in a.indices() {
        offsets[*j as usize + 1] += 1;
    }
    for i in 0..n {
        offsets[i + 1] += offsets[i];
    }
    let mut next = offsets.clone();
    let mut neighbours = vec![0; a.nnz()];
    for (i, row) in a.outer_iterator().enumerate() {
        for (j, _) in row.iter() {
            neighbours[next[j]] = i;
            next[j] += 1;
        }
    }
    Graph {
        offsets,
        neighbours,
    }
}

/// Appends the union of two sorted lists, without `excluded`.
fn merge(
    a: impl Iterator<Item = usize>,
    b: impl Iterator<Item = usize>,
    excluded: usize,
    out: &mut Vec<usize>,
) {
    let (mut a, mut b) = (a.peekable(), b.peekable());
    loop {
        let smallest = match (a.peek(), b.peek()) {
            (Some(&x), Some(&y)) => x.min(y),
            (Some(&x), None) | (None, Some(&x)) => x,
            (None, None) => return,
        };
        a.next_if_eq(&smallest);
        b.next_if_eq(&smallest);
        if smallest != excluded {
            out.push(smallest);
        }
    }
}

/// Spreads node numbers so that sums of them rarely collide (a collision costs a comparison, no more).
fn scrambled(i: usize) -> u64 {
    splitmix64(i as u64)
}

#[cfg(test)]
mod tests {
    use super::*;
    use fracas_operators::sparse::Triplets;

    /// A path of `nodes` nodes with `dofs` unknowns each, all coupled.
    fn path(nodes: usize, dofs: usize) -> SparseMatrix<f64> {
        let mut triplets = Triplets::new((nodes * dofs, nodes * dofs));
        for a in 0..nodes {
            for b in a.saturating_sub(1)..(a + 2).min(nodes) {
                for (r, c) in (0..dofs * dofs).map(|k| (k / dofs, k % dofs)) {
                    triplets.add_triplet(a * dofs + r, b * dofs + c, 1.0);
                }
            }
        }
        triplets.to_csr()
    }

    #[test]
    fn three_unknowns_per_node_become_one_node() {
        let (graph, members) = Graph::of_pattern(&path(7, 3)).compressed();
        assert_eq!(graph, Graph::of_pattern(&path(7, 1)));
        assert!(
            members
                .iter()
                .enumerate()
                .all(|(g, m)| *m == [3 * g, 3 * g + 1, 3 * g + 2])
        );
    }

    #[test]
    fn the_graph_of_an_unsymmetric_pattern_is_symmetric() {
        let mut triplets = Triplets::new((3, 3));
        for (i, j) in [(0, 0), (0, 2), (1, 0), (2, 2)] {
            triplets.add_triplet(i, j, 1.0);
        }
        let graph = Graph::of_pattern(&triplets.to_csr());
        assert_eq!(graph.offsets, [0, 2, 3, 4]);
        assert_eq!(graph.neighbours, [1, 2, 0, 0]);
    }

    #[cfg(feature = "suitesparse")]
    #[test]
    fn symmetry_counts_entries_with_an_image() {
        assert_eq!(symmetry(&path(5, 3)), 1.0);
        let mut triplets = Triplets::new((3, 3));
        for (i, j) in [(0, 0), (0, 1), (1, 0), (0, 2), (1, 2)] {
            triplets.add_triplet(i, j, 1.0);
        }
        assert_eq!(symmetry(&triplets.to_csr()), 0.5);
    }
}
