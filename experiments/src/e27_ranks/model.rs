//! What an iteration takes on P ranks: work, and messages that take α and β per byte.
//!
//! ```text
//! t(N, P)    = w N/P + 4 e(N/3, 24, P) + Σ_l 7 e(N_l/6, 48, P_l) + 3 σ ⌈log₂ P⌉
//! e(n, b, P) = k α + b β γ g(n/P)     an exchange of ghosts of n nodes, b bytes each, with k = min(26, P − 1) neighbours
//! g(n)       = (n^(1/3) + 2)³ − n     those of a cube of n nodes
//! N_l        = N / 13.5^l             rows of a level of multigrid, on P_l = min(P, N_l/50) ranks
//! ```
//!
//! w, α, β, σ and γ are measured in the same run. 4, 7 and 3 are counted in the code and in PETSc's cycle; 26 neighbours and 13.5 are those of a body in
//! space with aggregates of 3³ nodes.
//!
//! Work is taken as perfectly divided: no rank waits for another one, has more nodes, or shares the memory's speed with its neighbour. Every rank
//! has a wire of its own, no message hides behind work, and n_it does not grow.

use super::division::shell;

/// Exchanges of an iteration outside of multigrid: of displacements and of tractions, in the product with 𝒜 and around S_u⁻¹ in M⁻¹.
const OUTSIDE: f64 = 4.0;

/// Exchanges of a level of a V-cycle: two steps of Chebyshev's method before and after, a residual, restriction, prolongation.
const OF_LEVEL: f64 = 7.0;

/// Sums over all ranks in an iteration of GMRES: components, their correction, the norm.
const SUMS: f64 = 3.0;

/// Rows of a node of the body, and of an aggregate: six rigid-body modes.
const ROWS: [f64; 2] = [3.0, 6.0];

/// Rows of a level over those of the next: aggregates of 3³ nodes. Unit: 1.
const COARSENING: f64 = 27.0 * ROWS[0] / ROWS[1];

/// Rows per rank below which PETSc takes fewer ranks: its `-pc_gamg_process_eq_limit`.
const ROWS_PER_RANK: f64 = 50.0;

/// Neighbours of a part in the middle of a body: the other places of 3³.
const NEIGHBOURS: f64 = 26.0;

/// Bytes of a number.
const BYTES: f64 = 8.0;

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
        let mut messages = OUTSIDE * self.exchange(n_u, ROWS[0], ranks);
        let (mut rows, mut per_node) = (n_u, ROWS[0]);
        loop {
            let active = ranks.min((rows / ROWS_PER_RANK).floor());
            if active < 2.0 {
                break;
            }
            messages += OF_LEVEL * self.exchange(rows, per_node, active);
            (rows, per_node) = (rows / COARSENING, ROWS[1]);
        }
        messages += SUMS * self.wire.stage * ranks.log2().ceil();
        self.work * n_u / ranks.min(cores) + messages
    }

    /// Ghosts of all ranks at once [s].
    fn exchange(&self, rows: f64, per_node: f64, ranks: f64) -> f64 {
        if ranks < 2.0 {
            return 0.0;
        }
        let ghosts = self.surface * shell(rows / per_node / ranks);
        NEIGHBOURS.min(ranks - 1.0) * self.wire.message
            + BYTES * per_node * ghosts * self.wire.per_byte
    }

    /// Time of one rank over that of `ranks` with as many displacements each. Unit: 1.
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

    /// By hand: two ranks, one neighbour, two levels with the shells of half of their nodes, the second on as many ranks as have 50 rows.
    #[test]
    fn two_ranks_send_one_message_per_exchange() {
        let (rows, next): (f64, f64) = (1620.0, 120.0);
        let shell = |n: f64| (n.cbrt() + 2.0).powi(3) - n;
        let exchange = |bytes: f64, nodes: f64| 2e-6 + bytes * 1e-10 * 1.5 * shell(nodes / 2.0);
        let (fine, coarse) = (exchange(24.0, rows / 3.0), exchange(48.0, next / 6.0));
        let expected = 1e-6 * rows / 2.0 + (4.0 + 7.0) * fine + 7.0 * coarse + 3.0 * 4e-6;
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
        let shared = MODEL.on_cores(1e6, 4.0, 2.0);
        assert!(shared > MODEL.iteration(1e6, 4.0) && shared > MODEL.work * 1e6 / 2.0);
    }
}
