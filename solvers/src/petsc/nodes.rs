//! S_u in full 3×3 blocks of nodes, as programs with PETSc assemble it: held components are rows of the identity.

use crate::amg::node_map::NodeMap;
use crate::smoothers::entries::rows;
use crate::{DofCoordinate, SetupError};
use fracas_operators::sparse::SparseMatrix;

/// Compressed rows with 32-bit indices, sorted in every row.
pub(super) struct Nodes {
    /// 3, or 1 where nothing tells which unknowns are a node.
    pub(super) block: usize,
    pub(super) offsets: Vec<i32>,
    pub(super) columns: Vec<i32>,
    pub(super) values: Vec<f64>,
    /// Row of every unknown.
    pub(super) slots: Vec<u32>,
    /// x, y, z of every block of rows; empty without coordinates.
    pub(super) positions: Vec<f64>,
}

impl Nodes {
    /// Rows of a matrix whose unknowns live at `coordinates`; without them unknowns are taken as triples, or one by one where their
    /// number is no multiple of three.
    ///
    /// # Errors
    /// [`SetupError::Shape`], [`SetupError::NotFinite`], [`SetupError::NotApplicable`] beyond 32-bit indices.
    pub(super) fn new(
        a: &SparseMatrix<f64>,
        coordinates: Option<&[DofCoordinate]>,
        method: &'static str,
    ) -> Result<Self, SetupError> {
        let a = rows(a)?;
        if coordinates.is_none() && !a.rows().is_multiple_of(3) {
            return Self::one_by_one(&a, method);
        }
        let map = NodeMap::new(&a, coordinates);
        let (nodes, slots) = (map.nodes(), map.slots());
        index(3 * nodes, method)?;
        let mut out = Self {
            block: 3,
            offsets: vec![0],
            columns: Vec::new(),
            values: Vec::new(),
            slots: slots.to_vec(),
            positions: map.positions().map_or(vec![], |p| p.concat()),
        };
        // where the blocks of a neighbour stand in the rows of a node
        let mut place = vec![usize::MAX; nodes];
        let mut around = Vec::new();
        for node in 0..nodes {
            let unknowns = map.of_node(node);
            let free = |c: usize| (unknowns[c] != crate::multigrid::NONE).then_some(unknowns[c]);
            around.clear();
            around.push(node);
            place[node] = 0;
            for row in (0..3)
                .filter_map(free)
                .filter_map(|i| a.outer_view(i as usize))
            {
                for j in row.indices() {
                    let other = slots[*j as usize] as usize / 3;
                    if place[other] == usize::MAX {
                        place[other] = 0;
                        around.push(other);
                    }
                }
            }
            around.sort_unstable();
            around.iter().enumerate().for_each(|(k, n)| place[*n] = k);
            let mut diagonals = (0.0, 0.0);
            let begin = out.values.len();
            let width = 3 * around.len();
            for c in 0..3 {
                let start = out.values.len();
                for n in &around {
                    out.columns.extend((0..3).map(|d| (3 * n + d) as i32));
                }
                out.values.resize(start + width, 0.0);
                out.offsets.push(index(out.values.len(), method)?);
                let row = free(c).and_then(|i| a.outer_view(i as usize));
                for (j, v) in row.iter().flat_map(|row| row.iter()) {
                    let slot = slots[j] as usize;
                    out.values[start + 3 * place[slot / 3] + slot % 3] = *v;
                    if slot == 3 * node + c {
                        diagonals = (diagonals.0 + v, diagonals.1 + 1.0);
                    }
                }
            }
            for c in (0..3).filter(|c| free(*c).is_none()) {
                // the scale of the node
                out.values[begin + c * width + 3 * place[node] + c] = diagonals.0 / diagonals.1;
            }
            around.iter().for_each(|n| place[*n] = usize::MAX);
        }
        Ok(out)
    }

    fn one_by_one(a: &SparseMatrix<f64>, method: &'static str) -> Result<Self, SetupError> {
        let indptr = a.proper_indptr();
        let offsets = indptr.iter().map(|o| index(*o, method));
        Ok(Self {
            block: 1,
            offsets: offsets.collect::<Result<_, _>>()?,
            columns: a.indices().iter().map(|j| *j as i32).collect(),
            values: a.data().to_vec(),
            slots: (0..a.rows() as u32).collect(),
            positions: vec![],
        })
    }

    /// Rows.
    pub(super) fn size(&self) -> usize {
        self.offsets.len() - 1
    }
}

/// A number as PETSc stores it.
pub(crate) fn index(k: usize, method: &'static str) -> Result<i32, SetupError> {
    i32::try_from(k).map_err(|_| SetupError::NotApplicable {
        method,
        reason: format!(
            "PETSc counts entries in 32 bits here and the matrix has {k} or more; take inner = \"amg\" or \"geometric\""
        ),
    })
}
