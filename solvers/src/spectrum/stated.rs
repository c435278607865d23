//! What is stated of a spectrum.

use super::form::Statements;
use super::laboratory::Structure;
use super::region::Region;
use super::report::SpectrumReport;
use super::{Bounds, positivity};
use crate::saddle::RelaxationSummary;

/// Intersects the statements that hold.
pub(super) fn state_bounds(
    report: &mut SpectrumReport,
    structure: &Structure,
    statements: Option<Statements>,
    relaxation: RelaxationSummary,
    is_real: bool,
) {
    let holds = report.objection().is_none();
    let ingredients = statements.as_ref().map(|s| s.ingredients);
    report.ingredients = ingredients;
    report.delta = ingredients.map(|i| i.sigma.0);
    report.Delta = ingredients.map(|i| i.sigma.1);
    report.eta = ingredients.map(|i| i.h.1);
    let Some(found) = statements.filter(|_| holds) else {
        report.bounds = Bounds::none(ingredients.as_ref());
        return;
    };
    let i = &found.ingredients;
    let bounds = match structure.h_is_zero {
        true => Bounds::printed(i),
        false => Bounds::with_h(i),
    };
    let mut region = bounds.region();
    if let (Some((low, high)), Some(real)) = (found.real, region.real) {
        region.real = Some((real.0.max(low), real.1.min(high)));
    }
    let is_positive = positivity::holds(relaxation, i);
    if is_positive {
        region.real = region.real.map(|(low, high)| (low.max(0.0), high));
        region.re = region.re.map(|(low, high)| (low.max(0.0), high));
    }
    if is_positive || !found.right_of_zero {
        region = region.within(&found.circles);
    }
    if let Some(circle) = found.around_one {
        region = region.within(&[circle]);
    }
    if is_real && i.h.0 >= 0.0 {
        if relaxation.degree == 0 {
            // eig(S + H, S + C) lies between the least of eig(S, S + C) = eig(GᵀG) and the largest of 1 and C⁻¹H
            let ends = |(low, high): (f64, f64)| (low.max(i.g.0 * i.g.0), high.min(i.h.1.max(1.0)));
            region.real = region.real.map(ends);
        }
        region = Region {
            im_max: Some(0.0),
            ..region
        }
        .closed();
        report.exact_S_u_interval = region.real;
    }
    report.bounds = bounds.sharpened(&region);
    report.region = region;
}
