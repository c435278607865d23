//! LLᵀ with factors in f32, for preconditioners.

use super::{Scratch, work_entries};
use faer::dyn_stack::StackReq;
use faer::sparse::linalg::cholesky::{LltRef, SymbolicCholesky};
use faer::{Conj, MatMut, Par};
use fracas_operators::{Preconditioner, Properties};
use std::sync::Arc;

/// Smallest pivot, over the largest one, from which factors may be rounded: what f32 leaves of it has four digits. Unit: 1.
const FAR_FROM_SINGULAR: f64 = 1e-3;

/// `P A Pᵀ ≈ L Lᵀ`, L rounded: positive definite, as A is.
#[derive(Debug)]
pub(super) struct SingleFactors {
    structure: Arc<SymbolicCholesky<usize>>,
    values: Vec<f32>,
}

impl SingleFactors {
    /// Of factors in f64 with these pivots; `None` where too few digits would be left.
    pub(super) fn new(
        structure: &Arc<SymbolicCholesky<usize>>,
        values: &[f64],
        pivots: &[f64],
    ) -> Option<Self> {
        let largest = pivots.iter().copied().fold(0.0, f64::max);
        let is_far = pivots.iter().all(|p| *p >= FAR_FROM_SINGULAR * largest);
        let in_range = (1e-15..1e15).contains(&largest);
        (is_far && in_range).then(|| Self {
            structure: structure.clone(),
            values: values.iter().map(|v| *v as f32).collect(),
        })
    }
}

impl Preconditioner<f64> for SingleFactors {
    fn size(&self) -> usize {
        self.structure.nrows()
    }

    fn solve(&self, r: &[f64], z: &mut [f64], work: &mut [f64]) {
        let mut scratch = Scratch::new(work);
        let (mut single, stack) = scratch.stack().make_with(r.len(), |i| r[i] as f32);
        LltRef::new(&self.structure, &self.values).solve_in_place_with_conj(
            Conj::No,
            MatMut::from_column_major_slice_mut(&mut single, r.len(), 1),
            Par::Seq,
            stack,
        );
        let rounded = single.iter().map(|s| f64::from(*s));
        z.iter_mut().zip(rounded).for_each(|(z, s)| *z = s);
    }

    fn work_len(&self) -> usize {
        let vector = StackReq::new::<f32>(self.size());
        let scratch = self.structure.solve_in_place_scratch::<f32>(1, Par::Seq);
        work_entries(vector.and(scratch))
    }

    fn flops(&self) -> u64 {
        4 * self.values.len() as u64
    }

    fn properties(&self) -> Properties {
        Properties::LINEAR.and(Properties::SINGLE)
    }
}
