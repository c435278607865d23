//! Numbers that tell whether two files belong together.

use crate::digest::Hash;
use crate::scene::Body;

/// What a state belongs to.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Fingerprint {
    /// Of nodes, elements, fracture faces with their frames, and the numbering of the unknowns.
    pub mesh: u64,
    /// Of the text that the caller takes for the scene.
    pub scene: u64,
}

impl Fingerprint {
    /// Of a meshed body and the text that decides its physics.
    ///
    /// # Cost
    /// O(elements): some 100 bytes of hashing per element.
    pub fn new(body: &Body, scene: &str) -> Self {
        let mut hash = Hash::default();
        let nodes = body.mesh.nodes.as_flattened();
        hash.list(nodes.iter().map(|x| x.to_le_bytes()));
        let corners = body.mesh.elements.as_flattened();
        hash.list(corners.iter().map(|a| a.to_le_bytes()));
        hash.list(body.mesh.regions.iter().map(|r| r.to_le_bytes()));
        let faces = &body.fractures.faces;
        hash.list(faces.iter().map(|f| f.fracture.to_le_bytes()));
        for face in faces {
            hash.list(face.minus.nodes.iter().map(|a| a.to_le_bytes()));
            hash.list(face.plus.nodes.iter().map(|a| a.to_le_bytes()));
            hash.list(face.frame.as_flattened().iter().map(|x| x.to_le_bytes()));
        }
        let prescribed = body.constraints.prescribed();
        hash.list(prescribed.iter().map(|(dof, _)| dof.to_le_bytes()));
        let mut text = Hash::default();
        text.bytes(scene.as_bytes());
        Self {
            mesh: hash.value(),
            scene: text.value(),
        }
    }
}
