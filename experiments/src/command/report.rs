//! `fracas solve`: what is known of a solve, in lines for people.

use super::{explain, output};
use crate::sentence::with_flags;
use fracas::solve::{End, OverRanks, Solved, Times};
use fracas_figures::format_real;
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

/// Ranks, and the displacements of the fullest and the emptiest one.
fn over_ranks(engine: &OverRanks) -> String {
    let [least, most] = [engine.n_u.iter().min(), engine.n_u.iter().max()];
    let [least, most] = [least, most].map(|n| n.copied().unwrap_or(0));
    let ghosts = engine.ghosts.iter().max().copied().unwrap_or(0);
    format!(
        "{}, {} ranks with {least} to {most} displacements each and up to {ghosts} of others; mesh and partition {:.2} s, assembly {:.2} s",
        engine.name, engine.ranks, engine.partition_s, engine.assembly_s
    )
}

/// Of a product, M⁻¹, a sum and a message.
fn times_of(times: &Times) -> String {
    let [product, application] = [times.product_s, times.application_s].map(|s| 1e3 * s);
    let [sum, message] = [times.sum_s, times.message_s].map(|s| 1e6 * s);
    format!(
        "product {product:.2} ms, M⁻¹ {application:.2} ms, sum over ranks {sum:.1} µs, message {message:.1} µs and {:.3} ns a byte",
        1e9 * times.per_byte_s
    )
}

/// MiB of every rank.
fn memory_of(ranks: &[u64]) -> String {
    let mib = |bytes: &u64| format!("{:.0}", *bytes as f64 / f64::from(1 << 20));
    let all: Vec<String> = ranks.iter().map(mib).collect();
    format!("{} MiB by rank", all.join(", "))
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
    if let Some(engine) = &solved.engine {
        rows.push(("engine", over_ranks(engine)));
        rows.push(("peak memory", memory_of(&engine.peak_memory_bytes)));
        if let Some(times) = &engine.times {
            rows.push(("times", times_of(times)));
        }
    } else if let Some(bytes) = solved.peak_memory_bytes {
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
