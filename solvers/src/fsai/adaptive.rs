//! Rows whose pattern grows along the Kaporin gradient.

use super::Adaptive;
use super::growing::{Growing, NotPositive};
use super::inverse::{Row, RowBuilder};
use fracas_operators::sparse::SparseMatrix;

/// A column without a slot, a slot outside P.
const NONE: u32 = u32::MAX;

/// Grows the pattern of one row after the other; its memory is used again.
///
/// Columns that any row of P reaches have a slot, so that the gradient is a short dense vector.
pub(super) struct GrowingRows<'a> {
    a: &'a SparseMatrix<f64>,
    diagonal: &'a [f64],
    settings: Adaptive,
    system: Growing,
    /// Slot of every column of A.
    slots: Vec<u32>,
    /// Per slot: column, 1/a_jj, a_ij, gradient, place in P.
    columns: Vec<u32>,
    inverse_jj: Vec<f64>,
    a_ij: Vec<f64>,
    gradient: Vec<f64>,
    places: Vec<u32>,
    /// Rows l ∈ P of A left of column i, by slots.
    offsets: Vec<usize>,
    row_slots: Vec<u32>,
    row_values: Vec<f64>,
    chosen: Vec<u32>,
    y: Vec<f64>,
    y_new: Vec<f64>,
}

impl<'a> GrowingRows<'a> {
    pub(super) fn new(a: &'a SparseMatrix<f64>, diagonal: &'a [f64], settings: Adaptive) -> Self {
        Self {
            a,
            diagonal,
            settings,
            system: Growing::default(),
            slots: vec![NONE; a.rows()],
            columns: Vec::new(),
            inverse_jj: Vec::new(),
            a_ij: Vec::new(),
            gradient: Vec::new(),
            places: Vec::new(),
            offsets: Vec::new(),
            row_slots: Vec::new(),
            row_values: Vec::new(),
            chosen: Vec::new(),
            y: Vec::new(),
            y_new: Vec::new(),
        }
    }

    fn start(&mut self, i: usize) {
        for j in self.columns.drain(..) {
            self.slots[j as usize] = NONE;
        }
        self.inverse_jj.clear();
        self.a_ij.clear();
        self.gradient.clear();
        self.places.clear();
        self.offsets.clear();
        self.offsets.push(0);
        self.row_slots.clear();
        self.row_values.clear();
        self.chosen.clear();
        self.y.clear();
        self.system.start(self.diagonal[i]);
        let (columns, values) = left_of(self.a, i, i);
        for (j, a_ij) in columns.iter().zip(values) {
            let slot = self.slot(*j);
            self.a_ij[slot] = *a_ij;
            self.gradient[slot] = *a_ij;
        }
    }

    /// The slot of a column, a new one if it has none.
    #[inline(always)]
    fn slot(&mut self, j: u32) -> usize {
        let slot = self.slots[j as usize];
        if slot != NONE {
            return slot as usize;
        }
        let slot = self.columns.len();
        self.slots[j as usize] = slot as u32;
        self.columns.push(j);
        self.inverse_jj.push(self.diagonal[j as usize].recip());
        self.a_ij.push(0.0);
        self.gradient.push(0.0);
        self.places.push(NONE);
        slot
    }

    /// The slot outside P with the largest `g_j²/a_jj > 0`; among equals the smallest column.
    fn steepest(&self) -> Option<usize> {
        let mut best: Option<(usize, f64)> = None;
        for slot in 0..self.columns.len() {
            if self.places[slot] != NONE {
                continue;
            }
            let gain = self.gradient[slot] * self.gradient[slot] * self.inverse_jj[slot];
            let better = best.is_none_or(|(other, most)| {
                gain > most || (gain == most && self.columns[slot] < self.columns[other])
            });
            if gain > 0.0 && better {
                best = Some((slot, gain));
            }
        }
        best.map(|(slot, _)| slot)
    }

    /// Takes the column of a slot into P.
    fn take(&mut self, slot: usize, i: usize) -> Result<(), NotPositive> {
        let j = self.columns[slot] as usize;
        let (columns, values) = left_of(self.a, j, i);
        let first = self.row_slots.len();
        for (l, value) in columns.iter().zip(values) {
            let slot = self.slot(*l) as u32;
            self.row_slots.push(slot);
            self.row_values.push(*value);
        }
        self.offsets.push(self.row_slots.len());
        let (row_slots, row_values) = (&self.row_slots[first..], &self.row_values[first..]);
        let places = &self.places;
        self.system
            .append(self.a_ij[slot], self.diagonal[j], |a_pj| {
                for (other, value) in row_slots.iter().zip(row_values) {
                    let place = places[*other as usize];
                    if place != NONE {
                        a_pj[place as usize] = *value;
                    }
                }
            })?;
        self.places[slot] = self.chosen.len() as u32;
        self.chosen.push(slot as u32);
        Ok(())
    }

    /// Solves for y and brings the gradient along: `g ← g + Σ_l (y_l − y_l before) a_l`.
    fn advance(&mut self) {
        self.system.solve(&mut self.y_new);
        for (l, y_new) in self.y_new.iter().enumerate() {
            let change = y_new - self.y.get(l).copied().unwrap_or(0.0);
            let range = self.offsets[l]..self.offsets[l + 1];
            for (slot, a_lj) in self.row_slots[range.clone()]
                .iter()
                .zip(&self.row_values[range])
            {
                self.gradient[*slot as usize] += change * a_lj;
            }
        }
        std::mem::swap(&mut self.y, &mut self.y_new);
    }
}

impl RowBuilder for GrowingRows<'_> {
    fn row(&mut self, i: usize, out: &mut Row) -> Result<f64, NotPositive> {
        self.start(i);
        for step in 0..self.settings.steps {
            if step > 0 {
                self.advance();
            }
            let before = self.system.psi();
            for _ in 0..self.settings.entries_per_step {
                // columns that this step has brought in have no gradient yet
                let Some(slot) = self.steepest() else { break };
                self.take(slot, i)?;
            }
            if before - self.system.psi() <= self.settings.epsilon * before {
                break;
            }
        }
        self.system.solve(&mut self.y);
        let columns = self.chosen.iter().map(|slot| self.columns[*slot as usize]);
        out.extend(columns.zip(self.y.iter().copied()));
        out.sort_unstable_by_key(|entry| entry.0);
        Ok(self.system.psi())
    }
}

/// Columns and values of row l of A left of column i.
fn left_of(a: &SparseMatrix<f64>, l: usize, i: usize) -> (&[u32], &[f64]) {
    let offsets = a.indptr();
    let offsets = offsets.raw_storage();
    let columns = &a.indices()[offsets[l]..offsets[l + 1]];
    let len = columns.partition_point(|j| (*j as usize) < i);
    (&columns[..len], &a.data()[offsets[l]..][..len])
}
