//! One task of a product with general hexahedra: a pipeline of groups of elements.
//!
//! While the Gauss points of one group keep the multipliers busy, the additions, loads and stores of its neighbours fill
//! the rest of the machine: the displacements of the next group become derivatives and the forces of the last one reach
//! their nodes. All that a group leaves for later lies in memory, in one of two stages chosen by its parity.
#![allow(unsafe_code, reason = "writes of tasks that share no entry")]

use super::brick::{Face, to_corners, to_face};
use super::gauss::{Derivatives, VARYING, derivatives, modes_of_derivatives, point, weight};
use super::groups::Nodes;
use super::hexes::{Hexes, NUMBERS};
use super::line;
use super::modes::{across, to_both};
use fracas_operators::Real;
use fracas_operators::shared::Shared;
use fracas_operators::simd::{CACHE_LINE, Kernel, Lanes, MAX_WIDTH, prefetch};

/// Groups for which memory is asked ahead of the group that is read.
const AHEAD: usize = 2;

/// One task of one product: a range of groups.
pub(super) struct Product<'a, R> {
    pub(super) hexes: &'a Hexes<R>,
    pub(super) alpha: R,
    pub(super) x: &'a [R],
    pub(super) y: &'a Shared<'a, R>,
    pub(super) task: std::ops::Range<usize>,
}

/// A group between its nodes and its Gauss points.
struct Stage<L> {
    shape: [Derivatives<L>; 3],
    gradient: [Derivatives<L>; 3],
    force: [Derivatives<L>; 3],
    /// λ/G and G/64.
    moduli: [L; 2],
    /// Displacements of the faces at low and high y, later their forces.
    faces: [Face<L>; 2],
}

/// Scalars of a padded node line.
const LINE: usize = 4 * MAX_WIDTH;
const _: () = assert!(LINE >= 3 * (MAX_WIDTH + 1));

/// Values at the nodes of a group that is not on whole node lines.
#[repr(align(64))]
struct Buffers<R> {
    /// Of any elements: `[component][lexicographic corner][element]`; no register straddles two cache lines.
    corners: [[[R; MAX_WIDTH]; 8]; 3],
    /// Of lines shorter than a register, padded: `[along y][along z]`.
    lines: [[[R; LINE]; 2]; 2],
}

impl<R: Real> Kernel<R> for Product<'_, R> {
    #[inline(always)]
    fn run<L: Lanes<R>>(self) {
        let zero = L::splat(R::zero());
        let empty = || Buffers {
            corners: [[[R::zero(); MAX_WIDTH]; 8]; 3],
            lines: [[[R::zero(); LINE]; 2]; 2],
        };
        let (mut gathered, mut scattered) = (empty(), empty());
        let nothing = [[[zero; 4]; 3]; 3];
        let mut even = Stage {
            shape: nothing,
            gradient: nothing,
            force: nothing,
            moduli: [zero; 2],
            faces: [[[[zero; 2]; 2]; 3]; 2],
        };
        let mut odd = Stage { ..even };
        // Swapped in every step, so that each is one address and not a choice between two.
        let (mut now, mut other) = (&mut even, &mut odd);
        let groups = self.task.len();
        for step in 0..groups + 2 {
            let coming = self.task.start + step;
            let comes = step < groups;
            let here = 0 < step && step <= groups;
            let goes = 1 < step;
            let going = if goes { coming - 2 } else { coming };
            if here {
                now.point::<R, 0>();
            }
            if goes {
                other.leave(0);
            }
            if comes {
                self.gather::<L>(coming, &mut gathered);
                self.ask::<L>(coming + AHEAD);
            }
            if here {
                now.point::<R, 1>();
            }
            if goes {
                other.leave(1);
            }
            if here {
                now.point::<R, 2>();
            }
            if goes {
                other.leave(2);
            }
            if here {
                now.point::<R, 3>();
            }
            if goes {
                self.add(going, 0, &other.faces[0], &mut scattered);
            }
            if comes {
                self.shape(coming, 0, &mut *other);
            }
            if here {
                now.point::<R, 4>();
            }
            if goes {
                self.add(going, 1, &other.faces[1], &mut scattered);
            }
            if comes {
                self.shape(coming, 1, &mut *other);
            }
            if here {
                now.point::<R, 5>();
            }
            if comes {
                other.faces[0] = self.read(coming, 0, &gathered);
                self.shape(coming, 2, &mut *other);
            }
            if here {
                now.point::<R, 6>();
            }
            if comes {
                other.faces[1] = self.read(coming, 1, &gathered);
                other.enter(0);
            }
            if here {
                now.point::<R, 7>();
            }
            if comes {
                other.enter(1);
                other.enter(2);
            }
            std::mem::swap(&mut now, &mut other);
        }
    }
}

impl<L: Copy> Stage<L> {
    /// Forces of Gauss point Q.
    #[inline(always)]
    fn point<R: Real, const Q: usize>(&mut self)
    where
        L: Lanes<R>,
    {
        let [ratio, shear] = self.moduli;
        point::<R, L, Q>(&self.shape, &self.gradient, ratio, shear, &mut self.force);
    }

    /// Derivatives of component c of the displacement.
    #[inline(always)]
    fn enter<R: Real>(&mut self, c: usize)
    where
        L: Lanes<R>,
    {
        let mut modes = across(&self.faces, c);
        for m in [3, 5, 6, 7] {
            modes[m] = modes[m] * L::splat(R::of(weight(m)));
        }
        self.gradient[c] = derivatives(&modes);
    }

    /// Forces on both faces, component c.
    #[inline(always)]
    fn leave<R: Real>(&mut self, c: usize)
    where
        L: Lanes<R>,
    {
        let mut modes = modes_of_derivatives(&self.force[c]);
        for m in [3, 5, 6, 7] {
            modes[m] = modes[m] * L::splat(R::of(weight(m)));
        }
        to_both(&modes, &mut self.faces, c);
    }
}

impl<R: Real> Product<'_, R> {
    /// Derivatives of component c of the position; with the first come the moduli.
    #[inline(always)]
    fn shape<L: Lanes<R>>(&self, group: usize, c: usize, stage: &mut Stage<L>) {
        let size = NUMBERS * L::WIDTH;
        let numbers = &self.hexes.numbers[size * group..][..size];
        let mut modes = [L::splat(R::zero()); 8];
        for m in 1..8 {
            let place = (VARYING * c + m - 1) * L::WIDTH;
            modes[m] = L::load(&numbers[place..]);
            prefetch(numbers, AHEAD * size + place);
        }
        stage.shape[c] = derivatives(&modes);
        if c == 0 {
            for i in 0..2 {
                let place = (3 * VARYING + i) * L::WIDTH;
                stage.moduli[i] = L::load(&numbers[place..]);
                prefetch(numbers, AHEAD * size + place);
            }
        }
    }

    /// Asks for the node lines of a group that will come.
    #[inline(always)]
    fn ask<L: Lanes<R>>(&self, group: usize) {
        let (lines, elements) = match self.hexes.groups.get(group) {
            Some(Nodes::Lines(lines)) => (lines, L::WIDTH),
            Some(Nodes::Short(lines, elements)) => (lines, usize::from(*elements)),
            _ => return,
        };
        let cache_line = CACHE_LINE / size_of::<R>();
        for first in lines.as_flattened() {
            let mut at = 3 * *first as usize;
            let end = at + 3 * elements;
            while at < end {
                prefetch(self.x, at);
                self.y.prefetch(at);
                at += cache_line;
            }
        }
    }

    /// Modes of the displacements on the face at low or high y.
    #[inline(always)]
    fn read<L: Lanes<R>>(&self, group: usize, y: usize, gathered: &Buffers<R>) -> Face<L> {
        match self.hexes.groups[group] {
            Nodes::Lines(lines) => {
                let [low, high] = lines[y];
                line::read(&self.x[3 * low as usize..], &self.x[3 * high as usize..])
            }
            Nodes::Short(..) => {
                let [low, high] = &gathered.lines[y];
                line::read(low, high)
            }
            Nodes::Any(_) => {
                let mut corners = [[L::splat(R::zero()); 4]; 3];
                for c in 0..3 {
                    for m in 0..4 {
                        corners[c][m] = L::load(&gathered.corners[c][corner(m, y)]);
                    }
                }
                to_face(&corners)
            }
        }
    }

    /// Displacements of a group that does not fill its node lines, or is on none, well ahead of `read`: by then the scalars have
    /// left the store queue.
    #[inline(always)]
    fn gather<L: Lanes<R>>(&self, group: usize, gathered: &mut Buffers<R>) {
        match self.hexes.groups[group] {
            Nodes::Lines(_) => {}
            Nodes::Short(lines, elements) => {
                let len = 3 * (usize::from(elements) + 1);
                for (padded, first) in gathered
                    .lines
                    .as_flattened_mut()
                    .iter_mut()
                    .zip(lines.as_flattened())
                {
                    padded[..len].copy_from_slice(&self.x[3 * *first as usize..][..len]);
                    // what an earlier group left may not be finite
                    padded[len..3 * (L::WIDTH + 1)].fill(R::zero());
                }
            }
            Nodes::Any(first) => {
                for (lane, nodes) in self.hexes.elements[first..][..L::WIDTH].iter().enumerate() {
                    for (m, node) in nodes.iter().enumerate() {
                        let x = &self.x[3 * *node as usize..][..3];
                        for c in 0..3 {
                            gathered.corners[c][m][lane] = x[c];
                        }
                    }
                }
            }
        }
    }

    /// `y += α F` on the face at low or high y.
    #[inline(always)]
    fn add<L: Lanes<R>>(&self, group: usize, y: usize, face: &Face<L>, scattered: &mut Buffers<R>) {
        match self.hexes.groups[group] {
            Nodes::Lines(lines) => {
                let [low, high] = lines[y];
                let len = 3 * (L::WIDTH + 1);
                // SAFETY: both lines belong to this task and do not overlap (`groups::run`).
                let (low, high) = unsafe {
                    (
                        self.y.part(3 * low as usize, len),
                        self.y.part(3 * high as usize, len),
                    )
                };
                self.add_to_lines(face, low, high);
            }
            Nodes::Short(lines, elements) => {
                let len = 3 * (usize::from(elements) + 1);
                let [a, b] = &mut scattered.lines[y];
                // SAFETY: both lines belong to this task and do not overlap (`groups::run`).
                let (low, high) = unsafe {
                    (
                        self.y.part(3 * lines[y][0] as usize, len),
                        self.y.part(3 * lines[y][1] as usize, len),
                    )
                };
                a[..len].copy_from_slice(low);
                b[..len].copy_from_slice(high);
                self.add_to_lines(face, a, b);
                low.copy_from_slice(&a[..len]);
                high.copy_from_slice(&b[..len]);
            }
            Nodes::Any(first) => {
                let corners = to_corners(face);
                let alpha = L::splat(self.alpha);
                for c in 0..3 {
                    for m in 0..4 {
                        (alpha * corners[c][m]).store(&mut scattered.corners[c][corner(m, y)]);
                    }
                }
                for (lane, nodes) in self.hexes.elements[first..][..L::WIDTH].iter().enumerate() {
                    for m in 0..4 {
                        let m = corner(m, y);
                        // SAFETY: the node belongs to this task.
                        let y = unsafe { self.y.part(3 * nodes[m] as usize, 3) };
                        for c in 0..3 {
                            y[c] += scattered.corners[c][m][lane];
                        }
                    }
                }
            }
        }
    }

    /// `y += α F` on the `WIDTH + 1` nodes of the low and the high line of a face.
    #[inline(always)]
    fn add_to_lines<L: Lanes<R>>(&self, face: &Face<L>, low: &mut [R], high: &mut [R]) {
        let mut carried = [[L::splat(R::zero()); 2]; 3];
        line::add(face, &mut carried, self.alpha, low, high);
        for c in 0..3 {
            let (sum, difference) = (line::last(carried[c][0]), line::last(carried[c][1]));
            low[3 * L::WIDTH + c] += self.alpha * (sum - difference);
            high[3 * L::WIDTH + c] += self.alpha * (sum + difference);
        }
    }
}

/// Corner m of the face at low or high y, among those of the element.
const fn corner(m: usize, y: usize) -> usize {
    m % 2 + 2 * y + m / 2 * 4
}
