//! What rounding makes of a cycle, and what the coarsest level leaves out.

use super::cycle::Hierarchy;
use super::lambda::least_generalized;
use super::level::clear;
use fracas_operators::Real;
use fracas_operators::random::signed;
use fracas_operators::vector::norm2;

impl<R: Real> Hierarchy<R> {
    /// What the rounding of `z = M⁻¹b` leaves of b in the residual, for a uniform force b and random signs s:
    ///
    /// ```text
    /// ε ‖A (s∘z)‖ / ‖b‖,  ε the unit roundoff of R
    /// ```
    ///
    /// A uniform force excites what is softest: stiff rock that rides on soft rock, or a large body held at one side, moves far for
    /// its strains, and digits of z are lost in the differences. Infinite where a number overflows.
    ///
    /// Whether an iteration minds is another question: in a long body held at one end the number is large and no iteration
    /// is lost. With `n = ε A (s∘z)` in place of its norm `√(nᵀM⁻¹n / bᵀM⁻¹b)` does not tell either: M ≈ A makes it the square
    /// root of ε times the number above.
    ///
    /// # Cost
    /// One cycle and one product.
    pub fn rounding(&self) -> f64 {
        let level = &self.levels()[0];
        let n = level.size();
        let (mut b, mut z) = (vec![R::one(); n], vec![R::zero(); n]);
        clear(level.fixed(), &mut b);
        let work_len = self.work_len().max(level.operator().work_len());
        let mut work = vec![R::zero(); work_len];
        self.solve(&mut b, &mut z, &mut work);
        for (i, z) in z.iter_mut().enumerate() {
            if signed(i as u64) < 0.0 {
                *z = -*z;
            }
        }
        level.operator().apply(&z, &mut b, &mut work);
        clear(level.fixed(), &mut b);
        let forces = (n - level.fixed().len()) as f64;
        let noise = 0.5 * R::epsilon().to_f64_exact() * norm2(&b).to_f64_exact() / forces.sqrt();
        if noise.is_nan() { f64::INFINITY } else { noise }
    }

    /// The smallest Ritz value of `M⁻¹A` that a few steps show: at least so little is seen of something.
    ///
    /// # Cost
    /// Five cycles and four products.
    pub fn least_seen(&self) -> f64 {
        let level = &self.levels()[0];
        let n = level.size();
        let mut work = vec![R::zero(); level.operator().work_len()];
        let mut own = vec![R::zero(); self.work_len()];
        let mut b = vec![R::zero(); n];
        let product = |x: &[R], y: &mut [R]| {
            level.operator().apply(x, y, &mut work);
            clear(level.fixed(), y);
        };
        let divide = |r: &[R], z: &mut [R]| level.smoother().divide_by_diagonal(r, z);
        let solve = |r: &[R], z: &mut [R]| {
            b.copy_from_slice(r);
            clear(level.fixed(), &mut b);
            self.solve(&mut b, z, &mut own);
        };
        least_generalized(n, product, divide, solve)
    }

    /// What the functions that the coarsest level leaves out cost on the finest one, `None` where none are:
    ///
    /// ```text
    /// ‖D⁻¹A x‖ / ‖x‖,  x = P n,  A_c n ≈ 0
    /// ```
    ///
    /// Functions that depend on each other leave the rounding of 0 in x, which is rough, so that this is around 1; a motion that
    /// nothing holds, or what holds it is lost in rounding, leaves that motion and hardly a force.
    ///
    /// # Cost
    /// A prolongation through all levels and one product.
    pub fn left_out(&self) -> Option<f64> {
        let mut x: Vec<R> = self.bottom().null()?.iter().map(|v| R::of(*v)).collect();
        for level in self.levels().iter().rev() {
            let mut finer = vec![R::zero(); level.size()];
            level.correction(&x).write(&mut finer);
            x = finer;
        }
        let level = &self.levels()[0];
        let mut force = vec![R::zero(); x.len()];
        let work_len = level.operator().work_len();
        level
            .operator()
            .apply(&x, &mut force, &mut vec![R::zero(); work_len]);
        let size = norm2(&x).to_f64_exact();
        level.smoother().divide_by_diagonal(&force, &mut x);
        let cost = norm2(&x).to_f64_exact() / size;
        Some(if cost.is_nan() { f64::INFINITY } else { cost })
    }
}
