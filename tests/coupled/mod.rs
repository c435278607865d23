//! Systems of flow and mechanics on a meshed body, without the model of flow: Q1, Q2 and T by their formulas.

use fracas::contact::JumpStabilization;
use fracas::scene::{Body, named};
use fracas_operators::random::signed;
use fracas_operators::sparse::{SparseMatrix, Triplets};
use fracas_solvers::saddle::{FlowBlocks, SaddleBlocks};

/// What flow is like, in units of what the rock gives: `c = mean of diag(B_nᵀ diag(A)⁻¹ B_n)`, `1/Δt = 1`.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Flow {
    /// Share of open faces; 1 for all.
    pub(crate) open: f64,
    /// Conductivities, times c.
    pub(crate) size: f64,
    /// Magnitudes that conductivities spread over.
    pub(crate) spread: f64,
    /// Storage, times c, or times conductivities where these are larger: f64 has no room for less.
    pub(crate) storage: f64,
    /// Derivatives of the conductivity in Q2, relative to the change of volume.
    pub(crate) derivative: f64,
}

impl Default for Flow {
    fn default() -> Self {
        Self {
            open: 0.5,
            size: 1.0,
            spread: 2.0,
            storage: 1e-3,
            derivative: 0.0,
        }
    }
}

/// The body of a scene of the gallery.
pub(crate) fn body(scene: &str, overrides: &[&str]) -> Body {
    let scene = named(scene).unwrap().scene().unwrap();
    scene.with_overrides(overrides).unwrap().build().unwrap()
}

/// `Q1 = −B_n`; on open faces `Q2 = B_nᵀ/Δt + derivatives`, no traction; T a two-point graph between faces that H couples, with storage,
/// and with the normal part of H where both are open, as pressures are stabilized. Tractions and pressures in their own unit.
pub(crate) fn coupled(body: &Body, flow: Flow, seed: u64) -> SaddleBlocks {
    let stick = body
        .saddle_blocks(Some(JumpStabilization::default()))
        .unwrap();
    let stiffness = stick.contact_compliance();
    let n_p = stick.n_t() / 3;
    let c = (0..n_p).map(|f| stiffness[3 * f]).sum::<f64>() / n_p as f64;
    let number = |k: usize| signed(seed.wrapping_mul(104_729).wrapping_add(k as u64));
    let open: Vec<bool> = (0..n_p)
        .map(|f| 0.5 * (1.0 + number(f)) < flow.open)
        .collect();
    let h = stick.h.as_ref().unwrap();
    let (mut q1, mut q2) = (
        Triplets::new((stick.n_u(), n_p)),
        Triplets::new((n_p, stick.n_u())),
    );
    let mut t = Triplets::new((n_p, n_p));
    let mut derivative = Triplets::new((n_p, n_p));
    for f in 0..n_p {
        t.add_triplet(f, f, flow.storage * c * flow.size.max(1.0));
        if open[f] {
            derivative.add_triplet(f, f, 1.0);
        }
    }
    for (value, (row, column)) in h {
        let (row, column) = (row as usize, column as usize);
        let (f, g) = (row / 3, column / 3);
        if f >= g || row % 3 != 0 || column % 3 != 0 {
            continue;
        }
        let k = flow.size * c * 10f64.powf(0.5 * flow.spread * number(n_p + f + g * n_p));
        let stabilization = if open[f] && open[g] { -value } else { 0.0 };
        for (i, j) in [(f, g), (g, f)] {
            t.add_triplet(i, i, k + stabilization);
            t.add_triplet(i, j, -k - stabilization);
            // d(k (p_i − p_j))/dg, which has the sign of the drop of pressure
            let slope = flow.derivative * number(3 * n_p + f + g * n_p);
            let slope = if i == f { slope } else { -slope };
            for side in [f, g] {
                if open[side] {
                    derivative.add_triplet(i, side, slope);
                }
            }
        }
    }
    let derivative: SparseMatrix<f64> = derivative.to_csr();
    for (value, (row, column)) in &stick.b1 {
        if column.is_multiple_of(3) {
            q1.add_triplet(row as usize, column as usize / 3, -value);
        }
    }
    let q1: SparseMatrix<f64> = q1.to_csr();
    let b_n: SparseMatrix<f64> = q1.transpose_view().to_csr();
    for (value, (i, j)) in &(&derivative * &b_n) {
        q2.add_triplet(i as usize, j as usize, -value);
    }
    let (mut b2, mut laws) = (
        Triplets::new((stick.n_t(), stick.n_u())),
        Triplets::new((stick.n_t(), stick.n_t())),
    );
    for (value, (row, column)) in &stick.b1 {
        if !open[column as usize / 3] {
            b2.add_triplet(column as usize, row as usize, *value);
        }
    }
    for k in 0..stick.n_t() {
        match open[k / 3] {
            true => laws.add_triplet(k, k, c),
            false => {
                let row = h.outer_view(k).unwrap();
                for (l, value) in row.iter().filter(|(l, _)| !open[l / 3]) {
                    laws.add_triplet(k, l, *value);
                }
            }
        }
    }
    SaddleBlocks {
        b2: open.contains(&true).then(|| b2.to_csr()),
        h: Some(laws.to_csr()),
        flow: Some(FlowBlocks {
            q1,
            q2: q2.to_csr(),
            t: t.to_csr(),
            rhs_p: vec![0.0; n_p],
        }),
        ..stick
    }
}

/// The same in units in which every row counts.
pub(crate) fn balanced(blocks: SaddleBlocks) -> SaddleBlocks {
    let unit = blocks.traction_unit();
    blocks.into_traction_unit(unit)
}
