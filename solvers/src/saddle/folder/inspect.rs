//! What is remarkable about the blocks.

use super::compare::{asymmetry, largest_difference};
use super::finding::{Finding, Remark};
use super::{FolderError, SYMMETRY_TOLERANCE};
use crate::saddle::FlowBlocks;
use fracas_operators::matrix_market::Symmetry;
use fracas_operators::sparse::SparseMatrix;

/// A: symmetric (an error otherwise), nonzero rows, a diagonal that a semi-definite matrix can have.
pub(super) fn stiffness(
    a: &SparseMatrix<f64>,
    storage: Symmetry,
    b1: &SparseMatrix<f64>,
    findings: &mut Vec<Finding>,
) -> Result<(), FolderError> {
    const FILE: &str = "A.mtx";
    // one triangle was read and mirrored: nothing to compare
    let mirrored = storage == Symmetry::Symmetric;
    if let Some(worst) = (!mirrored).then(|| asymmetry(a)).flatten() {
        if worst.relative > SYMMETRY_TOLERANCE {
            return Err(FolderError::Asymmetric {
                file: FILE,
                row: worst.row + 1,
                column: worst.column + 1,
                value: worst.x,
                mirrored: worst.y,
            });
        }
        let remark = Remark::SymmetricToRounding {
            relative: worst.relative,
        };
        findings.push(Finding::at_entry(FILE, worst.row, worst.column, remark));
    } else if storage == Symmetry::General {
        findings.push(Finding::file(
            FILE,
            Remark::SymmetricToRounding { relative: 0.0 },
        ));
    }
    let (mut zero, mut bad, mut constrained) =
        (Tally::default(), Tally::default(), Tally::default());
    for (i, (row, coupling)) in a.outer_iterator().zip(b1.outer_iterator()).enumerate() {
        let diagonal = row.get(i).copied().unwrap_or(0.0);
        let nonzeros = row.data().iter().filter(|v| **v != 0.0).count();
        match nonzeros {
            0 => zero.count(i, 0.0),
            _ if diagonal <= 0.0 => bad.count(i, diagonal),
            1 if coupling.data().iter().all(|v| *v == 0.0) => constrained.count(i, diagonal),
            _ => {}
        }
    }
    zero.report(findings, |count, _| Remark::ZeroRows { count }, FILE);
    bad.report(
        findings,
        |count, value| Remark::BadDiagonal { count, value },
        FILE,
    );
    constrained.report(findings, |count, _| Remark::ConstrainedRows { count }, FILE);
    Ok(())
}

/// Places with a common defect: how many, and the first with its value.
#[derive(Default)]
struct Tally {
    count: usize,
    first: Option<(usize, f64)>,
}

impl Tally {
    fn count(&mut self, place: usize, value: f64) {
        self.count += 1;
        self.first.get_or_insert((place, value));
    }

    fn report(
        &self,
        findings: &mut Vec<Finding>,
        remark: impl Fn(usize, f64) -> Remark,
        file: &str,
    ) {
        if let Some((row, value)) = self.first {
            findings.push(Finding::at_row(file, row, remark(self.count, value)));
        }
    }
}

/// B1: columns without entries.
pub(super) fn coupling(b1: &SparseMatrix<f64>, findings: &mut Vec<Finding>) {
    let mut touched = vec![false; b1.cols()];
    for (value, (_, j)) in b1 {
        touched[j as usize] |= *value != 0.0;
    }
    if let Some(first) = touched.iter().position(|t| !t) {
        let count = touched.iter().filter(|t| !**t).count();
        findings.push(Finding::at_column(
            "B1.mtx",
            first,
            Remark::EmptyColumns { count },
        ));
    }
}

/// B2: `None` when it repeats B1ᵀ.
pub(super) fn consistency(
    b2: SparseMatrix<f64>,
    b1: &SparseMatrix<f64>,
    findings: &mut Vec<Finding>,
) -> Option<SparseMatrix<f64>> {
    const FILE: &str = "B2.mtx";
    let b1_t = b1.transpose_view().to_csr();
    let largest: Vec<f64> = b1_t
        .outer_iterator()
        .map(|row| {
            row.data()
                .iter()
                .fold(f64::MIN_POSITIVE, |m, v| m.max(v.abs()))
        })
        .collect();
    match largest_difference(&b2, &b1_t, |i, _| largest[i]) {
        Some(worst) if worst.relative > SYMMETRY_TOLERANCE => {
            let negative = b1_t.map(|v| -v);
            let opposite = largest_difference(&b2, &negative, |i, _| largest[i])
                .is_none_or(|d| d.relative <= SYMMETRY_TOLERANCE);
            findings.push(if opposite {
                Finding::file(FILE, Remark::EqualsNegativeTranspose)
            } else {
                let remark = Remark::DiffersFromTranspose {
                    b2: worst.x,
                    b1: worst.y,
                };
                Finding::at_entry(FILE, worst.row, worst.column, remark)
            });
            Some(b2)
        }
        _ => {
            findings.push(Finding::file(FILE, Remark::EqualsTranspose));
            None
        }
    }
}

/// H: `None` when it holds no nonzero entry.
pub(super) fn stabilization(
    h: SparseMatrix<f64>,
    findings: &mut Vec<Finding>,
) -> Option<SparseMatrix<f64>> {
    const FILE: &str = "H.mtx";
    if h.data().iter().all(|v| *v == 0.0) {
        findings.push(Finding::file(FILE, Remark::Zero));
        return None;
    }
    if let Some(worst) = asymmetry(&h).filter(|w| w.relative > SYMMETRY_TOLERANCE) {
        let remark = Remark::Unsymmetric {
            value: worst.x,
            mirrored: worst.y,
        };
        findings.push(Finding::at_entry(FILE, worst.row, worst.column, remark));
    }
    let mut negative = Tally::default();
    for i in 0..h.rows() {
        match h.get(i, i) {
            Some(value) if *value < 0.0 => negative.count(i, *value),
            _ => {}
        }
    }
    negative.report(
        findings,
        |count, value| Remark::NegativeDiagonal { count, value },
        FILE,
    );
    Some(h)
}

/// Q1, Q2 and T: pressures that nothing determines, signs.
pub(super) fn flow(flow: &FlowBlocks, findings: &mut Vec<Finding>) {
    let (mut free, mut closing, mut negative) =
        (Tally::default(), Tally::default(), Tally::default());
    let columns: SparseMatrix<f64> = flow.q1.transpose_view().to_csr();
    let rows = (flow.t.outer_iterator()).zip(flow.q2.outer_iterator());
    for (i, ((t, q2), q1)) in rows.zip(columns.outer_iterator()).enumerate() {
        let is_empty = |values: &[f64]| values.iter().all(|v| *v == 0.0);
        if is_empty(t.data()) && is_empty(q2.data()) {
            free.count(i, 0.0);
        }
        let product = q2.dot(&q1);
        if product > 0.0 {
            closing.count(i, product);
        }
        if let Some(t_ii) = t.get(i).filter(|t_ii| **t_ii < 0.0) {
            negative.count(i, *t_ii);
        }
    }
    free.report(
        findings,
        |count, _| Remark::UndeterminedPressures { count },
        "T.mtx",
    );
    negative.report(
        findings,
        |count, value| Remark::NegativeDiagonalOfT { count, value },
        "T.mtx",
    );
    closing.report(
        findings,
        |count, _| Remark::ClosingPressures { count },
        "Q2.mtx",
    );
}
