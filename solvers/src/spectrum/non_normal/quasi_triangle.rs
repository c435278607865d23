//! `(zI − T)x = b` of a real upper quasi-triangular T at as many points z as a register has lanes.

use faer::c64;
use fracas_operators::simd::{Kernel, Lanes, Level};
use std::ops::Range;

/// Rows that are solved for at once: with real and imaginary sums of each, their lanes fit the 16 registers of AVX2.
const ROWS: usize = 4;

/// T in panels of at most [`ROWS`] rows that split no block of its diagonal.
pub(super) struct QuasiTriangle {
    n: usize,
    /// Rows.
    panels: Vec<Range<usize>>,
    /// Of each panel the entries right of its own square, column after column.
    right: Vec<f64>,
    /// Where those of a panel begin.
    begins: Vec<usize>,
    /// Of each panel its own square, row after row.
    squares: Vec<Vec<f64>>,
}

impl QuasiTriangle {
    /// Panels of n rows; `couples(i)` where rows i and i + 1 are a block.
    pub(super) fn panels_of(n: usize, couples: impl Fn(usize) -> bool) -> Vec<Range<usize>> {
        let mut panels = Vec::new();
        let mut first = 0;
        while first < n {
            let mut end = n.min(first + ROWS);
            if end < n && couples(end - 1) {
                end -= 1;
            }
            panels.push(first..end);
            first = end;
        }
        panels
    }

    /// By its entries (row, column).
    pub(super) fn new(
        n: usize,
        panels: Vec<Range<usize>>,
        entry: impl Fn(usize, usize) -> f64,
    ) -> Self {
        let (mut right, mut begins, mut squares) = (Vec::new(), Vec::new(), Vec::new());
        for rows in &panels {
            begins.push(right.len());
            for j in rows.end..n {
                right.extend(rows.clone().map(|i| entry(i, j)));
            }
            let of_row = |i| rows.clone().map(move |j| (i, j));
            let square = rows.clone().flat_map(of_row).map(|(i, j)| entry(i, j));
            squares.push(square.collect());
        }
        Self {
            n,
            panels,
            right,
            begins,
            squares,
        }
    }

    /// `x ← (zI − T)⁻¹x`: n rows of real and imaginary parts, a lane per point z.
    pub(super) fn solve(&self, inverses: &Inverses, x: &mut [f64]) {
        assert_eq!(x.len(), 2 * self.n * inverses.width, "lanes of x");
        Level::best().run(Solve {
            triangle: self,
            inverses,
            x,
        });
    }
}

/// Inverses of `zI − T` of the panels' own squares, a lane per point z.
///
/// A square of an ill-conditioned `zI − T` is no worse conditioned than the whole.
pub(super) struct Inverses {
    width: usize,
    /// Of each panel: rows of columns of real and imaginary parts.
    of_panels: Vec<Vec<f64>>,
    /// Lanes at an eigenvalue.
    singular: Vec<bool>,
}

impl Inverses {
    /// At these points, no more than `width`.
    pub(super) fn new(triangle: &QuasiTriangle, points: &[c64], width: usize) -> Self {
        let mut singular = vec![false; points.len()];
        let of_panel = |(rows, square): (&Range<usize>, &Vec<f64>)| {
            let m = rows.len();
            let mut lanes = vec![0.0; 2 * m * m * width];
            for (lane, z) in points.iter().enumerate() {
                match inverse(m, square, *z) {
                    Some(inverse) => {
                        let entries = lanes.chunks_exact_mut(2 * width);
                        for (entry, value) in entries.zip(&inverse) {
                            (entry[lane], entry[width + lane]) = (value.re, value.im);
                        }
                    }
                    None => singular[lane] = true,
                }
            }
            lanes
        };
        let panels = triangle.panels.iter().zip(&triangle.squares);
        let of_panels = panels.map(of_panel).collect();
        Self {
            width,
            of_panels,
            singular,
        }
    }

    /// Those of `z̄I − Tᵀ` in reverse order.
    pub(super) fn adjoint(&self, mirrored: &QuasiTriangle) -> Self {
        let panels = self.of_panels.iter().rev().zip(&mirrored.panels);
        let turned = panels.map(|(lanes, rows)| {
            let (m, length) = (rows.len(), 2 * self.width);
            let from = |k: usize| {
                let (i, j) = (k / m, k % m);
                ((m - 1 - j) * m + m - 1 - i) * length
            };
            let entries = (0..m * m).flat_map(|k| {
                let (re, im) = lanes[from(k)..][..length].split_at(self.width);
                re.iter().copied().chain(im.iter().map(|v| -v))
            });
            entries.collect()
        });
        Self {
            width: self.width,
            of_panels: turned.collect(),
            singular: self.singular.clone(),
        }
    }

    /// Whether the point of this lane is an eigenvalue, as far as can be seen.
    pub(super) fn is_singular(&self, lane: usize) -> bool {
        self.singular[lane]
    }
}

/// `(zI − T)⁻¹` of m rows by Gauss and Jordan with row exchanges; `None` where it does not exist.
fn inverse(m: usize, square: &[f64], z: c64) -> Option<[c64; ROWS * ROWS]> {
    let zero = c64::new(0.0, 0.0);
    let one = c64::new(1.0, 0.0);
    let mut a = [[zero; ROWS]; ROWS];
    let mut b = [[zero; ROWS]; ROWS];
    for i in 0..m {
        for j in 0..m {
            a[i][j] = c64::new(-square[i * m + j], 0.0);
        }
        a[i][i] += z;
        b[i][i] = one;
    }
    for k in 0..m {
        let size = |i: &usize| a[*i][k].re.hypot(a[*i][k].im);
        let pivot = (k..m).max_by(|i, j| size(i).total_cmp(&size(j)))?;
        if size(&pivot) == 0.0 {
            return None;
        }
        a.swap(k, pivot);
        b.swap(k, pivot);
        let scale = one / a[k][k];
        let (row_a, row_b) = (a[k].map(|v| v * scale), b[k].map(|v| v * scale));
        for i in 0..m {
            let factor = a[i][k];
            if i == k || factor == zero {
                continue;
            }
            for j in 0..m {
                a[i][j] -= factor * row_a[j];
                b[i][j] -= factor * row_b[j];
            }
        }
        (a[k], b[k]) = (row_a, row_b);
    }
    let mut all = [zero; ROWS * ROWS];
    for i in 0..m {
        all[i * m..(i + 1) * m].copy_from_slice(&b[i][..m]);
    }
    Some(all)
}

/// One back substitution.
struct Solve<'a> {
    triangle: &'a QuasiTriangle,
    inverses: &'a Inverses,
    x: &'a mut [f64],
}

impl Kernel<f64> for Solve<'_> {
    #[inline(always)]
    fn run<L: Lanes<f64>>(self) {
        let QuasiTriangle {
            panels,
            right,
            begins,
            ..
        } = self.triangle;
        for p in (0..panels.len()).rev() {
            let t = &right[begins[p]..];
            let inverse = &self.inverses.of_panels[p][..];
            let first = panels[p].start;
            match panels[p].len() {
                1 => panel::<L, 1>(first, t, inverse, self.x),
                2 => panel::<L, 2>(first, t, inverse, self.x),
                3 => panel::<L, 3>(first, t, inverse, self.x),
                _ => panel::<L, ROWS>(first, t, inverse, self.x),
            }
        }
    }
}

/// `x_p ← (zI − T_pp)⁻¹(x_p + Σ_j T_pj x_j)` over the columns j right of the panel p.
#[inline(always)]
fn panel<L: Lanes<f64>, const M: usize>(first: usize, t: &[f64], inverse: &[f64], x: &mut [f64]) {
    let row = 2 * L::WIDTH;
    let (x, behind) = x[first * row..].split_at_mut(M * row);
    let mut re = [L::splat(0.0); M];
    let mut im = [L::splat(0.0); M];
    for r in 0..M {
        re[r] = L::load(&x[r * row..]);
        im[r] = L::load(&x[r * row + L::WIDTH..]);
    }
    for (t, x) in t.chunks_exact(M).zip(behind.chunks_exact(row)) {
        let (x_re, x_im) = (L::load(x), L::load(&x[L::WIDTH..]));
        for r in 0..M {
            let t = L::splat(t[r]);
            re[r] = t.mul_add(x_re, re[r]);
            im[r] = t.mul_add(x_im, im[r]);
        }
    }
    for r in 0..M {
        let (mut y_re, mut y_im) = (L::splat(0.0), L::splat(0.0));
        for c in 0..M {
            let entry = &inverse[(r * M + c) * row..];
            let (a, b) = (L::load(entry), L::load(&entry[L::WIDTH..]));
            y_re = a.mul_add(re[c], y_re).minus_product(b, im[c]);
            y_im = a.mul_add(im[c], b.mul_add(re[c], y_im));
        }
        y_re.store(&mut x[r * row..]);
        y_im.store(&mut x[r * row + L::WIDTH..]);
    }
}
