//! C of a run: that of faces in stick, and what faces in other states keep of it.

use super::face_rules::{FaceRule, Matrix3};
use super::jacobian::FaceTangent;
use super::state_rows::StateRows;
use fracas_operators::small::times;
use fracas_operators::sparse::{Csr, Triplets};
use fracas_operators::{Preconditioner, Properties};
use fracas_solvers::SetupError;
use fracas_solvers::saddle::{AugmentationMatrix, Block};

/// C of faces in stick.
#[derive(Default)]
pub(super) struct StickC {
    /// C of every face, and its inverse.
    faces: Vec<[Block; 2]>,
    /// That of H = 0; empty before a face slips.
    free: Vec<Block>,
    /// All of C, where it is a sparse one that couples faces; of a dense one runs take the diagonal.
    coupled: Option<AugmentationMatrix>,
}

impl StickC {
    pub(super) fn new(c: AugmentationMatrix) -> Self {
        Self {
            faces: c.of_faces(),
            free: Vec::new(),
            coupled: matches!(c, AugmentationMatrix::Custom(_)).then_some(c),
        }
    }

    /// Not known yet.
    pub(super) fn is_empty(&self) -> bool {
        self.faces.is_empty()
    }

    /// Whether a slipping face asks for C of H = 0.
    pub(super) fn lacks_free(&self) -> bool {
        self.free.is_empty()
    }

    /// C of H = 0 is known.
    pub(super) fn know_free(&mut self, c: &AugmentationMatrix) {
        self.free = c.of_faces().into_iter().map(|[c, _]| c).collect();
    }

    /// What faces with these tangents make of their rows beside this H.
    pub(super) fn rules(
        &self,
        tangent: impl Fn(usize) -> FaceTangent,
        h: Option<&Csr<f64>>,
    ) -> Vec<FaceRule> {
        let faces = self.faces.iter().enumerate();
        faces
            .map(|(f, [c, inverse])| {
                let free = self.free.get(f).filter(|_| !acts_along(h, f));
                FaceRule::new(&tangent(f), [c, inverse, free.unwrap_or(c)])
            })
            .collect()
    }

    /// What S̃_u is built of: all of C while every face sticks, else the blocks `c` of the faces.
    ///
    /// # Errors
    /// Of blocks that are not positive definite.
    pub(super) fn of_schur(
        &self,
        is_stick: bool,
        c: &[Block],
    ) -> Result<AugmentationMatrix, SetupError> {
        match &self.coupled {
            Some(coupled) if is_stick => Ok(coupled.clone()),
            _ => AugmentationMatrix::from_face_blocks(c.to_vec()),
        }
    }

    /// The rows of faces with these tangents.
    ///
    /// # Cost
    /// A sparse factorization, where C couples faces of which some do not stick.
    ///
    /// # Errors
    /// Of a C that is not positive definite.
    pub(super) fn rows(
        &self,
        tangent: impl Fn(usize) -> FaceTangent,
        h: Option<&Csr<f64>>,
    ) -> Result<StateRows, SetupError> {
        let rules = self.rules(&tangent, h);
        let coupled = match &self.coupled {
            None => None,
            Some(c) => Some(self.kept(c, tangent)?),
        };
        Ok(StateRows::new(rules, coupled))
    }

    /// A C that couples faces, in the directions that faces keep: where all of them stick as it is.
    fn kept(
        &self,
        c: &AugmentationMatrix,
        tangent: impl Fn(usize) -> FaceTangent,
    ) -> Result<Coupled, SetupError> {
        if (0..self.faces.len()).all(|f| tangent(f) == FaceTangent::STICK) {
            return Ok(Coupled {
                c: c.clone(),
                kept: Vec::new(),
            });
        }
        let faces = self.faces.iter().enumerate();
        let states = faces.map(|(f, [c, _])| FaceRule::projected(&tangent(f), c));
        let (kept, extra): (Vec<Matrix3>, Vec<Matrix3>) = states.unzip();
        let c = projected(c, &kept, &extra)?;
        Ok(Coupled { c, kept })
    }
}

/// True where H acts on the jumps along a face.
fn acts_along(h: Option<&Csr<f64>>, face: usize) -> bool {
    let row = 3 * face + 1;
    let diagonal = h.and_then(|h| h.matrix().get(row, row));
    diagonal.is_some_and(|entry| *entry != 0.0)
}

/// `E (E C E + X)⁻¹ E` of a C that couples faces: E = the directions that faces keep, X = what the laws of faces add.
pub(super) struct Coupled {
    c: AugmentationMatrix,
    /// E; empty for E = I, X = 0.
    kept: Vec<Matrix3>,
}

impl Coupled {
    /// `z ← E (E C E + X)⁻¹ E r`.
    pub(super) fn solve(&self, r: &[f64], z: &mut [f64], work: &mut [f64]) {
        if self.kept.is_empty() {
            return self.c.solve(r, z, work);
        }
        let (w, work) = work.split_at_mut(r.len());
        w.copy_from_slice(r);
        self.project(w);
        self.c.solve(w, z, work);
        self.project(z);
    }

    fn project(&self, v: &mut [f64]) {
        for (e, v) in self.kept.iter().zip(v.as_chunks_mut().0) {
            *v = times(e, v);
        }
    }

    pub(super) fn work_len(&self) -> usize {
        3 * self.kept.len() + Preconditioner::work_len(&self.c)
    }

    pub(super) fn properties(&self) -> Properties {
        self.c.properties()
    }

    pub(super) fn flops(&self) -> u64 {
        Preconditioner::flops(&self.c) + 30 * self.kept.len() as u64
    }
}

/// `E C E + X`.
fn projected(
    c: &AugmentationMatrix,
    kept: &[Matrix3],
    extra: &[Matrix3],
) -> Result<AugmentationMatrix, SetupError> {
    let n = 3 * kept.len();
    let mut triplets = Triplets::new((n, n));
    for (value, (i, j)) in &c.entries() {
        let (i, j) = (i as usize, j as usize);
        let (e_i, e_j) = (&kept[i / 3], &kept[j / 3]);
        for k in 0..3 {
            for l in 0..3 {
                let entry = e_i[k][i % 3] * value * e_j[j % 3][l];
                if entry != 0.0 {
                    triplets.add_triplet(i - i % 3 + k, j - j % 3 + l, entry);
                }
            }
        }
    }
    for (f, x) in extra.iter().enumerate() {
        for (k, row) in x.iter().enumerate() {
            (0..3).for_each(|l| triplets.add_triplet(3 * f + k, 3 * f + l, row[l]));
        }
    }
    AugmentationMatrix::from_sparse(triplets.to_csr())
}

/// C per face.
pub(super) fn c_of(rules: &[FaceRule]) -> Vec<Block> {
    rules.iter().map(|rule| rule.c).collect()
}
