//! The spectrum of M⁻¹𝒜 for any preconditioner of the list.

use super::laboratory::{Stages, simplified, stiffness_condition};
use super::modes::Judge;
use super::product::{Preconditioned, energy_scales};
use super::report::{Eigenvalues, Method, Parts, SpectrumReport};
use super::{SpectrumRequest, analyse, field_of_values, iterative, modes};
use crate::direct::DirectChoice;
use crate::eigen::dense;
use crate::saddle::{Elimination, SaddleBlocks, SaddleMethod};
use crate::words::by_number;
use crate::{Observer, SetupError};
use faer::Mat;
use fracas_operators::Dense;

/// Analyses M⁻¹𝒜 for `method`: [`analyse`] with its C, its relaxation of H and its S̃_u where it is RACP; otherwise, and where
/// RACP eliminates rows of slip and opening, relaxes H beside an unsymmetric block or meets flow, the eigenvalues alone, since no bound
/// is stated. `request` says the dense limit; its modes need RACP without such rows, or flow.
///
/// # Errors
/// Those of the method; [`SetupError::NotApplicable`] for a preconditioner that is no linear map, and for modes of
/// anything but RACP.
pub fn analyse_method(
    blocks: &SaddleBlocks,
    method: &SaddleMethod,
    request: &SpectrumRequest,
    observer: &mut dyn Observer,
) -> Result<SpectrumReport, SetupError> {
    let eliminated = Elimination::new(blocks).map_or(0, |e| e.rows().len());
    if let (SaddleMethod::Racp(racp), 0, None) = (method, eliminated, &blocks.flow)
        && (racp.relaxation == 0.0 || simplified(blocks).1.symmetric)
    {
        let request = SpectrumRequest {
            augmentation: racp.augmentation,
            relaxation: racp.relaxation,
            inner: racp.inner,
            ..request.clone()
        };
        return analyse(blocks, &request, observer);
    }
    let no = |reason: &str| SetupError::NotApplicable {
        method: "this spectrum",
        reason: reason.to_owned(),
    };
    if !request.modes.is_empty() && blocks.flow.is_none() {
        return Err(no(
            "eigenvectors are computed for method = \"racp\" and \"racp:published\" only, and for systems without rows of slip or opening",
        ));
    }
    if request.certify {
        return Err(SetupError::NotApplicable {
            method: "certify",
            reason: "M has no explicit blocks; take method = \"racp:published\" with inner = \"exact\", and a system without rows of slip, opening or flow".to_owned(),
        });
    }
    let mut stages = Stages { observer, done: 0 };
    let (blocks, structure, notes) = simplified(blocks);
    let m = method.ready(&blocks)?.inverse;
    if !m.properties().linear {
        return Err(no(
            "the preconditioner is no linear map, so it has no eigenvalues; take a V or W cycle",
        ));
    }
    stages.next("preconditioner");
    let name = |part: Option<String>| part.unwrap_or_else(|| "none".to_owned());
    let parts = Parts {
        preconditioner: method.to_string(),
        augmentation: name(method.augmentation().map(|c| c.to_string())),
        inner: name(method.inner().map(|inner| inner.to_string())),
        c_extremes: (f64::NAN, f64::NAN),
    };
    let mut report = SpectrumReport::empty(&blocks, parts, notes);
    report
        .notes
        .push("no bound is proved for this method".to_owned());
    if eliminated > 0 && matches!(method, SaddleMethod::Racp(_)) {
        report.notes.push(format!(
            "{eliminated} {} own traction (slip, open), {} eliminated and {} 1",
            by_number(eliminated, "row determines its", "rows determine their"),
            by_number(eliminated, "is", "are"),
            by_number(
                eliminated,
                "counts as an eigenvalue",
                "count as eigenvalues"
            )
        ));
    }
    if request.conditions {
        stiffness_condition(
            &mut report,
            &blocks,
            DirectChoice::default().solver()?.as_ref(),
        );
    }
    stages.next("condition numbers");
    let operator = Preconditioned::new(&blocks, m.as_ref());
    let scales = energy_scales(&blocks, &traction_scales(&blocks));
    let n = scales.len();
    let mut unsettled = Vec::new();
    let eigenvalues = if n <= request.dense_limit {
        let product = Dense::of_operator(&operator);
        let d = &scales;
        let matrix = Mat::from_fn(n, n, |i, j| d[i] * product.entry(i, j) / d[j]);
        if !structure.symmetric || blocks.flow.is_some() {
            report.field_of_values = Some(field_of_values::of_matrix(
                matrix.as_ref(),
                field_of_values::OF_SCALES,
            )?);
        }
        let judge = Judge {
            operator: &operator,
            scales: d,
            layout: blocks.layout(),
        };
        let back = |v: &[f64]| v.iter().zip(d).map(|(v, d)| v / d).collect();
        report.modes = modes::of_dense(&request.modes, &matrix, back, &judge)?;
        dense::general_eigenvalues(matrix.as_ref())?
    } else {
        report.method = Method::Iterative;
        let outer = iterative::outer_eigenvalues(&operator, &scales)?;
        report.notes.push(format!(
            "{n} unknowns are more than the dense limit {}: {} outer Ritz values with residuals below {:.1e}",
            request.dense_limit,
            outer.values.len(),
            outer.residual
        ));
        unsettled = outer.unsettled;
        outer.values
    };
    stages.next("eigenvalues");
    report.judge(Eigenvalues::sorted(eigenvalues), &unsettled);
    report.non_normal(request, &operator, m.as_ref(), &blocks)?;
    Ok(report)
}

/// `|H_kk| + Σ_i b_ik² / a_ii`: a size of the Schur complement in which tractions are measured; 1 where it vanishes.
pub(super) fn traction_scales(blocks: &SaddleBlocks) -> Vec<f64> {
    let mut scales: Vec<f64> = (0..blocks.n_t())
        .map(|k| {
            let h_kk = blocks.h.as_ref().and_then(|h| h.get(k, k));
            h_kk.map_or(0.0, |h| h.abs())
        })
        .collect();
    for (i, row) in blocks.b1.outer_iterator().enumerate() {
        if let Some(a_ii) = blocks.a.get(i, i).filter(|a_ii| **a_ii > 0.0) {
            row.iter().for_each(|(k, b)| scales[k] += b * b / a_ii);
        }
    }
    for scale in &mut scales {
        if *scale == 0.0 {
            *scale = 1.0;
        }
    }
    scales
}
