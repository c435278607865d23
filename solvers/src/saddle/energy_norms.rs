//! Norms in which an error of (u, t) is judged, each part against that of the solution.

use super::of_tractions::OfTractions;
use super::{SaddleBlocks, Stiffness, T, U};
use fracas_operators::random::signed;
use fracas_operators::sparse::{CsrView, SparseMatrix};
use fracas_operators::vector::dot;
use fracas_operators::{Field, Fields, Layout, LinearOperator};
use std::borrow::Cow;

/// `√(vᵀKv)` of the displacements of a solution with the prescribed ones in their places; K = stiffness in full numbering.
pub type StrainNorm<'a> = Box<dyn Fn(&[f64]) -> f64 + 'a>;

/// An operator, and its diagonal.
pub type WithDiagonal<'a> = (Box<dyn LinearOperator<f64> + 'a>, Vec<f64>);

/// Most of the norm of (u, t) that a part which all but vanishes is judged against. Unit: 1.
const LEAST_SHARE: f64 = 1e-6;

/// Share of the norm of (u, t) that an error may have whatever the tolerance, lest a part that vanishes be judged against rounding:
/// 45 times that of f64. Unit: 1.
const ROUNDING: f64 = 1e-14;

/// Spread of the diagonal of A below which rounding is small in any direction: ε times 2¹⁰ is 2e-13. Unit: 1.
const ALIKE: f64 = 1024.0;

/// Square of an off-diagonal entry over the product of its diagonal ones, above which it is no rounding of a semidefinite matrix. Unit: 1.
const MINOR: f64 = 1.0 + 1e-8;

/// Most unknowns of a field of which an estimate may be small by chance: k independent values are all below a tenth of what they mostly
/// are once in 10ᵏ times. Of 18,000 systems of other codes three were called converged with one to three tractions wrong by 10 to 16
/// tolerances, where M⁻¹r was smaller by 25 and 255 than what corrects it. Unit: 1.
const FEW: f64 = 8.0;

/// `‖e_u‖² = e_uᵀA e_u + (B2 e_u)ᵀ (C_0 + diag H)⁻¹ (B2 e_u)` and `‖e_t‖² = e_tᵀ (C_0 + H) e_t`, `C_0 = diag(B1ᵀ diag(A)⁻¹ B1)`.
///
/// The norm of e_u is the energy norm, and sees the motion of blocks that A leaves free by their jumps; that of e_t is the energy
/// of what the tractions move. Where two rows of H show that it is indefinite it is that of `C_0 + |diag H|`: C_0 + H may then lose all of a large
/// error. That of pressures is likewise `‖e_p‖² = e_pᵀ diag(Q1ᵀ diag(A)⁻¹ Q1) e_p`: T may be singular or indefinite, and
/// where it is large its energy does not see that all pressures are wrong by the same. None depends on units, on the method, or on how stiff the rock is that a prescribed
/// displacement holds.
///
/// # Cost
/// One product with 𝒜 and one with H per error, two vectors of n.
pub struct EnergyNorms<'a> {
    operator: &'a dyn LinearOperator<f64>,
    layout: Layout,
    h: Option<Box<dyn LinearOperator<f64> + 'a>>,
    /// C_0.
    c: Vec<f64>,
    /// Diagonal of C_0 + H.
    diagonal: Vec<f64>,
    /// `C_0 + |diag H|`, where H is seen to be indefinite.
    of_indefinite: Option<Vec<f64>>,
    strain: Option<StrainNorm<'a>>,
    stiffness: Cow<'a, Stiffness>,
    /// The blocks, where residuals may be had in twice the digits.
    entries: Option<&'a SaddleBlocks>,
    /// Their B2 is other than B1ᵀ, or their H than Hᵀ.
    is_unsymmetric: bool,
    /// B1, where its entries are known.
    b1: Option<&'a SparseMatrix<f64>>,
    /// Jumps count in the norm of e_u.
    jumps: bool,
    /// Further fields.
    others: Vec<Weighted>,
}

/// A field with a norm of weights.
struct Weighted {
    field: Field,
    /// `‖e‖² = Σ w_i e_i²`.
    weights: Vec<f64>,
    /// Squares of what residuals are of the size of.
    sizes: Vec<f64>,
}

impl<'a> EnergyNorms<'a> {
    /// Norms for `operator = [A B1; B2 −H]` with the diagonals of C_0 and A.
    pub fn new(
        operator: &'a dyn LinearOperator<f64>,
        h: Option<&'a SparseMatrix<f64>>,
        c: Vec<f64>,
        stiffness: Cow<'a, Stiffness>,
    ) -> Self {
        let of_h = |h: &'a SparseMatrix<f64>| -> WithDiagonal<'a> {
            let diagonal = h.diag_iter().map(|h| h.copied().unwrap_or(0.0));
            (Box::new(CsrView::new(h)), diagonal.collect())
        };
        let is_indefinite = h.is_some_and(is_indefinite);
        Self::assembled(operator, (h.map(of_h), is_indefinite), c, stiffness)
    }

    /// The same for a positive semidefinite H that is an operator, with its diagonal: of ranks, each of which has its rows of everything.
    pub fn of_parts(
        operator: &'a dyn LinearOperator<f64>,
        h: Option<WithDiagonal<'a>>,
        c: Vec<f64>,
        stiffness: Cow<'a, Stiffness>,
    ) -> Self {
        Self::assembled(operator, (h, false), c, stiffness)
    }

    fn assembled(
        operator: &'a dyn LinearOperator<f64>,
        (h, is_indefinite): (Option<WithDiagonal<'a>>, bool),
        mut c: Vec<f64>,
        stiffness: Cow<'a, Stiffness>,
    ) -> Self {
        let n = operator.shape().rows;
        let rows = h.as_ref().map(|(_, diagonal)| diagonal.len());
        assert!(
            c.len() <= n && rows.is_none_or(|rows| rows == c.len()),
            "{n} unknowns, {} tractions, {rows:?} rows of H",
            c.len()
        );
        let (h, of_h) = h.unzip();
        let mut of_h = of_h.unwrap_or_default();
        of_h.resize(c.len(), 0.0);
        for (c, h) in c.iter_mut().zip(&of_h).filter(|(c, _)| **c == 0.0) {
            *c = of_itself(*h);
        }
        let diagonal = c.iter().zip(&of_h).map(|(c, h)| c + h.max(0.0)).collect();
        let sizes = || c.iter().zip(&of_h).map(|(c, h)| c + h.abs()).collect();
        let of_indefinite = is_indefinite.then(sizes);
        Self {
            operator,
            layout: Layout::new([(U, stiffness.len()), (T, c.len())]),
            h,
            c,
            diagonal,
            of_indefinite,
            strain: None,
            stiffness,
            entries: None,
            is_unsymmetric: false,
            b1: None,
            jumps: true,
            others: Vec::new(),
        }
    }

    /// The same for a system with a further field, judged by `‖e‖² = Σ w_i e_i²` with these weights; its residuals are of the size of
    /// `√(w_i + |t_ii|)`, t being its own block.
    #[must_use]
    pub fn and(mut self, field: Field, weights: Vec<f64>, block: &SparseMatrix<f64>) -> Self {
        assert_eq!(weights.len(), block.rows(), "weights of {}", field.name);
        self.layout = self.layout.with(field, weights.len());
        let entry = |t: Option<&f64>| t.map_or(0.0, |t| t.abs());
        let sizes = weights.iter().zip(block.diag_iter());
        self.others.push(Weighted {
            field,
            sizes: sizes.map(|(w, t)| w + entry(t)).collect(),
            weights,
        });
        self
    }

    /// C_0.
    pub fn compliance(&self) -> &[f64] {
        &self.c
    }

    /// The fields of an error.
    pub fn layout(&self) -> Layout {
        self.layout
    }

    /// The fields of so few unknowns, over all parts of the vectors, that an estimate of their error may be small by chance.
    pub fn by_chance(&self) -> Fields<bool> {
        let of_part = |field| self.layout.length(field) as f64;
        let lengths = self.layout.values(());
        lengths.map(|field, ()| self.sums([of_part(field)])[0] <= FEW)
    }

    /// Takes residuals from these blocks, in twice the digits, where f64 has no more to say ([`SaddleBlocks::residual`]).
    #[must_use]
    pub fn with_entries(mut self, blocks: &'a SaddleBlocks) -> Self {
        self.entries = Some(blocks);
        self.is_unsymmetric =
            blocks.b2.is_some() || blocks.h.as_ref().is_some_and(|h| !is_symmetric(h));
        self.with_b1(&blocks.b1)
    }

    /// Knows what tractions move together: [`probe`](super::probe()) looks at it.
    #[must_use]
    pub fn with_b1(mut self, b1: &'a SparseMatrix<f64>) -> Self {
        self.b1 = Some(b1);
        self
    }

    /// The blocks of 𝒜, where residuals may be had in twice the digits.
    pub fn entries(&self) -> Option<&SaddleBlocks> {
        self.entries
    }

    /// Whether B2 is known to be other than B1ᵀ, or H other than Hᵀ: then M⁻¹𝒜 may be far from normal, and a Ritz value be of another size than what it
    /// keeps small.
    pub fn is_unsymmetric(&self) -> bool {
        self.is_unsymmetric
    }

    /// Judges e_u against `norm` of the solution: where displacements are prescribed, `‖u‖_A` of the free ones alone is mostly
    /// what holds the cells beside them.
    #[must_use]
    pub fn against(mut self, norm: Option<StrainNorm<'a>>) -> Self {
        self.strain = norm;
        self
    }

    /// Takes `e_uᵀA e_u` alone: of faces that are held by springs, which some jumps do not strain at all, tractions tell the others.
    #[must_use]
    pub fn without_jumps(mut self) -> Self {
        self.jumps = false;
        self
    }

    /// Adds `ε |A||u|` to a residual in f64, which is known to that, and gives the norm of `ε diag(A) u`: rounding has the same sign in like
    /// elements. It matters where stiff rock moves far and soft rock bears the load. Where rocks are alike, or the entries of A are not known,
    /// `ε diag(A) u` is added: it has nothing of what a motion along one axis rounds in the forces along another.
    pub fn add_rounding(&self, x: &[f64], r: &mut [f64]) -> f64 {
        let mut square = 0.0;
        let (r, x) = (&mut r[self.layout.range(U)], &x[self.layout.range(U)]);
        let entries = self.entries.filter(|_| self.stiffness.spread() >= ALIKE);
        for (i, (r, a)) in r.iter_mut().zip(self.stiffness.entries()).enumerate() {
            let own = f64::EPSILON * a * x[i];
            let row = entries.and_then(|blocks| blocks.a.outer_view(i));
            *r += match row {
                Some(row) => {
                    let sum = row.iter().map(|(j, a)| (a * x[j]).abs()).sum::<f64>();
                    f64::EPSILON * sum.copysign(own)
                }
                None => own,
            };
            square += own * own;
        }
        self.sums([square])[0].sqrt()
    }

    /// What C_0 + H holds of what its diagonal holds.
    pub(super) fn of_tractions(&self) -> OfTractions<'_> {
        let h = self.h.as_deref().map(|h| h as &dyn LinearOperator<f64>);
        OfTractions::new(self.operator, (&self.c, h), &self.diagonal)
    }

    /// What `B1ᵀ diag(A)⁻¹ B1 + H` holds of what the diagonal of C_0 + H holds, where the entries of B1 are known.
    pub(super) fn of_moving_tractions(&self) -> Option<OfTractions<'_>> {
        let b1 = self.b1?;
        Some(self.of_tractions().moving(b1, &self.stiffness))
    }

    /// These sums over all parts of the vectors.
    fn sums<const N: usize>(&self, mut sums: [f64; N]) -> [f64; N] {
        self.operator.sum_over_parts(&mut sums);
        sums
    }

    /// The diagonal of A.
    pub fn stiffness(&self) -> &Stiffness {
        &self.stiffness
    }

    /// A residual with its share of every eigenvector: independent entries, as large as `√diag(A)` and `√diag(C_0 + H)`.
    pub fn random_residual(&self) -> Vec<f64> {
        let of_t = self.diagonal.iter().copied();
        let others = (self.others.iter()).flat_map(|other| other.sizes.iter().copied());
        let size = self.stiffness.entries().chain(of_t).chain(others);
        let random = |(i, a): (usize, f64)| a.sqrt() * signed(i as u64);
        size.enumerate().map(random).collect()
    }

    /// `‖e_u‖`, `‖e_t‖`, … of an error.
    pub fn error(&self, e: &[f64]) -> Fields<f64> {
        self.norms(e, self.displacements(e, self.jumps))
    }

    /// `‖u‖`, `‖t‖`, … of a solution, which errors are judged against.
    pub fn solution(&self, x: &[f64]) -> Fields<f64> {
        let [u] = self.layout.split([U], x);
        let norm_u = match &self.strain {
            Some(norm) => norm(u),
            None => self.displacements(x, false),
        };
        self.norms(x, norm_u)
    }

    /// The norm of u beside those of the other fields of v.
    fn norms(&self, v: &[f64], u: f64) -> Fields<f64> {
        let [t] = self.layout.split([T], v);
        let norms = Fields::new([(U, u), (T, self.tractions(t))]);
        self.others.iter().fold(norms, |norms, other| {
            let [p] = self.layout.split([other.field], v);
            let squares = p.iter().zip(&other.weights).map(|(p, w)| w * p * p);
            norms.with(other.field, self.sums([squares.sum()])[0].sqrt())
        })
    }

    /// `‖e_u‖/‖u‖`, `‖e_t‖/‖t‖`, … of these norms, where each is to be at most `tolerance`; a field that all but vanishes counts as
    /// `min(1e-6, 1e-14/tolerance)` of all, so that an error of 1e-14 of all is always small enough.
    pub fn relative(error: Fields<f64>, of: Fields<f64>, tolerance: f64) -> Fields<f64> {
        let all = of.iter().fold(0.0, |all: f64, (_, norm)| all.hypot(norm));
        let least = LEAST_SHARE.min(ROUNDING / tolerance) * all;
        error.map(|field, error| ratio(error, of[field].max(least)))
    }

    /// `√(vᵀA v)`, with the springs of the jumps where they are asked for.
    fn displacements(&self, v: &[f64], jumps: bool) -> f64 {
        let [u] = self.layout.split([U], v);
        // 𝒜 may be that of u and t alone, which come first
        let mut part = vec![0.0; self.operator.shape().cols];
        part[self.layout.range(U)].copy_from_slice(u);
        let mut image = vec![0.0; part.len()];
        let mut work = vec![0.0; self.operator.work_len()];
        self.operator.apply(&part, &mut image, &mut work);
        let [force, jump] = [U, T].map(|field| &image[self.layout.range(field)]);
        let energy = dot(u, force);
        let weights = self.diagonal.iter().filter(|_| jumps);
        let springs = jump.iter().zip(weights).map(|(g, c)| g * g / c);
        let [energy, springs] = self.sums([energy, springs.sum()]);
        (energy.max(0.0) + springs).sqrt()
    }

    /// `√(tᵀ(C_0 + H)t)`, with |diag H| for an indefinite H.
    fn tractions(&self, t: &[f64]) -> f64 {
        let weights = self.of_indefinite.as_ref().unwrap_or(&self.c);
        let c: f64 = t.iter().zip(weights).map(|(t, c)| c * t * t).sum();
        let h = match (&self.h, &self.of_indefinite) {
            (Some(h), None) => energy(&**h, t),
            _ => 0.0,
        };
        let [c, h] = self.sums([c, h]);
        (c + h.max(0.0)).sqrt()
    }
}

/// What stands in the place of `C_ii` where a column of B1 is empty: `|H_ii|`, of whose unit it is, and 1 where nothing holds that traction.
pub(super) fn of_itself(h_ii: f64) -> f64 {
    match h_ii.abs() {
        0.0 => 1.0,
        size => size,
    }
}

/// True where a row or two of H show that its symmetric part is indefinite: `h_ii < 0`, or `¼(h_ij + h_ji)² > h_ii h_jj`.
fn is_indefinite(h: &SparseMatrix<f64>) -> bool {
    let at = |i: usize, j: usize| h.get(i, j).copied().unwrap_or(0.0);
    h.iter().any(|(v, (i, j))| {
        let (i, j) = (i as usize, j as usize);
        match i == j {
            true => *v < 0.0,
            false => (0.5 * (v + at(j, i))).powi(2) > MINOR * at(i, i) * at(j, j),
        }
    })
}

/// True where H is Hᵀ to rounding.
fn is_symmetric(h: &SparseMatrix<f64>) -> bool {
    let at = |i: usize, j: usize| h.get(i, j).copied().unwrap_or(0.0);
    h.iter().all(|(v, (i, j))| {
        let (i, j) = (i as usize, j as usize);
        let size = v.abs().max((at(i, i) * at(j, j)).abs().sqrt());
        (v - at(j, i)).abs() <= ALIKE * f64::EPSILON * size
    })
}

/// `vᵀMv` of this part.
fn energy(m: &dyn LinearOperator<f64>, v: &[f64]) -> f64 {
    let mut image = vec![0.0; v.len()];
    m.apply(v, &mut image, &mut vec![0.0; m.work_len()]);
    dot(v, &image)
}

/// 0 where there is no error, infinite where there is nothing to compare it with.
fn ratio(error: f64, of: f64) -> f64 {
    if error == 0.0 { 0.0 } else { error / of }
}

impl SaddleBlocks {
    /// The diagonal of `C_0 = B1ᵀ diag(A)⁻¹ B1`; for an empty column `|H_ii|`, or 1 where that is 0.
    pub fn contact_compliance(&self) -> Vec<f64> {
        let mut c = self.compliance(&self.b1);
        for (i, c) in c.iter_mut().enumerate().filter(|(_, c)| **c == 0.0) {
            *c = of_itself(self.h_ii(i));
        }
        c
    }

    /// The diagonal of `Q1ᵀ diag(A)⁻¹ Q1`; the mean of the others for a pressure that moves nothing, and 1 where none does. Empty without
    /// flow.
    pub fn pressure_compliance(&self) -> Vec<f64> {
        let Some(flow) = &self.flow else {
            return Vec::new();
        };
        let mut c = self.compliance(&flow.q1);
        let moving = c.iter().filter(|c| **c > 0.0).count();
        let mean = match moving {
            0 => 1.0,
            _ => c.iter().sum::<f64>() / moving as f64,
        };
        c.iter_mut().filter(|c| **c == 0.0).for_each(|c| *c = mean);
        c
    }

    /// The diagonal of `Qᵀ diag(A)⁻¹ Q`; the least of the other entries stands for one of A that is 0.
    fn compliance(&self, q: &SparseMatrix<f64>) -> Vec<f64> {
        let mut c = vec![0.0; q.cols()];
        let entry = |i| self.a.get(i, i).map_or(0.0, |a| a.abs());
        let positive = (0..self.n_u()).map(entry).filter(|a| *a > 0.0);
        let least = positive.fold(f64::INFINITY, f64::min);
        for (i, row) in q.outer_iterator().enumerate() {
            let diagonal = match entry(i) {
                0.0 => least,
                diagonal => diagonal,
            };
            row.iter().for_each(|(j, b)| c[j] += b * b / diagonal);
        }
        c
    }
}
