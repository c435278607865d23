//! `fracas solve`: what is known of a solve, in lines for people.

use super::{explain, output};
use crate::report::format_real;
use crate::sentence::with_flags;
use fracas::solve::{End, Solved};
use std::io::Write;

fn outcome(end: End) -> &'static str {
    match end {
        End::Converged => "converged",
        End::IterationLimit => "iteration_limit",
        End::Stopped => "stopped",
        End::Breakdown => "breakdown",
    }
}

/// The method and its parts.
fn parts(solved: &Solved) -> String {
    let mut parts = solved.method.clone();
    if let Some(c) = &solved.augmentation {
        parts += &format!(", C = {c}");
    }
    if solved.relaxation > 0.0 {
        parts += &format!(", γ = {}", format_real(solved.relaxation));
    }
    if solved.relaxation_degree > 1 {
        parts += &format!(", degree {}", solved.relaxation_degree);
    }
    if let Some(inner) = &solved.inner {
        parts += &format!(", inner {inner}");
    }
    parts
}

/// Two columns, aligned.
pub(super) fn print(solved: &Solved, out: &mut dyn Write) -> anyhow::Result<()> {
    const NONE: &str = "–";
    let small = |v: Option<f64>| v.map_or_else(|| NONE.to_owned(), |v| format!("{v:.3e}"));
    let c_s = solved.c_s;
    let mut rows = vec![
        ("outcome", outcome(solved.outcome).to_owned()),
        ("method", parts(solved)),
        ("krylov", solved.krylov.to_string()),
        ("n_it", solved.iterations.to_string()),
        ("relative residual", small(solved.relative_residual)),
        ("error of u", small(solved.error_u)),
        ("error of t", small(solved.error_t)),
    ];
    if solved.n_p > 0 {
        rows.push(("error of p", small(solved.error_p)));
    }
    rows.extend([
        ("backward error", small(solved.backward_error)),
        ("contact residual", small(solved.contact_residual)),
        ("c_app", format!("{:.2}", solved.c_app)),
        (
            "C_s",
            c_s.map_or_else(|| NONE.to_owned(), |v| format!("{v:.2}")),
        ),
        ("set-up", format!("{:.2} s", solved.setup_s)),
        ("solve", format!("{:.2} s", solved.solve_s)),
    ]);
    if let Some(amg) = &solved.amg {
        rows.push(("multigrid", amg.smoothing.to_string()));
    }
    if let Some(bytes) = solved.peak_memory_bytes {
        rows.push((
            "peak memory",
            format!("{:.0} MiB", bytes as f64 / f64::from(1 << 20)),
        ));
    }
    rows.extend(solved.findings.iter().map(|f| ("note", f.to_string())));
    if let Some(reason) = &solved.reason {
        rows.push(("reason", reason.clone()));
    }
    if let Some(facts) = &solved.explain {
        rows.extend(explain::rows(facts));
    }
    let shown = |(name, text): (_, String)| (name, with_flags(&text));
    output::pairs(out, &rows.into_iter().map(shown).collect::<Vec<_>>())
}
