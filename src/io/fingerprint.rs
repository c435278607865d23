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

#[cfg(test)]
mod tests {
    use super::*;
    use crate::scene::named;

    #[test]
    fn mesh_numbering_and_scene_are_told_apart() {
        let scene = named("patch").unwrap().scene().unwrap();
        let build = |set: &[&str]| scene.with_overrides(set).unwrap().build().unwrap();
        let body = build(&[]);
        let own = Fingerprint::new(&body, "scene");
        assert_eq!(own, Fingerprint::new(&build(&[]), "scene"));
        for set in ["mesh.x.cells=6", "mesh.y.to=1.5 m", "boundary.0.hold=fixed"] {
            assert_ne!(
                own.mesh,
                Fingerprint::new(&build(&[set]), "scene").mesh,
                "{set}"
            );
        }
        let mut turned = body.clone();
        turned.fractures.faces[2].frame.swap(1, 2);
        assert_ne!(own.mesh, Fingerprint::new(&turned, "scene").mesh);
        let other = Fingerprint::new(&body, "Scene");
        assert!(other.mesh == own.mesh && other.scene != own.scene);
    }
}
