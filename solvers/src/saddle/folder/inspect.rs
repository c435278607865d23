//! What is remarkable about the blocks.

use super::compare::{asymmetry, largest_difference};
use super::finding::{Finding, Remark};
use super::{FolderError, SYMMETRY_TOLERANCE};
use crate::saddle::FlowBlocks;
use fracas_operators::matrix_market::Symmetry;
use fracas_operators::sparse::SparseMatrix;
use std::collections::HashMap;
use std::hash::{DefaultHasher, Hash, Hasher};

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

/// Columns of one pattern that a further one is compared with: a face has three.
const ALIKE: usize = 16;

/// More columns of B1 than rows, where there is no H.
pub(super) fn rank(
    b1: &SparseMatrix<f64>,
    h: Option<&SparseMatrix<f64>>,
    findings: &mut Vec<Finding>,
) {
    let (n_u, n_t) = (b1.rows(), b1.cols());
    if n_t > n_u && h.is_none() {
        findings.push(Finding::file(
            "B1.mtx",
            Remark::TooManyTractions { n_t, n_u },
        ));
    }
}

/// B1: columns without entries, and columns that are multiples of others.
pub(super) fn coupling(b1: &SparseMatrix<f64>, findings: &mut Vec<Finding>) {
    const FILE: &str = "B1.mtx";
    let columns: SparseMatrix<f64> = b1.transpose_view().to_csr();
    let (mut empty, mut equal) = (Tally::default(), Tally::default());
    let entries = |j: usize| {
        let range = columns.indptr().outer_inds_sz(j);
        let rows = columns.indices()[range.clone()].iter().copied();
        rows.zip(&columns.data()[range])
            .filter(|(_, value)| **value != 0.0)
    };
    // first columns of every pattern, by its hash
    let mut seen: HashMap<u64, Vec<usize>> = HashMap::new();
    for j in 0..columns.rows() {
        let mut hasher = DefaultHasher::new();
        entries(j).for_each(|(i, _)| i.hash(&mut hasher));
        if entries(j).next().is_none() {
            empty.count(j, 0.0);
            continue;
        }
        let alike = seen.entry(hasher.finish()).or_default();
        match alike
            .iter()
            .take(ALIKE)
            .find(|of| are_multiples(entries(j), entries(**of)))
        {
            Some(of) => equal.count(j, *of as f64),
            None => alike.push(j),
        }
    }
    if let Some((first, _)) = empty.first {
        let count = empty.count;
        findings.push(Finding::at_column(
            FILE,
            first,
            Remark::EmptyColumns { count },
        ));
    }
    if let Some((first, of)) = equal.first {
        let (count, of) = (equal.count, 1 + of as usize);
        findings.push(Finding::at_column(
            FILE,
            first,
            Remark::EqualColumns { count, of },
        ));
    }
}

/// True where x = α y to rounding, entries of the same rows.
fn are_multiples<'v, E: Iterator<Item = (u32, &'v f64)> + Clone>(x: E, y: E) -> bool {
    let larger = |m: f64, (_, v): (u32, &f64)| if v.abs() > m.abs() { *v } else { m };
    let (a, b) = (x.clone().fold(0.0, larger), y.clone().fold(0.0, larger));
    let apart = |((i, x), (j, y)): ((u32, &f64), (u32, &f64))| {
        i != j || (x / a - y / b).abs() > 8.0 * f64::EPSILON
    };
    x.clone().count() == y.clone().count() && !x.zip(y).any(apart)
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
    let (mut negative, mut any_positive) = (Tally::default(), false);
    for i in 0..h.rows() {
        match h.get(i, i) {
            Some(value) if *value < 0.0 => negative.count(i, *value),
            Some(value) => any_positive |= *value > 0.0,
            None => {}
        }
    }
    let remark = |count, value| match any_positive {
        true => Remark::NegativeDiagonal { count, value },
        false => Remark::OppositeSign { count, value },
    };
    negative.report(findings, remark, FILE);
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
