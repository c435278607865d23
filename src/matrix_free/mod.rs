//! The saddle point of a body without a single assembled matrix but H, and RACP around it.

mod certificate;
mod pieces;
mod racp;
mod residual;
mod system;

use crate::contact::{Coupling, prescribed_jump};
use crate::elasticity::{ElasticityError, Restricted, diagonal, matrix_free};
use crate::system::StickSystem;
use fracas_operators::operator::assert_product;
use fracas_operators::sparse::{Csr, SparseMatrix};
use fracas_operators::{AdjointOperator, Layout, LinearOperator, Real, Shape};
use fracas_solvers::saddle::{EnergyNorms, Stiffness, StrainNorm, T, U, unit_of_tractions};
use std::borrow::Cow;
use std::sync::Arc;

pub use pieces::PiecesError;
pub use racp::{MatrixFreeError, RacpParts};
pub use system::MatrixFreeSystem;

/// `[A B; Bᵀ −H]` over the free displacements and the tractions: A cell by cell, B face by face, H by its few entries.
///
/// Equal to the assembled blocks up to rounding (`tests/multigrid/matrix_free.rs`).
///
/// # Cost
/// Memory: O(cells) numbers instead of the 243 entries per node of an assembled A.
pub struct MatrixFreeSaddle<R> {
    a: Restricted<Box<dyn AdjointOperator<R>>>,
    b: Arc<Coupling<R>>,
    h: Option<Arc<Csr<R>>>,
    layout: Layout,
}

impl<R: Real> MatrixFreeSaddle<R> {
    /// The operator of `system`, tractions in Pa.
    ///
    /// # Errors
    /// [`ElasticityError`] for an inverted element or a region without material.
    pub fn new(system: &StickSystem<'_>) -> Result<Self, ElasticityError> {
        Self::in_traction_unit(system, 1.0)
    }

    /// The operator for tractions counted in units of `unit`: `B s`, `H s²`.
    ///
    /// # Errors
    /// As [`new`](Self::new).
    pub fn in_traction_unit(system: &StickSystem<'_>, unit: f64) -> Result<Self, ElasticityError> {
        let full = matrix_free::<R>(system.mesh, system.materials)?;
        let b = Coupling::new(system.fractures, system.constraints);
        let h = system
            .stabilization()
            .map(|h| Arc::new(Csr::new(scaled(&h, unit))));
        let shape = b.shape();
        let layout = Layout::new([(U, shape.rows), (T, shape.cols)]);
        Ok(Self {
            a: Restricted::new(full, system.constraints.clone()),
            b: Arc::new(b.in_traction_unit(R::of(unit))),
            h,
            layout: layout.counted_in(T, unit),
        })
    }

    /// The fields of its unknowns.
    pub fn layout(&self) -> Layout {
        self.layout
    }

    /// What tractions are counted in [Pa].
    pub fn unit(&self) -> f64 {
        self.layout.unit(T)
    }

    /// A.
    pub fn stiffness(&self) -> &Restricted<Box<dyn AdjointOperator<R>>> {
        &self.a
    }

    /// B.
    pub fn coupling(&self) -> &Arc<Coupling<R>> {
        &self.b
    }

    /// H, where it is not 0.
    pub fn stabilization(&self) -> Option<&Arc<Csr<R>>> {
        self.h.as_ref()
    }
}

impl MatrixFreeSaddle<f64> {
    /// Norms of errors, for the size of A and of the faces, and the strain norm of solutions where displacements are prescribed.
    pub fn energy_norms<'s>(
        &'s self,
        magnitude: &'s Magnitude,
        strain: Option<StrainNorm<'s>>,
    ) -> EnergyNorms<'s> {
        let square = self.unit() * self.unit();
        let c = magnitude.compliance.iter().map(|c| c * square).collect();
        let h = self.h.as_deref().map(Csr::matrix);
        EnergyNorms::new(self, h, c, Cow::Borrowed(&magnitude.stiffness)).against(strain)
    }

    /// `(f_f − A_fc u_c, −s B_cᵀ u_c)` for nodal forces `force` over all displacements [N] and tractions in units of s.
    pub fn rhs(&self, system: &StickSystem<'_>, force: &[f64]) -> Vec<f64> {
        let constraints = system.constraints;
        let n = self.layout.len();
        let mut rhs = Vec::with_capacity(n);
        rhs.extend(constraints.free().iter().map(|dof| force[*dof as usize]));
        if !constraints.is_displaced() {
            rhs.resize(n, 0.0);
            return rhs;
        }
        crate::elasticity::lift(self.a.full(), constraints, &mut rhs);
        let jump = prescribed_jump(system.fractures, constraints);
        rhs.extend(jump.into_iter().map(|jump| -self.unit() * jump));
        rhs
    }
}

/// Where A is largest, the unit of tractions that balances both rows of the saddle point, and the compliance of the faces.
#[derive(Clone, Debug, PartialEq)]
pub struct Magnitude {
    /// Free displacement with the largest diagonal entry of A, which is the largest |entry|: A is positive semi-definite.
    pub stiffest: usize,
    /// That entry [N/m].
    pub largest: f64,
    /// [`SaddleBlocks::traction_unit`](fracas_solvers::saddle::SaddleBlocks::traction_unit) without the blocks.
    pub unit: f64,
    /// [`SaddleBlocks::contact_compliance`](fracas_solvers::saddle::SaddleBlocks::contact_compliance) without the blocks, tractions in Pa;
    /// 0 for an empty column.
    pub compliance: Vec<f64>,
    /// Diagonal of A over the free displacements [N/m].
    pub stiffness: Stiffness,
}

impl StickSystem<'_> {
    /// The size of A and B, without A.
    ///
    /// # Cost
    /// O(elements), and one vector in full numbering while it runs.
    ///
    /// # Errors
    /// [`ElasticityError`] for an inverted element or a region without material.
    pub fn magnitude(&self) -> Result<Magnitude, ElasticityError> {
        let diagonal = diagonal(self.mesh, self.materials)?;
        let (mut stiffest, mut largest) = (0, 0.0);
        for (i, dof) in self.constraints.free().iter().enumerate() {
            let entry = diagonal[*dof as usize];
            if entry > largest {
                (stiffest, largest) = (i, entry);
            }
        }
        let free = self.constraints.free();
        let entries = free.iter().map(|dof| diagonal[*dof as usize]);
        let stiffness = Stiffness::new(largest, entries);
        let b = Coupling::<f64>::new(self.fractures, self.constraints);
        let inverse = |dof: &u32| match diagonal[*dof as usize] {
            0.0 => 0.0,
            entry => entry.recip(),
        };
        let weights: Vec<f64> = self.constraints.free().iter().map(inverse).collect();
        let mut compliance = vec![0.0; 3 * self.fractures.faces.len()];
        b.add_weighted_squares(&weights, &mut compliance);
        Ok(Magnitude {
            stiffest,
            largest,
            unit: unit_of_tractions(largest, b.largest_entry()),
            compliance,
            stiffness,
        })
    }
}

/// `s² H` in precision `R`.
fn scaled<R: Real>(h: &SparseMatrix<f64>, unit: f64) -> SparseMatrix<R> {
    h.map(|value| R::of(*value * (unit * unit)))
}

impl<R: Real> LinearOperator<R> for MatrixFreeSaddle<R> {
    fn shape(&self) -> Shape {
        Shape::square(self.layout.len())
    }

    fn apply_add(&self, alpha: R, x: &[R], y: &mut [R], work: &mut [R]) {
        assert_product(LinearOperator::shape(self), x, y);
        let [x_u, x_t] = self.layout.split([U, T], x);
        let [y_u, y_t] = self.layout.split_mut([U, T], y);
        // y_u += α (A x_u + B x_t)
        self.a.apply_add(alpha, x_u, y_u, work);
        self.b.apply_add(alpha, x_t, y_u, work);
        // y_t += α (Bᵀ x_u − H x_t); H = 0 costs nothing
        self.b.apply_adjoint_add(alpha, x_u, y_t, work);
        if let Some(h) = &self.h {
            h.apply_add(-alpha, x_t, y_t, work);
        }
    }

    fn work_len(&self) -> usize {
        self.a.work_len()
    }

    fn flops(&self) -> u64 {
        let h = self.h.as_ref().map_or(0, LinearOperator::flops);
        let b = 2 * LinearOperator::<R>::flops(&self.b);
        LinearOperator::<R>::flops(&self.a) + b + h
    }
}
