//! Cholesky's factors of the stiffness of what slides, kept where what slides stays.

use fracas_operators::vector::dot;

/// `k − W = L Lᵀ` on the elements that slide, in the order in which they began to.
///
/// Where elements join, rows are added; where one lets go or its slope changes, the rows from its own on are made again.
#[derive(Clone, Debug, Default)]
pub(super) struct SlidingFactor {
    /// Element of a row, and its own entry `k_0 − W_i` [Pa/m].
    of: Vec<(usize, f64)>,
    /// Rows of L one after another, row a of length a + 1.
    rows: Vec<f64>,
}

/// Where row `a` begins.
fn start(a: usize) -> usize {
    a * (a + 1) / 2
}

impl SlidingFactor {
    /// To the elements with an own entry `k_0 − W_i`, `None` for what is stuck; false, with nothing kept, where k − W is not positive
    /// definite. `stiffness` is k_m.
    ///
    /// # Cost
    /// O(m² r) for r of m rows that are new.
    pub(super) fn bring_to(&mut self, stiffness: &[f64], own: &[Option<f64>]) -> bool {
        let is_right = |(i, entry): &(usize, f64)| own[*i] == Some(*entry);
        let kept = self.of.iter().take_while(|row| is_right(row)).count();
        let mut is_in = vec![false; own.len()];
        for (i, _) in &self.of[..kept] {
            is_in[*i] = true;
        }
        self.of.truncate(kept);
        self.rows.truncate(start(kept));
        for (i, entry) in own.iter().enumerate() {
            let Some(entry) = entry else { continue };
            if !is_in[i] && !self.add(stiffness, i, *entry) {
                *self = Self::default();
                return false;
            }
        }
        true
    }

    /// The row of an element; false where its pivot is not positive.
    fn add(&mut self, stiffness: &[f64], i: usize, entry: f64) -> bool {
        let a = self.of.len();
        for b in 0..a {
            let (head, own) = self.rows.split_at(start(a));
            let other = &head[start(b)..=start(b) + b];
            let k = stiffness[i.abs_diff(self.of[b].0)];
            let v = (k - dot(&own[..b], &other[..b])) / other[b];
            self.rows.push(v);
        }
        let own = &self.rows[start(a)..];
        let pivot = entry - dot(own, own);
        self.rows.push(pivot.sqrt());
        self.of.push((i, entry));
        pivot > 0.0
    }

    /// The slip `(k − W)⁻¹ b` of what slides, in `slip` at its elements [m]; b [Pa].
    pub(super) fn solve(&self, b: impl Fn(usize) -> f64, slip: &mut [f64]) {
        let mut x: Vec<f64> = Vec::with_capacity(self.of.len());
        for (a, (i, _)) in self.of.iter().enumerate() {
            let row = &self.rows[start(a)..=start(a) + a];
            x.push((b(*i) - dot(&row[..a], &x)) / row[a]);
        }
        for (a, (i, _)) in self.of.iter().enumerate().rev() {
            let row = &self.rows[start(a)..=start(a) + a];
            let d = x[a] / row[a];
            for (x, entry) in x[..a].iter_mut().zip(row) {
                *x -= entry * d;
            }
            slip[*i] = d;
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use fracas_operators::random::Random;

    /// Elements that join, let go and weaken in any order: the slip is that of a factor made anew, and its equations hold.
    #[test]
    fn a_factor_that_follows_is_one_made_anew() {
        for seed in 0..40 {
            let r = &mut Random::new(seed);
            let n = r.whole(2, 60) as usize;
            let stiffness: Vec<f64> = (0..n).map(|m| 1.0 / (0.25 - (m * m) as f64)).collect();
            let mut own: Vec<Option<f64>> = vec![None; n];
            let mut followed = SlidingFactor::default();
            for _ in 0..12 {
                for entry in &mut own {
                    if r.chance(0.15) {
                        // rows of k sum to more than 0, so that this stays positive definite
                        let weaker = 4.0 - if r.chance(0.5) { 0.0 } else { 0.01 / n as f64 };
                        *entry = if r.chance(0.7) { Some(weaker) } else { None };
                    }
                }
                assert!(followed.bring_to(&stiffness, &own));
                let b: Vec<f64> = (0..n).map(|_| r.between(-1.0, 1.0)).collect();
                let mut slip = vec![0.0; n];
                followed.solve(|i| b[i], &mut slip);
                let mut anew = SlidingFactor::default();
                assert!(anew.bring_to(&stiffness, &own));
                let mut expected = vec![0.0; n];
                anew.solve(|i| b[i], &mut expected);
                for i in 0..n {
                    assert!((slip[i] - expected[i]).abs() < 1e-10, "seed {seed}");
                    let Some(entry) = own[i] else {
                        assert!(slip[i] == 0.0);
                        continue;
                    };
                    let others = (0..n).filter(|j| *j != i);
                    let rest: f64 = others.map(|j| stiffness[i.abs_diff(j)] * slip[j]).sum();
                    assert!((entry * slip[i] + rest - b[i]).abs() < 1e-10, "seed {seed}");
                }
            }
        }
    }

    #[test]
    fn what_is_not_positive_definite_is_said_and_forgotten() {
        let stiffness = [4.0, -4.0 / 3.0];
        let mut factor = SlidingFactor::default();
        assert!(factor.bring_to(&stiffness, &[Some(4.0), None]));
        assert!(!factor.bring_to(&stiffness, &[Some(4.0), Some(0.4)]));
        assert!(factor.of.is_empty() && factor.rows.is_empty());
        assert!(factor.bring_to(&stiffness, &[Some(4.0), Some(0.5)]));
    }
}
