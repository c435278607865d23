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
        let mut parent: Vec<usize> = (0..self.faces.len()).collect();
        let across = self.crossings.iter().map(|crossing| &crossing.edge);
        for edge in self.edges.iter().chain(across) {
            let [k, l] = edge.faces.map(|f| f as usize);
            if taken(k) && taken(l) {
                let (a, b) = (root(&mut parent, k), root(&mut parent, l));
                // the lowest face is the root
                parent[a.max(b)] = a.min(b);
            }
        }
        let mut patches: Vec<Vec<usize>> = vec![Vec::new(); parent.len()];
        for f in (0..parent.len()).filter(|f| taken(*f)) {
            patches[root(&mut parent, f)].push(f);
        }
        patches.retain(|patch| !patch.is_empty());
        patches
    }

    /// Area of these faces [m²].
    pub fn area_of(&self, faces: impl IntoIterator<Item = usize>) -> f64 {
        faces.into_iter().map(|f| self.faces[f].area).sum()
    }
}
