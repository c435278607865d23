//! Rows on a given pattern.

use super::growing::{Growing, NotPositive};
use super::inverse::{Row, RowBuilder};
use super::pattern::Pattern;
use fracas_operators::sparse::SparseMatrix;

/// A column outside P.
const NONE: u32 = u32::MAX;

/// Solves one row after the other on its pattern; its memory is used again.
pub(super) struct StaticRows<'a> {
    a: &'a SparseMatrix<f64>,
    diagonal: &'a [f64],
    pattern: &'a Pattern,
    system: Growing,
    /// Place in P of every column of A.
    places: Vec<u32>,
    y: Vec<f64>,
}

impl<'a> StaticRows<'a> {
    pub(super) fn new(a: &'a SparseMatrix<f64>, diagonal: &'a [f64], pattern: &'a Pattern) -> Self {
        Self {
            a,
            diagonal,
            pattern,
            system: Growing::default(),
            places: vec![NONE; a.rows()],
            y: Vec::new(),
        }
    }

    /// Takes the columns of P in, one after the other.
    fn fill(&mut self, i: usize, columns: &[u32]) -> Result<(), NotPositive> {
        let (offsets, places) = (self.a.indptr(), &mut self.places);
        let offsets = offsets.raw_storage();
        self.system.start(self.diagonal[i]);
        for (place, j) in columns.iter().enumerate() {
            let j = *j as usize;
            let range = offsets[j]..offsets[j + 1];
            let (row, values) = (&self.a.indices()[range.clone()], &self.a.data()[range]);
            let a_ij = row.binary_search(&(i as u32)).map_or(0.0, |k| values[k]);
            self.system.append(a_ij, self.diagonal[j], |a_pj| {
                for (l, value) in row.iter().zip(values) {
                    let place = places[*l as usize];
                    if place != NONE {
                        a_pj[place as usize] = *value;
                    }
                }
            })?;
            places[j] = place as u32;
        }
        Ok(())
    }
}

impl RowBuilder for StaticRows<'_> {
    fn row(&mut self, i: usize, out: &mut Row) -> Result<f64, NotPositive> {
        let columns = self.pattern.row(i);
        let filled = self.fill(i, columns);
        columns.iter().for_each(|j| self.places[*j as usize] = NONE);
        filled?;
        self.system.solve(&mut self.y);
        out.extend(columns.iter().copied().zip(self.y.iter().copied()));
        Ok(self.system.psi())
    }
}
