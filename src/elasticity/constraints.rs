//! Prescribed displacements and the numbering of the free ones.

/// Which displacement unknowns are prescribed, and the numbering of the others.
///
/// Full numbering: `3·node + component`. Free numbering: the full one with prescribed rows removed, order kept.
#[derive(Clone, Debug, PartialEq)]
pub struct Constraints {
    prescribed: Vec<Option<f64>>,
    free: Vec<u32>,
    index: Vec<u32>,
}

/// Mark of a prescribed unknown in [`Constraints::free_index`]'s table.
const PRESCRIBED: u32 = u32::MAX;

impl Constraints {
    /// `prescribed[3·node + component]` is the displacement [m] where one is given.
    pub fn new(prescribed: Vec<Option<f64>>) -> Self {
        let mut free = Vec::new();
        let index = prescribed
            .iter()
            .enumerate()
            .map(|(dof, value)| match value {
                Some(_) => PRESCRIBED,
                None => {
                    free.push(dof as u32);
                    free.len() as u32 - 1
                }
            })
            .collect();
        Self {
            prescribed,
            free,
            index,
        }
    }

    /// No constraint on any of `n` unknowns.
    pub fn none(n: usize) -> Self {
        Self::new(vec![None; n])
    }

    /// Unknowns before removing prescribed ones.
    pub fn full_len(&self) -> usize {
        self.prescribed.len()
    }

    /// Free unknowns: n_u.
    pub fn free_len(&self) -> usize {
        self.free.len()
    }

    /// Full numbers of the free unknowns, increasing.
    pub fn free(&self) -> &[u32] {
        &self.free
    }

    /// Free number of a full one, or `None` where it is prescribed.
    pub fn free_index(&self, dof: usize) -> Option<usize> {
        match self.index[dof] {
            PRESCRIBED => None,
            i => Some(i as usize),
        }
    }

    /// Prescribed value of a full unknown [m], if any.
    pub fn value(&self, dof: usize) -> Option<f64> {
        self.prescribed[dof]
    }

    /// Spreads free values into a full vector, prescribed entries taking their values.
    pub fn expand(&self, free_values: &[f64]) -> Vec<f64> {
        let mut full: Vec<f64> = self.prescribed.iter().map(|v| v.unwrap_or(0.0)).collect();
        for (dof, value) in self.free.iter().zip(free_values) {
            full[*dof as usize] = *value;
        }
        full
    }
}
