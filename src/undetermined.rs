//! Tractions that neither displacements nor H see: refused where they leave the answer open, told where they do not.
//!
//! A slab of one element between rollers is the usual 2-D problem in a 3-D code: the shear across it pushes on prescribed
//! displacements alone. Its row is `0 = 0`, no iterate changes it, displacements and all other tractions are unique. A
//! traction pattern over several patches that pushes on nothing is another matter: which faces open depends on it.

use crate::mesh::{CouplingKernel, coupling_kernel};
use crate::scene::Body;
use crate::system::of_held_bodies;
use fracas_solvers::SetupError;

/// Tractions that nothing determines and contact depends on.
#[derive(Debug, thiserror::Error)]
#[error(
    "{scene}: {modes} traction mode(s) stay free even with stabilization, so the saddle point is singular{place}; \
     `fracas check {scene}` lists every place"
)]
pub struct SingularScene {
    /// Its name.
    pub scene: String,
    /// Dimension of what nothing determines.
    pub modes: usize,
    place: String,
}

/// Refuses a scene whose tractions are not unique even with jump stabilization; what is to be said of those that push on
/// prescribed displacements or tips only.
///
/// # Errors
/// [`SingularScene`] with the first place.
pub fn undetermined(scene: &str, body: &Body) -> Result<Option<String>, SingularScene> {
    let kernel = coupling_kernel(&body.mesh, &body.fractures, &body.prescribed());
    judge(scene, body, &kernel)?;
    Ok((kernel.idle_dimension > 0).then(|| {
        format!(
            "{} traction mode(s) push on prescribed displacements or tips only{}; nothing but H and the law of their faces determines such tractions: they keep the initial stress until faces beside them slip, and all else is unique",
            kernel.idle_dimension,
            first(body, &kernel)
        )
    }))
}

/// A set-up that stumbles over tractions that nothing determines names them; one that stumbles over S_u of a scene does not blame
/// its supports.
///
/// Rows of such tractions are `0 = 0` in the whole system and in its Schur complement, and none of A or S_u.
pub fn blamed(mut error: SetupError, scene: Option<&str>, body: Option<&Body>) -> SetupError {
    if body.is_some() {
        error = of_held_bodies(error);
    }
    let idle = || undetermined(scene?, body?).ok()?;
    if let SetupError::Singular { block, advice, .. }
    | SetupError::NotPositiveDefinite { block, advice, .. } = &mut error
        && !block.starts_with('A')
        && *block != "S_u"
        && let Some(sentence) = idle()
    {
        *advice = format!("{sentence}; method = \"racp\" needs no factorization of their rows");
    }
    error
}

/// The same for a kernel that is known already.
///
/// # Errors
/// [`SingularScene`] with the first place.
pub fn judge(scene: &str, body: &Body, kernel: &CouplingKernel) -> Result<(), SingularScene> {
    if kernel.stabilized_dimension <= kernel.idle_dimension {
        return Ok(());
    }
    Err(SingularScene {
        scene: scene.into(),
        modes: kernel.stabilized_dimension - kernel.idle_dimension,
        place: first(body, kernel),
    })
}

/// The first finding and its place.
fn first(body: &Body, kernel: &CouplingKernel) -> String {
    kernel.findings.first().map_or_else(String::new, |finding| {
        let [x, y, z] = finding.center;
        format!(
            ": fracture \"{}\", face {} at ({x:.6}, {y:.6}, {z:.6}) m: {}",
            body.fractures.names[usize::from(finding.fracture)],
            finding.face,
            finding.reason
        )
    })
}
