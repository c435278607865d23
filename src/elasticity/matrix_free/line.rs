//! A line of nodes along x and the line above it, as sums and differences along z, one array per component.

use fracas_operators::Real;
use fracas_operators::simd::{Lanes, MAX_WIDTH};

/// Elements along x that are worked on at a time: four lines of them fit the first-level cache.
pub(super) const TILE: usize = 64;

/// Entries of one array: the nodes of a tile, the nodes that a last, partly filled register reaches, and one register.
const LEN: usize = TILE + 2 * MAX_WIDTH;

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

    /// `(low + high, high − low)` of `nodes` nodes, and one register of zeros behind them.
    #[inline(always)]
    pub(super) fn read<L: Lanes<R>>(&mut self, nodes: usize, low: &[R], high: &[R]) {
        let (low, high) = (&low[..3 * nodes], &high[..3 * nodes]);
        let full = nodes / L::WIDTH * L::WIDTH;
        for i in (0..full).step_by(L::WIDTH) {
            self.read_register::<L>(i, &low[3 * i..], &high[3 * i..]);
        }
        let mut rest = [[R::zero(); 3 * MAX_WIDTH]; 2];
        rest[0][..3 * (nodes - full)].copy_from_slice(&low[3 * full..]);
        rest[1][..3 * (nodes - full)].copy_from_slice(&high[3 * full..]);
        self.read_register::<L>(full, &rest[0], &rest[1]);
        for component in self.0.iter_mut().flatten() {
            L::splat(R::zero()).store(&mut component[full + L::WIDTH..]);
        }
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
        let full = nodes / L::WIDTH * L::WIDTH;
        for i in (0..full).step_by(L::WIDTH) {
            self.add_register::<L>(i, alpha, &mut low[3 * i..], &mut high[3 * i..]);
        }
        let rest = 3 * (nodes - full);
        let mut buffers = [[R::zero(); 3 * MAX_WIDTH]; 2];
        buffers[0][..rest].copy_from_slice(&low[3 * full..]);
        buffers[1][..rest].copy_from_slice(&high[3 * full..]);
        let [first, second] = &mut buffers;
        self.add_register::<L>(full, alpha, first, second);
        low[3 * full..].copy_from_slice(&buffers[0][..rest]);
        high[3 * full..].copy_from_slice(&buffers[1][..rest]);
    }

    #[inline(always)]
    fn add_register<L: Lanes<R>>(&self, i: usize, alpha: R, low: &mut [R], high: &mut [R]) {
        let alpha = L::splat(alpha);
        let zero = L::splat(R::zero());
        let (mut down, mut up) = ([zero; 3], [zero; 3]);
        for c in 0..3 {
            let (sum, difference) = (self.load::<L>(0, c, i), self.load::<L>(1, c, i));
            (down[c], up[c]) = (sum - difference, sum + difference);
        }
        let (down, up) = (L::interleave(down), L::interleave(up));
        for v in 0..3 {
            let at = L::WIDTH * v;
            alpha
                .mul_add(down[v], L::load(&low[at..]))
                .store(&mut low[at..]);
            alpha
                .mul_add(up[v], L::load(&high[at..]))
                .store(&mut high[at..]);
        }
    }
}

/// Three registers of interleaved triples.
#[inline(always)]
fn triples<R: Real, L: Lanes<R>>(from: &[R]) -> [L; 3] {
    let w = L::WIDTH;
    [L::load(from), L::load(&from[w..]), L::load(&from[2 * w..])]
}
