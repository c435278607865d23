//! Pressures beside displacements and tractions.

use crate::samples::sparse;
use fracas_solvers::saddle::{FlowBlocks, SaddleBlocks};

/// What flow is like beside a system with three tractions a face.
#[derive(Clone, Copy, Debug)]
pub(crate) struct Flow {
    /// Share of open faces.
    pub(crate) open: f64,
    /// Size of T.
    pub(crate) size: f64,
    /// Storage, relative to T.
    pub(crate) storage: f64,
    /// Derivative of the conductivity, relative to `1/Δt`: the part of Q2 that is no transpose of Q1.
    pub(crate) derivative: f64,
    /// 1/Δt.
    pub(crate) rate: f64,
}

/// The same system with a pressure per face: `Q1 = −B_n`; on open faces `Q2 = B_nᵀ/Δt` and derivatives, and the contact law t = 0; T a
/// graph of neighbours in a row with conductivities over four magnitudes.
pub(crate) fn with_flow(stick: SaddleBlocks, flow: Flow, seed: u64) -> SaddleBlocks {
    let (n_u, n_p) = (stick.n_u(), stick.n_t() / 3);
    let number = |k: u64| fracas_operators::random::signed(seed * 7919 + k);
    let open: Vec<bool> = (0..n_p)
        .map(|f| 0.5 * (1.0 + number(f as u64)) < flow.open)
        .collect();
    let b_n = |row: usize, f: usize| stick.b1.get(row, 3 * f).copied().unwrap_or(0.0);
    let q1 = sparse(n_u, n_p, |row, f| -b_n(row, f));
    let q2 = sparse(n_p, n_u, |f, row| {
        let near = (f.saturating_sub(1)..n_p.min(f + 2)).filter(|&g| open[g]);
        let derivative = |g: usize| {
            let sign = if f == g { 1.0 } else { -0.5 };
            flow.derivative * sign * number((1000 + f * n_p + g) as u64) * b_n(row, g)
        };
        let own = if open[f] { b_n(row, f) } else { 0.0 };
        flow.rate * (own + near.map(derivative).sum::<f64>())
    });
    let conductivity = |f: usize| flow.size * 10f64.powf(2.0 * number((500 + f) as u64));
    let t = sparse(n_p, n_p, |f, g| match f.abs_diff(g) {
        0 => {
            let before = if f > 0 { conductivity(f - 1) } else { 0.0 };
            let behind = if f + 1 < n_p { conductivity(f) } else { 0.0 };
            before + behind + flow.storage * flow.size
        }
        1 => -conductivity(f.min(g)),
        _ => 0.0,
    });
    let is_open = |k: usize| open[k / 3];
    let h = |k: usize, l: usize| match is_open(k) || is_open(l) {
        true => f64::from(u8::from(k == l)),
        false => stick
            .h
            .as_ref()
            .and_then(|h| h.get(k, l))
            .map_or(0.0, |h| *h),
    };
    let b2 = sparse(stick.n_t(), n_u, |k, row| match is_open(k) {
        true => 0.0,
        false => stick.b1.get(row, k).copied().unwrap_or(0.0),
    });
    let h = sparse(stick.n_t(), stick.n_t(), h);
    SaddleBlocks {
        b2: open.contains(&true).then_some(b2),
        h: (h.nnz() > 0).then_some(h),
        flow: Some(FlowBlocks {
            q1,
            q2,
            t,
            rhs_p: vec![0.0; n_p],
        }),
        ..stick
    }
}
