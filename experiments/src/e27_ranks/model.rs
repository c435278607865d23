//! What an iteration takes on P ranks: work, and messages that take α and β per byte.
//!
//! ```text
//! t(N, P) = w N/P + 2 e(N) + Σ_l s e(N_l) + 3 σ ⌈log₂ P⌉
//! e(N)    = k α + 24 β γ g(N/3P)                  an exchange of ghosts, 24 bytes each, with k neighbours
//! g(n)    = (n^(1/3) + 2)³ − n                    those of a cube of n nodes
//! N_l     = N / c^l,  on min(P, N_l/50) ranks    levels of multigrid
//! ```
//!
//! w, α, β, σ and γ are measured in the same run; everything else is counted. No message hides behind work, and no two wait for each
//! other's wire: real networks are better in the one and worse in the other.

use super::division::shell;

/// Exchanges in a product with 𝒜: displacements for A and Bᵀ, tractions for B.
const OF_PRODUCT: f64 = 2.0;

/// Exchanges of a level of a V-cycle: two steps of Chebyshev's method before and after, a residual, restriction, prolongation.
const OF_LEVEL: f64 = 7.0;

/// Sums over all ranks in an iteration of GMRES: components, their correction, the norm.
const SUMS: f64 = 3.0;

/// Rows of a level over those of the next: aggregates of 3³ nodes with three rows each, six modes left of each. Unit: 1.
const COARSENING: f64 = 27.0 * 3.0 / 6.0;

/// Rows per rank below which PETSc takes fewer ranks, `-pc_gamg_process_eq_limit`.
const ROWS_PER_RANK: f64 = 50.0;

/// Neighbours of a part in the middle of a body: the other places of 3³.
const NEIGHBOURS: f64 = 26.0;

/// Bytes of a node's displacements.
const BYTES: f64 = 24.0;

/// What messages take.
#[derive(Clone, Copy, Debug)]
pub(super) struct Wire {
    /// α: a message of one number [s].
    pub(super) message: f64,
    /// β: what a byte adds [s].
    pub(super) per_byte: f64,
    /// σ: a stage of a sum over all ranks [s].
    pub(super) stage: f64,
}

/// A network of clusters: 2 µs from process to process and 10 GB/s, round numbers for InfiniBand with 100 Gb/s; a stage of a sum is a message there
/// and one back. Assumed, not measured.
pub(super) const NETWORK: Wire = Wire {
    message: 2e-6,
    per_byte: 1e-10,
    stage: 4e-6,
};

/// An iteration of one system after the other.
#[derive(Clone, Copy, Debug)]
pub(super) struct Model {
    /// w: work per displacement [s].
    pub(super) work: f64,
    /// γ of a [division](super::division::Division::over_cube). Unit: 1.
    pub(super) surface: f64,
    pub(super) wire: Wire,
}

impl Model {
    /// An iteration on so many displacements [s].
    pub(super) fn iteration(&self, n_u: f64, ranks: f64) -> f64 {
        self.on_cores(n_u, ranks, ranks)
    }

    /// The same where ranks share cores.
    pub(super) fn on_cores(&self, n_u: f64, ranks: f64, cores: f64) -> f64 {
        let mut messages = OF_PRODUCT * self.exchange(n_u, ranks);
        let mut rows = n_u;
        loop {
            let active = ranks.min(rows / ROWS_PER_RANK);
            if active <= 1.0 {
                break;
            }
            messages += OF_LEVEL * self.exchange(rows, active);
            rows /= COARSENING;
        }
        messages += SUMS * self.wire.stage * ranks.log2().ceil();
        self.work * n_u / ranks.min(cores) + messages
    }

    /// Ghosts of all ranks at once [s].
    fn exchange(&self, rows: f64, ranks: f64) -> f64 {
        if ranks <= 1.0 {
            return 0.0;
        }
        let share = rows / 3.0 / ranks;
        let neighbours = NEIGHBOURS.min(ranks - 1.0);
        neighbours * self.wire.message + BYTES * self.wire.per_byte * self.surface * shell(share)
    }

    /// Share of `ranks` that works, as n_u grows with them. Unit: 1.
    pub(super) fn weak(&self, per_rank: f64, ranks: f64) -> f64 {
        self.iteration(per_rank, 1.0) / self.iteration(per_rank * ranks, ranks)
    }

    /// How much faster than one rank, of the same n_u. Unit: 1.
    pub(super) fn strong(&self, n_u: f64, ranks: f64) -> f64 {
        self.iteration(n_u, 1.0) / self.iteration(n_u, ranks)
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    const MODEL: Model = Model {
        work: 1e-6,
        surface: 1.5,
        wire: NETWORK,
    };

    #[test]
    fn without_messages_every_rank_counts() {
        let free = Wire {
            message: 0.0,
            per_byte: 0.0,
            stage: 0.0,
        };
        let model = Model {
            wire: free,
            ..MODEL
        };
        for ranks in [1.0, 2.0, 64.0, 4096.0] {
            assert!((model.strong(7e7, ranks) / ranks - 1.0).abs() < 1e-12);
            assert!((model.weak(1e5, ranks) - 1.0).abs() < 1e-12);
        }
    }

    /// One exchange by hand: two ranks, one neighbour, the surface of half of the nodes.
    #[test]
    fn two_ranks_send_one_message_per_exchange() {
        let rows = 60.0;
        // one level on min(2, 60/50) ranks, none below
        let shell = |n: f64| (n.cbrt() + 2.0).powi(3) - n;
        let level = 0.2 * 2e-6 + 24.0 * 1e-10 * 1.5 * shell(20.0 / 1.2);
        let product = 2e-6 + 24.0 * 1e-10 * 1.5 * shell(10.0);
        let expected = 30e-6 + 2.0 * product + 7.0 * level + 3.0 * 4e-6;
        assert!((MODEL.iteration(rows, 2.0) / expected - 1.0).abs() < 1e-12);
    }

    #[test]
    fn more_ranks_gain_less_and_share_cores_without_gain() {
        let mut before = 1.0;
        for k in 1..13 {
            let ranks = f64::from(1 << k);
            let share = MODEL.strong(7e7, ranks) / ranks;
            assert!(share < before, "{ranks}: {share}");
            before = share;
        }
        assert!(MODEL.on_cores(1e6, 4.0, 2.0) > MODEL.iteration(1e6, 2.0));
    }
}
