//! One task of a product with bricks: sweeps along y, the registers over consecutive elements along x.
#![allow(unsafe_code, reason = "writes of tasks that share no entry")]

use super::brick::{Brick, Face, all_forces, forces, put, taken, to_corners, to_face};
use super::bricks::{Bricks, SplitElement, Task};
use super::line;
use fracas_operators::Real;
use fracas_operators::shared::Shared;
use fracas_operators::simd::{CACHE_LINE, Kernel, Lanes, MAX_WIDTH, prefetch};

/// Element lines of one task along y and z. Two neighbouring tasks share node lines, so they have different colours;
/// long enough that the lines computed twice are few, short enough that a sweep's lines stay in the first-level cache
/// and a small mesh has a task for every thread.
pub(super) const TASK: [usize; 2] = [16, 4];

/// A sweep over whole registers.
const WHOLE: u8 = 0;

/// A sweep over fewer elements than a register has lanes, through padded copies of their lines.
const PADDED: u8 = 1;

/// A sweep over the last `WIDTH` elements of lines, of which those that other registers have count nothing.
const OVERLAPPED: u8 = 2;

/// What becomes of the elements of a line that do not fill a register.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Rest {
    /// There are none.
    None,
    /// Few: they take the indexed path, which fills registers across lines.
    Indexed,
    /// A register that overlaps the one before.
    Overlapped,
    /// The line is shorter than a register.
    Padded,
}

impl Rest {
    /// Registers of `width` on lines of `nx` elements; an element costs about four times as much on the indexed path.
    pub(super) fn of(nx: usize, width: usize) -> Self {
        match nx % width {
            0 => Self::None,
            _ if nx < width => Self::Padded,
            rest if 4 * rest <= width => Self::Indexed,
            _ => Self::Overlapped,
        }
    }
}

/// Moduli of elements, 0 for those that another register has.
#[inline(always)]
fn once<R: Real, L: Lanes<R>, const PART: u8>(moduli: L, counts: L) -> L {
    if PART == OVERLAPPED {
        moduli * counts
    } else {
        moduli
    }
}

/// One task of one product.
pub(super) struct Product<'a, R> {
    pub(super) bricks: &'a Bricks<R>,
    pub(super) alpha: R,
    pub(super) x: &'a [R],
    pub(super) y: &'a Shared<'a, R>,
    pub(super) task: &'a Task<R>,
}

/// Forces on the right nodes of elements, `[component][sum, difference along z]`; only the last is not yet added.
type Carried<L> = [[L; 2]; 3];

impl<R: Real> Kernel<R> for Product<'_, R> {
    #[inline(always)]
    fn run<L: Lanes<R>>(self) {
        let nx = self.bricks.cells[0];
        let whole = nx - nx % L::WIDTH;
        let rest = Rest::of(nx, L::WIDTH);
        for k in self.task.lines[1].clone() {
            let mut carried = [[[L::splat(R::zero()); 2]; 3]; TASK[0] + 1];
            for first in (0..whole).step_by(L::WIDTH) {
                self.sweep::<L, WHOLE>(k, first, &mut carried);
            }
            match rest {
                Rest::Padded => self.sweep::<L, PADDED>(k, whole, &mut carried),
                Rest::None | Rest::Indexed => self.nodes_behind(whole, k, &carried),
                Rest::Overlapped => {
                    self.nodes_behind(whole, k, &carried);
                    carried = [[[L::splat(R::zero()); 2]; 3]; TASK[0] + 1];
                    self.sweep::<L, OVERLAPPED>(k, nx - L::WIDTH, &mut carried);
                    self.nodes_behind(nx, k, &carried);
                }
            }
        }
        for chunk in self.task.split.chunks(L::WIDTH) {
            self.split::<L>(chunk);
        }
    }
}

impl<R: Real> Product<'_, R> {
    /// First unknown of the node (i, j, k).
    #[inline(always)]
    fn place(&self, i: usize, j: usize, k: usize) -> usize {
        let [nx, ny, _] = self.bricks.cells;
        3 * (i + (nx + 1) * (j + (ny + 1) * k))
    }

    /// Elements `first..first + WIDTH` of all lines of the layer k: those of a `WHOLE` register, the fewer ones at the end of
    /// the lines with their last node if `PADDED`, those that no register had before if `OVERLAPPED`. A face of elements is
    /// read once and its forces are added to y once.
    #[inline(always)]
    fn sweep<L: Lanes<R>, const PART: u8>(
        &self,
        k: usize,
        first: usize,
        carried: &mut [Carried<L>; TASK[0] + 1],
    ) {
        let bricks = self.bricks;
        let lines = self.task.lines[0].clone();
        let (r, t) = (
            L::load(&bricks.inverse[0][first..]),
            L::splat(bricks.inverse[2][k]),
        );
        let mut counts = [R::zero(); MAX_WIDTH];
        if PART == OVERLAPPED {
            counts[L::WIDTH - bricks.cells[0] % L::WIDTH..].fill(R::one());
        }
        let counts = L::load(&counts);
        // What the next sweep needs on its upper lines, which are too far apart for the machine to guess.
        let next = if first + L::WIDTH < bricks.cells[0] {
            (first + L::WIDTH, k)
        } else {
            (0, k + 1)
        };
        let mut materials_ahead = next.0 + bricks.stride * (lines.start + bricks.cells[1] * next.1);
        let mut ahead = self.place(next.0, lines.start, next.1 + 1);
        // Both faces stay in memory, chosen by parity: in registers they would only be moved and spilled.
        let nothing = [[[L::splat(R::zero()); 2]; 2]; 3];
        let row = self.place(0, 1, 0);
        let mut at = [k, k + 1].map(|k| self.place(first, lines.start, k));
        let mut faces = [self.read::<L, PART>(first, at), nothing];
        let mut materials = first + bricks.stride * (lines.start + bricks.cells[1] * k);
        let mut waiting = [nothing; 2];
        let mut now = 0;
        let inverse_y = &bricks.inverse[1][lines.clone()];
        for (s, carried) in inverse_y.iter().zip(&mut *carried) {
            let next = 1 - now;
            let behind = [at[0] + row, at[1] + row];
            let high = self.read::<L, PART>(first, behind);
            faces[next] = high;
            // every line of elements is padded to whole registers
            let elements = materials..materials + L::WIDTH;
            let brick = Brick {
                inverse: [r, L::splat(*s), t],
                lambda: once::<R, L, PART>(L::load(&bricks.lambda[elements.clone()]), counts),
                shear: once::<R, L, PART>(L::load(&bricks.shear[elements]), counts),
            };
            if PART != PADDED {
                self.ask(ahead, materials_ahead);
                (ahead, materials_ahead) = (ahead + row, materials_ahead + bricks.stride);
            }
            let mut near = nothing;
            for group in 0..4 {
                let (u, v) = (taken(&faces[now], group), taken(&high, group));
                let [f, g] = forces(group, u, v, brick, taken(&waiting[now], group));
                put(&mut near, group, f);
                put(&mut waiting[next], group, g);
            }
            self.add::<L, PART>(&near, carried, first, at);
            (now, at) = (next, behind);
            materials += bricks.stride;
        }
        let carried = &mut carried[lines.len()];
        self.add::<L, PART>(&waiting[now], carried, first, at);
    }

    /// Asks for the nodes of a register on one line of both vectors, and for the materials of its elements.
    #[inline(always)]
    fn ask(&self, nodes: usize, materials: usize) {
        let cache_line = CACHE_LINE / size_of::<R>();
        for i in 0..4 {
            prefetch(self.x, nodes + i * cache_line);
            self.y.prefetch(nodes + i * cache_line);
        }
        prefetch(&self.bricks.lambda, materials);
        prefetch(&self.bricks.shear, materials);
    }

    /// Modes along x and z of the elements from `first` on the node lines whose first of these nodes are at `at`.
    #[inline(always)]
    fn read<L: Lanes<R>, const PART: u8>(&self, first: usize, [low, high]: [usize; 2]) -> Face<L> {
        if PART != PADDED {
            let len = 3 * L::WIDTH + 3;
            return line::read(&self.x[low..low + len], &self.x[high..high + len]);
        }
        let len = 3 * (self.bricks.cells[0] + 1 - first);
        let mut padded = [[R::zero(); 3 * MAX_WIDTH + 3]; 2];
        padded[0][..len].copy_from_slice(&self.x[low..low + len]);
        padded[1][..len].copy_from_slice(&self.x[high..high + len]);
        line::read(&padded[0], &padded[1])
    }

    /// `y += α F` on the same nodes.
    #[inline(always)]
    fn add<L: Lanes<R>, const PART: u8>(
        &self,
        face: &Face<L>,
        carried: &mut Carried<L>,
        first: usize,
        [low, high]: [usize; 2],
    ) {
        let len = if PART != PADDED {
            3 * L::WIDTH
        } else {
            3 * (self.bricks.cells[0] + 1 - first)
        };
        if PART != PADDED {
            // SAFETY: both lines are nodes of the grid that belong to this task, and they are different.
            let (low, high) = unsafe {
                (
                    self.y.part_unchecked(low, len),
                    self.y.part_unchecked(high, len),
                )
            };
            return line::add(face, carried, self.alpha, low, high);
        }
        // SAFETY: both lines belong to this task and are different.
        let (low, high) = unsafe { (self.y.part(low, len), self.y.part(high, len)) };
        let mut padded = [[R::zero(); 3 * MAX_WIDTH]; 2];
        padded[0][..len].copy_from_slice(low);
        padded[1][..len].copy_from_slice(high);
        let [a, b] = &mut padded;
        line::add(face, carried, self.alpha, a, b);
        low.copy_from_slice(&padded[0][..len]);
        high.copy_from_slice(&padded[1][..len]);
    }

    /// `y += α F` at the nodes i of all lines, behind the last lanes of registers.
    #[inline(always)]
    fn nodes_behind<L: Lanes<R>>(&self, i: usize, k: usize, carried: &[Carried<L>]) {
        let lines = self.task.lines[0].clone();
        for (j, carried) in (lines.start..=lines.end).zip(carried) {
            let (low, high) = (self.place(i, j, k), self.place(i, j, k + 1));
            // SAFETY: both nodes belong to this task and are different.
            let (low, high) = unsafe { (self.y.part(low, 3), self.y.part(high, 3)) };
            for c in 0..3 {
                let (sum, difference) = (line::last(carried[c][0]), line::last(carried[c][1]));
                low[c] += self.alpha * (sum - difference);
                high[c] += self.alpha * (sum + difference);
            }
        }
    }

    /// Up to `WIDTH` elements anywhere, by their node numbers.
    #[inline(always)]
    fn split<L: Lanes<R>>(&self, elements: &[SplitElement<R>]) {
        let mut lanes = [[[R::zero(); MAX_WIDTH]; 8]; 3];
        let mut brick = [[R::zero(); MAX_WIDTH]; 5];
        for (l, element) in elements.iter().enumerate() {
            for (m, node) in element.nodes.iter().enumerate() {
                for c in 0..3 {
                    lanes[c][m][l] = self.x[3 * *node as usize + c];
                }
            }
            let Brick {
                inverse,
                lambda,
                shear,
            } = element.brick;
            for (value, lanes) in inverse.into_iter().chain([lambda, shear]).zip(&mut brick) {
                lanes[l] = value;
            }
        }
        let [r, s, t, lambda, shear] = &brick;
        let brick = Brick {
            inverse: [L::load(r), L::load(s), L::load(t)],
            lambda: L::load(lambda),
            shear: L::load(shear),
        };
        let zero = L::splat(R::zero());
        let mut corners = [[[zero; 4]; 3]; 2];
        for c in 0..3 {
            for m in 0..8 {
                corners[m / 2 % 2][c][m % 2 + m / 4 * 2] = L::load(&lanes[c][m]);
            }
        }
        let (low, high) = (to_face(&corners[0]), to_face(&corners[1]));
        let [near, far] = all_forces(&low, &high, brick);
        let force = [to_corners(&near), to_corners(&far)];
        for c in 0..3 {
            for m in 0..8 {
                force[m / 2 % 2][c][m % 2 + m / 4 * 2].store(&mut lanes[c][m]);
            }
        }
        for (l, element) in elements.iter().enumerate() {
            for (m, node) in element.nodes.iter().enumerate() {
                // SAFETY: the node belongs to this task.
                let y = unsafe { self.y.part(3 * *node as usize, 3) };
                for c in 0..3 {
                    y[c] += self.alpha * lanes[c][m][l];
                }
            }
        }
    }
}
