//! All eigenvalues of M⁻¹𝒜 at once.

use super::form::Statements;
use super::laboratory::{S_U, Structure, by_cholesky};
use super::modes::{self, Judge};
use super::report::SpectrumReport;
use super::similarity::Similarity;
use super::{Hypothesis, SpectrumRequest, field_of_values};
use crate::SetupError;
use crate::eigen::dense;
use crate::saddle::{AugmentationMatrix, InnerChoice, SaddleBlocks};
use faer::{Mat, c64};
use fracas_operators::{Dense, Preconditioner};

/// All eigenvalues of T, or of M⁻¹𝒜 in energy scales when S̃_u is not SPD.
pub(super) fn dense_eigenvalues(
    report: &mut SpectrumReport,
    blocks: &SaddleBlocks,
    c: &AugmentationMatrix,
    request: &SpectrumRequest,
    inner: &dyn Preconditioner<f64>,
    structure: &Structure,
    judge: &Judge<'_>,
    (p, statements): (&dyn Fn(f64) -> f64, &mut Option<Statements>),
) -> Result<Vec<c64>, SetupError> {
    let matrix = match Similarity::new(blocks, c, request.inner, inner) {
        Ok(similarity) => {
            report.hypotheses.push(match request.inner {
                InnerChoice::Exact { .. } => by_cholesky(),
                _ => Hypothesis::new(S_U, true, "Cholesky factorization of S̃_u⁻¹"),
            });
            let whole = |(u, t): (Vec<f64>, Vec<f64>)| [u, t].concat();
            if structure.symmetric {
                let form = similarity.form(p)?;
                let matrix = form.matrix();
                let back = |v: &[f64]| whole(similarity.back_of(&form, v));
                report.modes = modes::of_dense(&request.modes, &matrix, back, judge)?;
                *statements = Some(form.statements()?);
                matrix
            } else {
                let matrix = similarity.matrix();
                let back = |v: &[f64]| whole(similarity.back(v));
                report.modes = modes::of_dense(&request.modes, &matrix, back, judge)?;
                report.field_of_values = Some(field_of_values::of_matrix(
                    matrix.as_ref(),
                    field_of_values::OF_SIMILARITY,
                )?);
                matrix
            }
        }
        Err(SetupError::NotApplicable { reason, .. }) if inner.properties().linear => {
            report.notes.push(format!(
                "{reason}: eigenvalues of M⁻¹𝒜 itself, no bounds, no modes"
            ));
            report.hypotheses.push(Hypothesis::new(S_U, false, reason));
            let product = Dense::of_operator(judge.operator);
            let (n, d) = (judge.scales.len(), judge.scales);
            Mat::from_fn(n, n, |i, j| d[i] * product.entry(i, j) / d[j])
        }
        Err(error) => return Err(error),
    };
    dense::general_eigenvalues(matrix.as_ref())
}
