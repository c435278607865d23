//! Patches: faces of one fracture that hang together by their edges.

use super::FractureMesh;
use super::split::root;

impl FractureMesh {
    /// The patches of the faces that are `taken`, each with its faces in increasing order, by its lowest one. Faces of one fracture that share an
    /// edge are of one patch, also where other fractures cross there.
    ///
    /// # Cost
    /// O(faces + edges).
    pub fn patches(&self, taken: impl Fn(usize) -> bool) -> Vec<Vec<usize>> {
        let across = self.crossings.iter().map(|crossing| &crossing.edge);
        let edges = self.edges.iter().chain(across).map(|edge| edge.faces);
        joined(self.faces.len(), edges, taken)
    }

    /// Area of these faces [m²].
    pub fn area_of(&self, faces: impl IntoIterator<Item = usize>) -> f64 {
        faces.into_iter().map(|f| self.faces[f].area).sum()
    }
}

/// Those of `n` faces that are `taken`, in parts that these edges join, as [`FractureMesh::patches`].
pub(super) fn joined(
    n: usize,
    edges: impl Iterator<Item = [u32; 2]>,
    taken: impl Fn(usize) -> bool,
) -> Vec<Vec<usize>> {
    let mut parent: Vec<usize> = (0..n).collect();
    for faces in edges {
        let [k, l] = faces.map(|f| f as usize);
        if taken(k) && taken(l) {
            let (a, b) = (root(&mut parent, k), root(&mut parent, l));
            // the lowest face is the root
            parent[a.max(b)] = a.min(b);
        }
    }
    let mut patches: Vec<Vec<usize>> = vec![Vec::new(); n];
    for f in (0..n).filter(|f| taken(*f)) {
        patches[root(&mut parent, f)].push(f);
    }
    patches.retain(|patch| !patch.is_empty());
    patches
}
