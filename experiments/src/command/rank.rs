//! Scenes whose saddle point is singular whatever the stabilization.

use fracas::mesh::{CouplingKernel, coupling_kernel};
use fracas::scene::Body;

/// Tractions that neither displacements nor H see.
#[derive(Debug, thiserror::Error)]
#[error(
    "{scene}: {modes} traction mode(s) stay free even with stabilization, so the saddle point is singular{place}; \
     `fracas check {scene}` lists every place"
)]
struct SingularScene {
    scene: String,
    modes: usize,
    place: String,
}

/// Refuses a scene whose tractions are not unique even with jump stabilization (a slab of one element between rollers,
/// a fracture of one face between tips, …).
pub(super) fn require_regular(scene: &str, body: &Body) -> anyhow::Result<()> {
    judge(
        scene,
        body,
        &coupling_kernel(&body.mesh, &body.fractures, &body.prescribed()),
    )
}

/// What a run says of such tractions: loads do not reach them, and they stay at those of the initial stress.
pub(super) fn undetermined(scene: &str, body: &Body) -> Option<String> {
    let error = require_regular(scene, body).err()?;
    Some(format!(
        "{error}; such tractions stay at those of the initial stress"
    ))
}

/// The same for a kernel that is known already.
pub(super) fn judge(scene: &str, body: &Body, kernel: &CouplingKernel) -> anyhow::Result<()> {
    if kernel.stabilized_dimension == 0 {
        return Ok(());
    }
    let place = kernel.findings.first().map_or_else(String::new, |finding| {
        let [x, y, z] = finding.center;
        format!(
            ": fracture \"{}\", face {} at ({x:.6}, {y:.6}, {z:.6}) m: {}",
            body.fractures.names[usize::from(finding.fracture)],
            finding.face,
            finding.reason
        )
    });
    Err(SingularScene {
        scene: scene.into(),
        modes: kernel.stabilized_dimension,
        place,
    }
    .into())
}
