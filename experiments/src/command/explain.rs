//! `--explain`: what is known about one solve, for people.

use fracas_solvers::spectrum::Explanation;
use fracas_solvers::spectrum::explain::{Outlier, Seen};
use fracas_solvers::words::by_number;

/// Name and value of every fact that was measured, the advice last.
pub(super) fn rows(facts: &Explanation) -> Vec<(&'static str, String)> {
    let mut rows = vec![
        ("", String::new()),
        ("eigenvalues", seen(facts.seen.as_ref())),
    ];
    if let Some(seen) = &facts.seen {
        rows.extend(seen.outliers.iter().map(|o| ("outlier", outlier(o))));
    }
    rows.push((
        "‖A·rbm‖",
        facts.rigid_body.map_or_else(
            || "no coordinates".to_owned(),
            |r| {
                format!(
                    "≤ {:.1e} in {} rows away from supports ({} near one), {} {} not fit",
                    r.worst,
                    r.free_rows,
                    r.held_rows,
                    r.wrong_rows,
                    by_number(r.wrong_rows, "does", "do")
                )
            },
        ),
    ));
    rows.push((
        "C / H",
        facts.c_over_h.map_or_else(
            || "no H, or no C in this method".to_owned(),
            |c| {
                format!(
                    "{:.2e} … {:.2e} … {:.2e} (min, median, max), below {:.2} in {:.0} % of the rows",
                    c.min,
                    c.median,
                    c.max,
                    c.asked,
                    100.0 * c.share_below
                )
            },
        ),
    ));
    if let (Some(levels), Some(complexity)) = (facts.amg_levels, facts.operator_complexity) {
        rows.push((
            "multigrid",
            format!("{levels} levels, operator complexity {complexity:.2}"),
        ));
    }
    if let Some(share) = facts.inner_share {
        rows.push((
            "S̃_u in c_app",
            format!("{:.0} % of the flops of M⁻¹", 100.0 * share),
        ));
    }
    let t = &facts.time;
    let part =
        |name: &str, s: Option<f64>| s.map_or(String::new(), |s| format!("{name} {s:.2} s, "));
    rows.push((
        "time",
        format!(
            "{}{}other set-up {:.2} s, iterations {:.2} s",
            part("C", t.c_s),
            part("S̃_u", t.inner_s),
            t.other_setup_s,
            t.iterations_s
        ),
    ));
    rows.push(("advice", facts.advice.clone()));
    rows
}

fn seen(seen: Option<&Seen>) -> String {
    let Some(seen) = seen else {
        return "not measured: M is no linear map".into();
    };
    match (seen.modulus_min, seen.modulus_max, seen.kappa) {
        (Some(low), Some(high), Some(kappa)) => format!(
            "{low:.3e} ≤ |λ| ≤ {high:.3e}, κ = {kappa:.1e}, {} outliers ({} of {} Ritz values settled)",
            seen.n_outliers, seen.settled, seen.steps
        ),
        _ => format!("none of {} Ritz values settled", seen.steps),
    }
}

fn outlier(outlier: &Outlier) -> String {
    let (re, im) = outlier.eigenvalue;
    let place = outlier.place.map_or_else(
        || "place unknown without coordinates".to_owned(),
        |p| {
            let point = |x: [f64; 3]| format!("({:.4}, {:.4}, {:.4})", x[0], x[1], x[2]);
            format!(
                "around {} m, 90 % in {} unknowns between {} and {}, stiffness varies by {:.1e}",
                point(p.centre),
                p.unknowns,
                point(p.low),
                point(p.high),
                p.contrast
            )
        },
    );
    format!(
        "{re:.3e} {im:+.1e} i: {:.0} % in u, {:.0} % in t, {place}",
        100.0 * (1.0 - outlier.traction_share),
        100.0 * outlier.traction_share
    )
}
