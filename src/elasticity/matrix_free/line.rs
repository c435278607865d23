//! A line of nodes along x and the line above it, as sums and differences along z, one array per component.

use fracas_operators::Real;
use fracas_operators::simd::{Lanes, MAX_WIDTH};

/// Elements along x that are worked on at a time: four lines of them fit the first-level cache.
pub(super) const TILE: usize = 64;

/// Entries of one array: the nodes of a tile and the two registers of zeros behind them.
const LEN: usize = TILE + 3 * MAX_WIDTH;

/// `[sum, difference][component]` of two lines of nodes; aligned so that no register straddles two cache lines.
#[repr(align(64))]
pub(super) struct Line<R>([[[R; LEN]; 3]; 2]);

impl<R: Real> Line<R> {
    /// All zero.
    #[inline(always)]
    pub(super) fn new() -> Self {
        Self([[[R::zero(); LEN]; 3]; 2])
    }

    /// Sets all to zero.
    #[inline(always)]
    pub(super) fn clear(&mut self) {
        *self = Self::new();
    }

    /// Entries from node i.
    #[inline(always)]
    pub(super) fn load<L: Lanes<R>>(&self, z: usize, component: usize, i: usize) -> L {
        L::load(&self.0[z][component][i..])
    }

    /// Entries from node i, writable.
    #[inline(always)]
    pub(super) fn lanes(&mut self, z: usize, component: usize, i: usize) -> &mut [R] {
        &mut self.0[z][component][i..]
    }

    /// `(low + high, high − low)` of `nodes` nodes, and at least one register of zeros behind them.
    #[inline(always)]
    pub(super) fn read<L: Lanes<R>>(&mut self, nodes: usize, low: &[R], high: &[R]) {
        let (low, high) = (&low[..3 * nodes], &high[..3 * nodes]);
        for component in self.0.iter_mut().flatten() {
            for i in [nodes, nodes + L::WIDTH] {
                L::splat(R::zero()).store(&mut component[i..]);
            }
        }
        if nodes < L::WIDTH {
            let mut padded = [[R::zero(); 3 * MAX_WIDTH]; 2];
            padded[0][..low.len()].copy_from_slice(low);
            padded[1][..high.len()].copy_from_slice(high);
            self.read_register::<L>(0, &padded[0], &padded[1]);
            return;
        }
        // The last register overlaps the one before it: the same values are written twice.
        let last = nodes - L::WIDTH;
        for i in (0..last).step_by(L::WIDTH) {
            self.read_register::<L>(i, &low[3 * i..], &high[3 * i..]);
        }
        self.read_register::<L>(last, &low[3 * last..], &high[3 * last..]);
    }

    #[inline(always)]
    fn read_register<L: Lanes<R>>(&mut self, i: usize, low: &[R], high: &[R]) {
        let ([a, b, c], [d, e, f]) = (triples::<R, L>(low), triples::<R, L>(high));
        let sums = L::deinterleave([a + d, b + e, c + f]);
        let differences = L::deinterleave([d - a, e - b, f - c]);
        for c in 0..3 {
            sums[c].store(&mut self.0[0][c][i..]);
            differences[c].store(&mut self.0[1][c][i..]);
        }
    }

    /// The adjoint of [`read`](Self::read), added: `low += α (F_p − F_d)`, `high += α (F_p + F_d)`.
    #[inline(always)]
    pub(super) fn add_to<L: Lanes<R>>(
        &self,
        nodes: usize,
        alpha: R,
        low: &mut [R],
        high: &mut [R],
    ) {
        if nodes < L::WIDTH {
            let mut padded = [[R::zero(); 3 * MAX_WIDTH]; 2];
            padded[0][..low.len()].copy_from_slice(low);
            padded[1][..high.len()].copy_from_slice(high);
            let (low_sum, high_sum) = self.summed::<L>(0, alpha, &padded[0], &padded[1]);
            store_triples(low_sum, &mut padded[0]);
            store_triples(high_sum, &mut padded[1]);
            low.copy_from_slice(&padded[0][..low.len()]);
            high.copy_from_slice(&padded[1][..high.len()]);
            return;
        }
        // The last register overlaps the one before it: computed before that one is written, both write the same values.
        let last = nodes - L::WIDTH;
        let (low_last, high_last) =
            self.summed::<L>(last, alpha, &low[3 * last..], &high[3 * last..]);
        for i in (0..last).step_by(L::WIDTH) {
            let (low_sum, high_sum) = self.summed::<L>(i, alpha, &low[3 * i..], &high[3 * i..]);
            store_triples(low_sum, &mut low[3 * i..]);
            store_triples(high_sum, &mut high[3 * i..]);
        }
        store_triples(low_last, &mut low[3 * last..]);
        store_triples(high_last, &mut high[3 * last..]);
    }

    /// `(low + α (F_p − F_d), high + α (F_p + F_d))` of one register of nodes.
    #[inline(always)]
    fn summed<L: Lanes<R>>(&self, i: usize, alpha: R, low: &[R], high: &[R]) -> ([L; 3], [L; 3]) {
        let alpha = L::splat(alpha);
        let zero = L::splat(R::zero());
        let (mut down, mut up) = ([zero; 3], [zero; 3]);
        for c in 0..3 {
            let (sum, difference) = (self.load::<L>(0, c, i), self.load::<L>(1, c, i));
            (down[c], up[c]) = (sum - difference, sum + difference);
        }
        let (mut down, mut up) = (L::interleave(down), L::interleave(up));
        let (low, high) = (triples::<R, L>(low), triples::<R, L>(high));
        for v in 0..3 {
            down[v] = alpha.mul_add(down[v], low[v]);
            up[v] = alpha.mul_add(up[v], high[v]);
        }
        (down, up)
    }
}

/// Writes three registers.
#[inline(always)]
fn store_triples<R: Real, L: Lanes<R>>(values: [L; 3], to: &mut [R]) {
    for v in 0..3 {
        values[v].store(&mut to[L::WIDTH * v..]);
    }
}

/// Three registers of interleaved triples.
#[inline(always)]
fn triples<R: Real, L: Lanes<R>>(from: &[R]) -> [L; 3] {
    let w = L::WIDTH;
    [L::load(from), L::load(&from[w..]), L::load(&from[2 * w..])]
}
