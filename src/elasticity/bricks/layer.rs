//! The sweep over one layer of cells of a structured grid, without index arrays.
//!
//! The parities along z are formed once per line of nodes, those along y and x in registers, so neighbouring cells share
//! what they can; lines are cut to [`BLOCK`] cells so that everything stays in the first-level cache.

use super::parity::{Coefficients, forces};
use fracas_operators::Real;
use fracas_operators::simd::Simd;

/// Most cells of a line that are treated at once: 38 KiB of scratch in f64, inside a 48 KiB first-level cache.
const BLOCK: usize = 96;

/// Room for the nodes of a block, and for whole vectors (at most 16 lanes) behind the last one.
const LINE: usize = BLOCK + 24;

/// Values along x, one per node or cell.
type Line<R> = [R; LINE];

/// Sums (even) and differences (odd) along z of two lines of nodes: `[even, odd][component]`.
type ZParities<R> = [[Line<R>; 3]; 2];

/// Forces on a line of nodes by the cells to their right (low) and, shifted by one, to their left (high).
#[derive(Clone, Copy)]
struct LineForces<R> {
    low: ZParities<R>,
    high: ZParities<R>,
}

/// Geometry and material of the grid, as one sweep sees it.
pub(super) struct Layers<'a, R> {
    pub(super) cells: [usize; 3],
    pub(super) spacing: [&'a [R]; 3],
    pub(super) lambda: &'a [R],
    pub(super) shear: &'a [R],
}

/// Sizes of the cells of a row.
struct Row<R> {
    /// `h_x / 16`.
    width: Line<R>,
    /// `1 / (16 h_x)`.
    inverse_width: Line<R>,
    height: [R; 2],
}

/// All that a sweep keeps between rows; lives on the stack.
struct Scratch<R> {
    z: [ZParities<R>; 2],
    out: [LineForces<R>; 2],
    row: Row<R>,
}

impl<R: Real> Scratch<R> {
    fn new() -> Self {
        let zero = [R::zero(); LINE];
        let parities = [[zero; 3]; 2];
        Self {
            z: [parities; 2],
            out: [LineForces {
                low: parities,
                high: parities,
            }; 2],
            row: Row {
                width: zero,
                inverse_width: zero,
                height: [R::zero(); 2],
            },
        }
    }
}

impl<R: Real> Layers<'_, R> {
    /// `y ← y + factor · K x` for layer `k` of cells; `y` holds the two node planes of the layer, `x` all nodes.
    #[inline(always)]
    pub(super) fn sweep<V: Simd<R>>(&self, k: usize, factor: R, x: &[R], y: &mut [R]) {
        let [nx, ny, _] = self.cells;
        let mut s = Scratch::new();
        let plane = 3 * (nx + 1) * (ny + 1);
        let (x0, x1) = x[k * plane..(k + 2) * plane].split_at(plane);
        let (y0, y1) = y.split_at_mut(plane);
        let block = nx.div_ceil(nx.div_ceil(BLOCK)).next_multiple_of(16);
        for start in (0..nx).step_by(block) {
            let cells = block.min(nx - start);
            let line = |j: usize| {
                let first = 3 * (start + (nx + 1) * j);
                first..first + 3 * (cells + 1)
            };
            s.row.start(&self.spacing[0][start..start + cells]);
            z_parities::<R, V>(&x0[line(0)], &x1[line(0)], &mut s.z[0]);
            s.out.iter_mut().for_each(LineForces::clear);
            let (mut front, mut back) = (0, 1);
            for j in 0..ny {
                let first = start + nx * (j + ny * k);
                let material = (
                    &self.lambda[first..first + cells],
                    &self.shear[first..first + cells],
                );
                s.row.height = [self.spacing[1][j], self.spacing[2][k]];
                z_parities::<R, V>(&x0[line(j + 1)], &x1[line(j + 1)], &mut s.z[back]);
                let [out_0, out_1] = &mut s.out;
                let out = if front == 0 {
                    (out_0, out_1)
                } else {
                    (out_1, out_0)
                };
                row_forces::<R, V>((&s.z[front], &s.z[back]), &s.row, material, out);
                s.finish_line::<V>(front, cells, factor, &mut y0[line(j)], &mut y1[line(j)]);
                (front, back) = (back, front);
            }
            s.finish_line::<V>(front, cells, factor, &mut y0[line(ny)], &mut y1[line(ny)]);
        }
    }
}

impl<R: Real> Row<R> {
    /// Widths of the cells of a block.
    #[inline(always)]
    fn start(&mut self, widths: &[R]) {
        let sixteen = R::of(16.0);
        for (i, h) in widths.iter().enumerate() {
            self.width[i] = *h / sixteen;
            self.inverse_width[i] = R::one() / (sixteen * *h);
        }
    }
}

impl<R: Real> LineForces<R> {
    #[inline(always)]
    fn clear(&mut self) {
        for line in self.low.iter_mut().chain(&mut self.high).flatten() {
            line.fill(R::zero());
        }
    }
}

/// Even and odd parts along z of two interleaved lines, component by component.
#[inline(always)]
fn z_parities<R: Real, V: Simd<R>>(below: &[R], above: &[R], [even, odd]: &mut ZParities<R>) {
    let group = 3 * V::LANES;
    let whole = below.len() / group * group;
    for (n, (b, a)) in below
        .chunks_exact(group)
        .zip(above.chunks_exact(group))
        .enumerate()
    {
        let b = V::deinterleave([0, 1, 2].map(|v| V::load(&b[v * V::LANES..])));
        let a = V::deinterleave([0, 1, 2].map(|v| V::load(&a[v * V::LANES..])));
        for c in 0..3 {
            a[c].add(b[c]).store(&mut even[c][n * V::LANES..]);
            a[c].sub(b[c]).store(&mut odd[c][n * V::LANES..]);
        }
    }
    for (entry, (b, a)) in below.iter().zip(above).enumerate().skip(whole) {
        even[entry % 3][entry / 3] = *a + *b;
        odd[entry % 3][entry / 3] = *a - *b;
    }
}

/// The first lanes of `from`, zero where it is shorter than a vector.
#[inline(always)]
fn load_padded<R: Real, V: Simd<R>>(from: &[R]) -> V {
    if from.len() >= V::LANES {
        return V::load(from);
    }
    let mut padded = [R::zero(); 16];
    padded[..from.len()].copy_from_slice(from);
    V::load(&padded)
}

/// Forces of a row of cells: adds to the line of nodes at its front, starts the one at its back.
#[inline(always)]
fn row_forces<R: Real, V: Simd<R>>(
    (z_front, z_back): (&ZParities<R>, &ZParities<R>),
    row: &Row<R>,
    (lambda, shear): (&[R], &[R]),
    (out_front, out_back): (&mut LineForces<R>, &mut LineForces<R>),
) {
    let sixteenth = R::of(1.0 / 16.0);
    let [h_y, h_z] = row.height;
    let [area, z_over_y, y_over_z] = [h_y * h_z, h_z / h_y, h_y / h_z].map(V::splat);
    let beta_yz = [h_y * sixteenth, h_z * sixteenth].map(V::splat);
    for i in (0..lambda.len()).step_by(V::LANES) {
        let width = V::load(&row.width[i..]);
        let alpha = [
            area.mul(V::load(&row.inverse_width[i..])),
            z_over_y.mul(width),
            y_over_z.mul(width),
        ];
        let beta = [width, beta_yz[0], beta_yz[1]];
        // cells behind the last have no stiffness, so what stands in their lanes does not matter
        let k = Coefficients::new(
            load_padded(&lambda[i..]),
            load_padded(&shear[i..]),
            alpha,
            beta,
        );
        let mut u = [[V::splat(R::zero()); 8]; 3];
        for c in 0..3 {
            for p in 0..2 {
                let (front, back) = (&z_front[p][c], &z_back[p][c]);
                let (f0, f1) = (V::load(&front[i..]), V::load(&front[i + 1..]));
                let (b0, b1) = (V::load(&back[i..]), V::load(&back[i + 1..]));
                let (even0, even1) = (b0.add(f0), b1.add(f1));
                let (odd0, odd1) = (b0.sub(f0), b1.sub(f1));
                u[c][4 * p] = even1.add(even0);
                u[c][4 * p + 1] = even1.sub(even0);
                u[c][4 * p + 2] = odd1.add(odd0);
                u[c][4 * p + 3] = odd1.sub(odd0);
            }
        }
        let f = forces::<R, V>(&u, &k);
        for c in 0..3 {
            for p in 0..2 {
                let (even_low, even_high) = (
                    f[c][4 * p].sub(f[c][4 * p + 1]),
                    f[c][4 * p].add(f[c][4 * p + 1]),
                );
                let (odd_low, odd_high) = (
                    f[c][4 * p + 2].sub(f[c][4 * p + 3]),
                    f[c][4 * p + 2].add(f[c][4 * p + 3]),
                );
                let low = &mut out_front.low[p][c][i..];
                V::load(low).add(even_low.sub(odd_low)).store(low);
                let high = &mut out_front.high[p][c][i + 1..];
                V::load(high).add(even_high.sub(odd_high)).store(high);
                even_low.add(odd_low).store(&mut out_back.low[p][c][i..]);
                even_high
                    .add(odd_high)
                    .store(&mut out_back.high[p][c][i + 1..]);
            }
        }
    }
}

impl<R: Real> Scratch<R> {
    /// Adds the finished line `out[line]` to the two node planes.
    #[inline(always)]
    fn finish_line<V: Simd<R>>(
        &mut self,
        line: usize,
        cells: usize,
        factor: R,
        below: &mut [R],
        above: &mut [R],
    ) {
        let scale = V::splat(factor);
        let LineForces { low, high } = &self.out[line];
        let group = 3 * V::LANES;
        let whole = (cells + 1) / V::LANES * V::LANES;
        let parts = below
            .chunks_exact_mut(group)
            .zip(above.chunks_exact_mut(group));
        for (i, (below, above)) in (0..whole).step_by(V::LANES).zip(parts) {
            let sum = |p: usize, c: usize| V::load(&low[p][c][i..]).add(V::load(&high[p][c][i..]));
            let (even, odd) = ([0, 1, 2].map(|c| sum(0, c)), [0, 1, 2].map(|c| sum(1, c)));
            add_to(
                below,
                scale,
                V::interleave([0, 1, 2].map(|c| even[c].sub(odd[c]))),
            );
            add_to(
                above,
                scale,
                V::interleave([0, 1, 2].map(|c| even[c].add(odd[c]))),
            );
        }
        for i in whole..=cells {
            for c in 0..3 {
                let even = low[0][c][i] + high[0][c][i];
                let odd = low[1][c][i] + high[1][c][i];
                below[3 * i + c] += factor * (even - odd);
                above[3 * i + c] += factor * (even + odd);
            }
        }
    }
}

/// `y ← y + factor · v` for three vectors in a row.
#[inline(always)]
fn add_to<R: Real, V: Simd<R>>(y: &mut [R], factor: V, vectors: [V; 3]) {
    for (v, part) in vectors.into_iter().zip(y.chunks_exact_mut(V::LANES)) {
        factor.mul_add(v, V::load(part)).store(part);
    }
}
