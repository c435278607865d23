//! The spectrum of M⁻¹𝒜 of a problem, geometric multigrid included.

use super::{InnerRule, Loaded, NotGeometric, Problem, Route, SolveError, SystemKind};
use crate::multigrid::GeometricInverse;
use fracas_operators::Preconditioner;
use fracas_solvers::saddle::{AugmentationMatrix, InnerChoice, SaddleBlocks, SaddleMethod};
use fracas_solvers::spectrum::{
    Certificate, SpectrumReport, SpectrumRequest, analyse_around, analyse_method, certificate,
};
use fracas_solvers::{Observer, SetupError};

/// The method whose spectrum is asked for: geometric multigrid only where it is asked for by name, since entries are read anyway.
///
/// # Errors
/// [`NotGeometric`] where there is no grid.
pub fn spectrum_method(
    problem: &Problem,
    method: &SaddleMethod,
    rule: InnerRule,
    asker: &'static str,
) -> Result<SaddleMethod, NotGeometric> {
    let is_geometric = matches!(method.inner(), Some(InnerChoice::Geometric(_)));
    let kind = match is_geometric && rule != InnerRule::Auto {
        true => problem.kind(),
        false => SystemKind::Entries(asker),
    };
    Ok(Route::new(method, rule, kind, None)?.method)
}

/// [`analyse_method`] of a loaded problem; multigrid works in f64.
///
/// # Errors
/// [`SolveError`].
pub fn spectrum(
    problem: &Problem,
    loaded: &Loaded,
    method: &SaddleMethod,
    request: &SpectrumRequest,
    observer: &mut dyn Observer,
) -> Result<SpectrumReport, SolveError> {
    let SaddleMethod::Racp(racp) = method else {
        return Ok(analyse_method(&loaded.blocks, method, request, observer)?);
    };
    let InnerChoice::Geometric(settings) = racp.inner else {
        return Ok(analyse_method(&loaded.blocks, method, request, observer)?);
    };
    let (Problem::Body(stuck), Some(body)) = (problem, &loaded.body) else {
        return Err(NotGeometric::Folder.into());
    };
    let settings = settings.in_double().unwrap_or(settings);
    let system = body.stick_system(stuck.stabilization(body));
    let build = |_: &SaddleBlocks, c: &AugmentationMatrix| {
        let inverse = GeometricInverse::new(&settings, &system, c).map_err(|error| {
            SetupError::NotApplicable {
                method: "geometric",
                reason: error.to_string(),
            }
        })?;
        Ok(Box::new(inverse) as Box<dyn Preconditioner<f64>>)
    };
    let request = SpectrumRequest {
        augmentation: racp.augmentation,
        relaxation: racp.relaxation,
        inner: InnerChoice::Geometric(settings),
        ..request.clone()
    };
    Ok(analyse_around(&loaded.blocks, &request, &build, observer)?)
}

/// A bound of the inf-sup constant: of the blocks, or of the elements at the fractures of a body where that is sharper.
///
/// # Errors
/// [`SolveError`].
pub fn inf_sup(problem: &Problem, loaded: &Loaded) -> Result<Option<Certificate>, SolveError> {
    match (problem, &loaded.body) {
        (Problem::Body(stuck), Some(body)) => {
            let system = body.stick_system(stuck.stabilization(body));
            Ok(system.certificate_beside(&loaded.blocks)?)
        }
        _ => Ok(certificate(&loaded.blocks)?),
    }
}
