//! Numbers that tell whether two files belong together.

use crate::scene::Body;

/// Running 64-bit hash of bytes, `h ← (h ⊕ byte) · p`: a change within one byte is always seen, others but for one in 2⁶⁴.
///
/// # Source
/// Fowler, Noll, Vo: FNV-1a, RFC 9923.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub struct Hash(u64);

impl Default for Hash {
    fn default() -> Self {
        Self(0xcbf2_9ce4_8422_2325)
    }
}

impl Hash {
    /// The number so far.
    pub(super) fn value(self) -> u64 {
        self.0
    }

    /// Takes bytes in.
    pub fn bytes(&mut self, bytes: &[u8]) {
        for byte in bytes {
            self.0 = (self.0 ^ u64::from(*byte)).wrapping_mul(0x0000_0100_0000_01b3);
        }
    }

    /// Takes a list of numbers in, with its length.
    fn list<const N: usize>(&mut self, numbers: impl ExactSizeIterator<Item = [u8; N]>) {
        self.bytes(&(numbers.len() as u64).to_le_bytes());
        numbers.for_each(|n| self.bytes(&n));
    }
}

impl std::fmt::Display for Hash {
    fn fmt(&self, f: &mut std::fmt::Formatter<'_>) -> std::fmt::Result {
        write!(f, "{:016x}", self.0)
    }
}

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
    fn the_hash_is_the_published_one() {
        let of = |text: &str| {
            let mut hash = Hash::default();
            hash.bytes(text.as_bytes());
            hash.value()
        };
        assert_eq!(of(""), 0xcbf2_9ce4_8422_2325);
        assert_eq!(of("a"), 0xaf63_dc4c_8601_ec8c);
        assert_eq!(of("foobar"), 0x8594_4171_f739_67e8);
    }

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
