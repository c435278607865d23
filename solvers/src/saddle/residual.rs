//! b − 𝒜x in twice the digits.

use super::{P, SaddleBlocks, T, U};
use fracas_operators::Twofold;
use fracas_operators::sparse::SparseMatrix;
use rayon::prelude::*;

/// Rows that one thread takes at a time. Unit: rows; some ten thousand products.
const ROWS: usize = 256;

impl SaddleBlocks {
    /// `r ← b − 𝒜(x₁ + x₂ + …)` with sums in twice the digits of f64, rounded at the end: the error of x is then 𝒜⁻¹r, however
    /// ill-conditioned 𝒜 is. Residuals in f64 are rounding where stiff rock moves far and soft rock bears the load; those of an x in f64
    /// are rounding of x.
    ///
    /// # Cost
    /// Some five products with 𝒜 for every term of x; `16 n` bytes.
    ///
    /// # Panics
    /// Where b, r or a term of x does not have [`size`](Self::size) entries.
    pub fn residual(&self, b: &[f64], x: &[&[f64]], r: &mut [f64]) {
        let n = self.size();
        assert!(
            b.len() == n && r.len() == n && x.iter().all(|x| x.len() == n),
            "{n} unknowns, b and r of {} and {} entries",
            b.len(),
            r.len()
        );
        let mut sums: Vec<Twofold> = b.iter().copied().map(Twofold::from).collect();
        x.iter().for_each(|x| self.subtract_product(x, &mut sums));
        for (r, sum) in r.iter_mut().zip(&sums) {
            *r = sum.value();
        }
    }

    /// `sums ← sums − 𝒜x`.
    fn subtract_product(&self, x: &[f64], sums: &mut [Twofold]) {
        let layout = self.layout();
        let [u, t] = layout.split([U, T], x);
        let [sums_u, sums_t] = layout.split_mut([U, T], sums);
        add_rows(-1.0, &self.a, u, sums_u);
        add_rows(-1.0, &self.b1, t, sums_u);
        match &self.b2 {
            Some(b2) => add_rows(-1.0, b2, u, sums_t),
            None => {
                for (row, u) in self.b1.outer_iterator().zip(u) {
                    row.iter().for_each(|(j, b)| sums_t[j].add_product(-b, *u));
                }
            }
        }
        if let Some(h) = &self.h {
            add_rows(1.0, h, t, sums_t);
        }
        if let Some(flow) = &self.flow {
            let [p] = layout.split([P], x);
            let [sums_u, sums_p] = layout.split_mut([U, P], sums);
            add_rows(-1.0, &flow.q1, p, sums_u);
            add_rows(-1.0, &flow.q2, u, sums_p);
            add_rows(-1.0, &flow.t, p, sums_p);
        }
    }
}

/// `sums ← sums + α M x`.
fn add_rows(alpha: f64, m: &SparseMatrix<f64>, x: &[f64], sums: &mut [Twofold]) {
    let chunks = sums.par_chunks_mut(ROWS).enumerate();
    chunks.for_each(|(chunk, sums)| {
        for (k, sum) in sums.iter_mut().enumerate() {
            let row = m.outer_view(chunk * ROWS + k);
            let entries = row.iter().flat_map(|row| row.iter());
            entries.for_each(|(j, m)| sum.add_product(alpha * m, x[j]));
        }
    });
}

#[cfg(test)]
mod tests {
    use super::super::FlowBlocks;
    use super::super::samples::sparse;
    use super::*;
    use fracas_operators::random::signed;
    use fracas_operators::vector::norm_inf;
    use fracas_operators::{Dense, LinearOperator};

    /// A whole number of up to 2²⁶ either way, or 0.
    fn whole(i: usize, j: usize, seed: u64) -> f64 {
        let at = (seed * 1_000 + i as u64) * 1_000 + j as u64;
        match (i + j + seed as usize).is_multiple_of(3) {
            true => 0.0,
            false => (signed(at) * 2f64.powi(26)).round(),
        }
    }

    fn blocks(b2: bool, flow: bool) -> SaddleBlocks {
        let (n_u, n_t, n_p) = (300, 20, 7);
        let block = |rows, cols, seed| sparse(rows, cols, |i, j| whole(i, j, seed));
        SaddleBlocks {
            a: block(n_u, n_u, 1),
            b1: block(n_u, n_t, 2),
            b2: b2.then(|| block(n_t, n_u, 3)),
            h: b2.then(|| block(n_t, n_t, 4)),
            rhs_u: vec![0.0; n_u],
            rhs_t: vec![0.0; n_t],
            coordinates: None,
            flow: flow.then(|| FlowBlocks {
                q1: block(n_u, n_p, 5),
                q2: block(n_p, n_u, 6),
                t: block(n_p, n_p, 7),
                rhs_p: vec![0.0; n_p],
            }),
        }
    }

    /// In whole numbers the product is known, and b as near to it as f64 gets.
    #[test]
    fn what_is_left_of_a_product_is_exact() {
        for blocks in
            [(false, false), (true, false), (true, true)].map(|(b2, flow)| blocks(b2, flow))
        {
            let n = blocks.size();
            let operator = super::super::SaddleOperator::new(&blocks);
            let dense = Dense::of_operator(&operator);
            let x: Vec<f64> = (0..n).map(|i| whole(i, 0, 9)).collect();
            let product: Vec<i128> = (0..n)
                .map(|i| {
                    (0..n)
                        .map(|j| dense.entry(i, j) as i128 * x[j] as i128)
                        .sum()
                })
                .collect();
            let b: Vec<f64> = product.iter().map(|p| *p as f64).collect();
            let exact: Vec<f64> = (b.iter().zip(&product))
                .map(|(b, p)| (*b as i128 - p) as f64)
                .collect();
            let mut r = vec![f64::NAN; n];
            blocks.residual(&b, &[&x], &mut r);
            assert!(norm_inf(&exact) > 0.0);
            assert_eq!(r, exact);
            // a second term adds its digits
            let low: Vec<f64> = x.iter().map(|x| x * 2f64.powi(-80)).collect();
            let minus: Vec<f64> = x.iter().map(|x| -x).collect();
            blocks.residual(&b, &[&x, &x, &minus, &low], &mut r);
            let small = |(r, p): (&f64, &i128)| (r - *p as f64 * -(2f64.powi(-80))).abs();
            assert!(r.iter().zip(&exact).all(|(r, e)| (r - e).abs() < 1e-3));
            blocks.residual(&vec![0.0; n], &[&low, &x, &minus], &mut r);
            assert!(r.iter().zip(&product).map(small).all(|e| e < 1e-11));
            // f64 alone does not know it
            r.copy_from_slice(&b);
            operator.apply_add(-1.0, &x, &mut r, &mut vec![0.0; operator.work_len()]);
            assert_ne!(r, exact);
        }
    }
}
