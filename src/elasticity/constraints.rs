//! Prescribed displacements and the numbering of the free ones.

use std::sync::Arc;

/// Which displacement unknowns are prescribed, and the numbering of the others.
///
/// Full numbering: `3·node + component`. Free numbering: the full one with prescribed rows removed, order kept.
///
/// # Cost
/// 4.2 bytes per unknown, shared by all clones.
#[derive(Clone, Debug, PartialEq)]
pub struct Constraints {
    /// Full numbers and values of the prescribed unknowns, increasing.
    prescribed: Arc<[(u32, f64)]>,
    free: Arc<[u32]>,
    marks: Arc<[Word]>,
    full_len: usize,
}

/// Unknowns of one word of marks.
const BITS: usize = u32::BITS as usize;

/// Marks of 32 consecutive unknowns.
#[derive(Clone, Copy, Debug, PartialEq)]
struct Word {
    /// Set where the unknown is prescribed.
    prescribed: u32,
    /// Prescribed unknowns before these.
    before: u32,
}

impl Constraints {
    /// `prescribed[3·node + component]` is the displacement [m] where one is given.
    pub fn new(prescribed: Vec<Option<f64>>) -> Self {
        let list = prescribed
            .iter()
            .enumerate()
            .filter_map(|(dof, value)| Some((dof as u32, (*value)?)))
            .collect();
        Self::of_list(prescribed.len(), list)
    }

    /// `(3·node + component, displacement [m])` for the prescribed ones of `n` unknowns, in any order; of several values for
    /// one unknown the last one counts.
    pub fn of_list(n: usize, mut prescribed: Vec<(u32, f64)>) -> Self {
        assert!(n < u32::MAX as usize, "{n} unknowns");
        prescribed.sort_by_key(|(dof, _)| *dof);
        // keep the last of equal numbers
        prescribed.reverse();
        prescribed.dedup_by_key(|(dof, _)| *dof);
        prescribed.reverse();
        if let Some((last, _)) = prescribed.last() {
            assert!((*last as usize) < n, "unknown {last} of {n} is prescribed");
        }
        let none = Word {
            prescribed: 0,
            before: 0,
        };
        let mut marks = vec![none; n.div_ceil(BITS)];
        for (dof, _) in &prescribed {
            marks[*dof as usize / BITS].prescribed |= 1 << (*dof as usize % BITS);
        }
        let mut before = 0;
        for word in &mut marks {
            word.before = before;
            before += word.prescribed.count_ones();
        }
        let is_free = |dof: &u32| {
            let word = marks[*dof as usize / BITS].prescribed;
            word >> (*dof as usize % BITS) & 1 == 0
        };
        let mut free = Vec::with_capacity(n - prescribed.len());
        free.extend((0..n as u32).filter(is_free));
        Self {
            free: free.into(),
            marks: marks.into(),
            prescribed: prescribed.into(),
            full_len: n,
        }
    }

    /// No constraint on any of `n` unknowns.
    pub fn none(n: usize) -> Self {
        Self::of_list(n, Vec::new())
    }

    /// The same unknowns prescribed with other values [m], one per entry of [`prescribed`](Self::prescribed).
    #[must_use]
    pub fn with_values(&self, values: impl Fn(usize, f64) -> f64) -> Self {
        let given = self.prescribed.iter().enumerate();
        Self {
            prescribed: given.map(|(i, (dof, u))| (*dof, values(i, *u))).collect(),
            ..self.clone()
        }
    }

    /// Unknowns before removing prescribed ones.
    pub fn full_len(&self) -> usize {
        self.full_len
    }

    /// Free unknowns: n_u.
    pub fn free_len(&self) -> usize {
        self.free.len()
    }

    /// Full numbers of the free unknowns, increasing.
    pub fn free(&self) -> &[u32] {
        &self.free
    }

    /// In the place of a number of [`free_nodes`](Self::free_nodes): no displacement of the node is free.
    pub const NO_NUMBER: u32 = u32::MAX;

    /// Numbers of the nodes with a free displacement, in the order of the mesh, and how many there are.
    pub fn free_nodes(&self) -> (Vec<u32>, usize) {
        let mut numbers = vec![Self::NO_NUMBER; self.full_len / 3];
        self.free
            .iter()
            .for_each(|dof| numbers[*dof as usize / 3] = 0);
        let mut count = 0;
        for number in numbers.iter_mut().filter(|n| **n != Self::NO_NUMBER) {
            *number = count;
            count += 1;
        }
        (numbers, count as usize)
    }

    /// Full numbers and values [m] of the prescribed unknowns, increasing.
    pub fn prescribed(&self) -> &[(u32, f64)] {
        &self.prescribed
    }

    /// True where a displacement is prescribed that is not 0.
    pub fn is_displaced(&self) -> bool {
        self.prescribed.iter().any(|(_, u)| *u != 0.0)
    }

    /// Free number of a full one, or `None` where it is prescribed.
    pub fn free_index(&self, dof: usize) -> Option<usize> {
        assert!(dof < self.full_len, "unknown {dof} of {}", self.full_len);
        let (word, bit) = (self.marks[dof / BITS], dof % BITS);
        if word.prescribed >> bit & 1 == 1 {
            return None;
        }
        let below = word.prescribed & ((1 << bit) - 1);
        Some(dof - (word.before + below.count_ones()) as usize)
    }

    /// Prescribed value of a full unknown [m], if any.
    pub fn value(&self, dof: usize) -> Option<f64> {
        let place = self
            .prescribed
            .binary_search_by_key(&dof, |(dof, _)| *dof as usize);
        Some(self.prescribed[place.ok()?].1)
    }

    /// Spreads free values into a full vector, prescribed entries taking their values.
    pub fn expand(&self, free_values: &[f64]) -> Vec<f64> {
        let mut full = vec![0.0; self.full_len];
        for (dof, value) in self.prescribed.iter() {
            full[*dof as usize] = *value;
        }
        for (dof, value) in self.free.iter().zip(free_values) {
            full[*dof as usize] = *value;
        }
        full
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_numbering_skips_what_is_prescribed_and_the_last_value_counts() {
        for n in [0, 1, 31, 32, 33, 97, 400] {
            let given = |dof: usize| (dof % 5 == 2 || dof / 32 == 3).then_some(dof as f64);
            let mut list: Vec<(u32, f64)> = (0..n)
                .rev()
                .filter(|dof| given(*dof).is_some())
                .map(|dof| (dof as u32, -1.0))
                .collect();
            list.extend((0..n).filter_map(|dof| Some((dof as u32, given(dof)?))));
            let constraints = Constraints::of_list(n, list);
            assert_eq!(constraints, Constraints::new((0..n).map(given).collect()));
            let mut free = 0;
            for dof in 0..n {
                assert_eq!(constraints.value(dof), given(dof));
                let index = given(dof).is_none().then_some(free);
                assert_eq!(constraints.free_index(dof), index);
                if index.is_some() {
                    assert_eq!(constraints.free()[free] as usize, dof);
                    free += 1;
                }
            }
            assert_eq!((constraints.free_len(), constraints.full_len()), (free, n));
            let full = constraints.expand(&vec![0.5; free]);
            let expected: Vec<f64> = (0..n).map(|dof| given(dof).unwrap_or(0.5)).collect();
            assert_eq!(full, expected);
        }
    }
}
