//! Where unknowns stand on the finest level.

use fracas_operators::Real;
use fracas_operators::free_entries;
use fracas_operators::vector::for_row_ranges;
use std::sync::Arc;

/// No unknown.
pub(crate) const NONE: u32 = u32::MAX;

/// Entries that one task copies.
const GRAIN: usize = 1 << 14;

/// A slot for every unknown, other slots empty.
#[derive(Clone, Debug)]
pub struct Slots {
    /// Slot of every unknown.
    pub(crate) of_unknown: Vec<u32>,
    /// Unknown of every slot, or [`NONE`].
    pub(crate) unknowns: Vec<u32>,
}

impl Slots {
    /// From the slot of every unknown, among so many.
    pub(crate) fn new(of_unknown: Vec<u32>, slots: usize) -> Self {
        let mut unknowns = vec![NONE; slots];
        for (i, slot) in of_unknown.iter().enumerate() {
            unknowns[*slot as usize] = i as u32;
        }
        Self {
            of_unknown,
            unknowns,
        }
    }
}

/// Where the unknowns of a system stand on the finest level.
#[derive(Clone, Debug)]
pub enum Places {
    /// In their order, at all components that are not fixed.
    Free,
    /// In slots.
    Slots(Arc<Slots>),
}

impl Places {
    /// Unknowns, on a level of n entries of which these are fixed.
    pub(super) fn unknowns(&self, n: usize, fixed: &[u32]) -> usize {
        match self {
            Self::Free => n - fixed.len(),
            Self::Slots(slots) => slots.of_unknown.len(),
        }
    }

    /// `b ← factor · r` in their places, zero elsewhere.
    pub(super) fn spread<R: Real>(&self, r: &[f64], factor: f64, fixed: &[u32], b: &mut [R]) {
        match self {
            Self::Free => free_entries::spread(r, factor, fixed, b),
            Self::Slots(slots) => for_row_ranges(0, GRAIN, b, &|start, part| {
                for (b, i) in part.iter_mut().zip(&slots.unknowns[start..]) {
                    *b = match *i {
                        NONE => R::zero(),
                        i => R::of(factor * r[i as usize]),
                    };
                }
            }),
        }
    }

    /// `z ← factor · x` from their places.
    pub(super) fn gather<R: Real>(&self, x: &[R], factor: f64, fixed: &[u32], z: &mut [f64]) {
        let value = |x: R| factor * x.to_f64_exact();
        match self {
            Self::Free => free_entries::gather(x, fixed, z, &|x, z| *z = value(x)),
            Self::Slots(slots) => for_row_ranges(0, GRAIN, z, &|start, part| {
                for (z, slot) in part.iter_mut().zip(&slots.of_unknown[start..]) {
                    *z = value(x[*slot as usize]);
                }
            }),
        }
    }
}
