//! The diagonal of A, as far as norms and precisions need it.

use super::SaddleBlocks;

/// Spread of the diagonal of A that is too much for f32: 2²⁰ of its 2²⁴. Unit: 1.
const SINGLE: f64 = 1_048_576.0;

/// Stands for an entry of 0, which A does not hold at all.
const NONE: u8 = u8::MAX;

/// The diagonal of A to a factor of two, in a byte per entry.
#[derive(Clone, Debug, PartialEq)]
pub struct Stiffness {
    largest: f64,
    /// Times that the largest entry is halved, or [`NONE`].
    halvings: Vec<u8>,
    /// Most of them.
    softest: u8,
}

impl Stiffness {
    /// Of positive entries, none of them above `largest`. An entry of 0, and one below 2⁻²⁵⁴ of that, counts as the least of the others: what B alone
    /// holds has no stiffness to be judged by.
    pub fn new(largest: f64, entries: impl Iterator<Item = f64>) -> Self {
        // a quotient of infinity saturates
        let halvings: Vec<u8> = (entries.map(|a| (largest / a).log2().round() as u8)).collect();
        let held = halvings.iter().copied().filter(|h| *h != NONE);
        Self {
            largest,
            softest: held.max().unwrap_or(NONE),
            halvings,
        }
    }

    /// n_u.
    pub fn len(&self) -> usize {
        self.halvings.len()
    }

    /// True for none.
    pub fn is_empty(&self) -> bool {
        self.halvings.is_empty()
    }

    /// Largest over smallest entry, to a factor of √2; 2²⁵⁵ where an entry is 0.
    pub fn spread(&self) -> f64 {
        f64::from(self.halvings.iter().copied().max().unwrap_or(0)).exp2()
    }

    /// True where f32 may hold no digit of the softest rock beside the stiffest: tractions within soft rock were wrong by 3e-4 with
    /// errors of 5e-10 said.
    pub fn exceeds_single(&self) -> bool {
        self.spread() >= SINGLE
    }

    /// Diagonal entries, each to a factor of √2.
    pub fn entries(&self) -> impl Iterator<Item = f64> {
        let entry = |halvings: &u8| {
            let halvings = match *halvings {
                NONE => self.softest,
                halvings => halvings,
            };
            self.largest * (-f64::from(halvings)).exp2()
        };
        self.halvings.iter().map(entry)
    }
}

impl SaddleBlocks {
    /// The size of the diagonal of A.
    pub fn stiffness(&self) -> Stiffness {
        let entry = |i| self.a.get(i, i).map_or(0.0, |a| a.abs());
        let entries = (0..self.n_u()).map(entry);
        Stiffness::new(entries.clone().fold(0.0, f64::max), entries)
    }
}
