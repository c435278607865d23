//! From each figure and table of the lecture to ours.

use super::Chapter;
use super::html::escape;
use super::math::prose;
use crate::list::EXPERIMENTS;
use std::fmt::Write as _;

/// How ours stands to what the lecture shows.
#[derive(Clone, Copy)]
enum Standing {
    /// The same problem.
    Same,
    /// Another mesh or geometry of the same character: that of the lecture is not public.
    Analogue,
    /// Curves of a model, whose parts are measured.
    Modelled,
    /// Data or photographs that are not public.
    NotPublic,
}

impl Standing {
    const fn words(self) -> &'static str {
        match self {
            Self::Same => "same problem",
            Self::Analogue => "analogue",
            Self::Modelled => "model",
            Self::NotPublic => "not public",
        }
    }
}

/// What the lecture shows, our experiments for it, how they stand to it, and a remark.
type Line = (
    &'static str,
    &'static [&'static str],
    Standing,
    &'static str,
);

/// Figures and tables of [1] of `docs/methods.md`, in its order.
#[rustfmt::skip]
const LINES: &[Line] = &[
    ("Faults, fracture zones and their permeability: drawings and photographs", &[], Standing::NotPublic, "Nothing is computed there."),
    ("Checkerboard of the unstable pair, and its patch test", &["e01", "e13"], Standing::Same, ""),
    ("Eigenvalues of M⁻¹𝒜 for each choice of C, with the bounds", &["e02"], Standing::Analogue, "The matrix is not named."),
    ("Eigenvalues of M⁻¹𝒜 with AMG for S_u, with the bounds", &["e02b"], Standing::Analogue, "The matrix is not named."),
    ("Conditioning of A and S_u, tests A, B, C", &["e03"], Standing::Analogue, "The meshes are not public; n_t/n_u agrees."),
    ("Table of n_it, c_app and C_s: RACP, MCP+AMG, MCP+FSAI on tests A, B, C", &["e04"], Standing::Analogue, "The meshes are not public; sizes and character agree."),
    ("Mesh independence", &["e05"], Standing::Analogue, "Numbers are not printed."),
    ("Weak and strong scalability on distributed memory", &["e27", "e08"], Standing::Modelled, "No cluster was measured: e27 measures 1, 2 and 4 ranks of one machine around PETSc's GAMG, and its curves to 4,096 are those of a model of messages; Chronos and its cluster are not public. e08 has time and memory per unknown on one machine, up to the published size."),
    ("Weak scalability with flow: four fractures, coarse and fine", &["e17"], Standing::Analogue, "Sizes agree; the geometry is not public."),
    ("Linear iterations for ratios between fracture and body, six meshes", &["e17"], Standing::Analogue, "Sizes agree for nine square fractures in a cube, with 8,748 for the printed 8,749 and 420,660 for 420,600, as the printed totals have them; geometry and loads are not public."),
    ("Tilted well through several fractures", &["e19"], Standing::Analogue, "Sizes agree for nine square fractures in a tall block; geometry and rates are not public."),
    ("Sliding and normal traction against closed forms", &["e10"], Standing::Same, "Parameters from Phan et al. 2003."),
    ("Opening and normal traction against closed forms", &["e11"], Standing::Same, "Sneddon's solutions."),
    ("Convergence of sliding, traction and energy", &["e12"], Standing::Same, ""),
    ("Ground ruptures: emerging bedrock, abrupt thickness, buried ridge", &["e23"], Standing::Analogue, "Geometry and parameters are stand-ins."),
    ("Laboratory experiment of a ground rupture", &[], Standing::NotPublic, "Its measurements are not printed."),
    ("Gas storage: seismic events, fields, pressure histories", &[], Standing::NotPublic, "Measured data of operators."),
    ("Gas storage: activation of faults, criticality, creep, sensitivity", &["e22"], Standing::Analogue, "Schematic geometry; offsets and depths are stand-ins."),
];

/// The last section of the page.
pub(super) fn section(html: &mut String, chapters: &[Chapter]) -> anyhow::Result<()> {
    html.push_str(
        "<section id=\"lecture\">\n<h2>From the lecture to this page</h2>\n\
         <p>Figures and tables of the lecture (M. Ferronato, SNA'25) in its order, and what answers them here.</p>\n\
         <table>\n<thead><tr><th>lecture</th><th>here</th><th>ours is</th><th>remark</th></tr></thead>\n<tbody>\n",
    );
    for (shown, ids, standing, remark) in LINES {
        let links: Vec<String> = ids.iter().map(|id| link(id, chapters)).collect();
        writeln!(
            html,
            "<tr><td>{}</td><td>{}</td><td>{}</td><td>{}</td></tr>",
            prose(shown),
            links.join(", "),
            standing.words(),
            prose(remark)
        )?;
    }
    html.push_str("</tbody>\n</table>\n");
    let others: Vec<String> = (EXPERIMENTS.iter().map(|e| e.id()))
        .filter(|id| LINES.iter().all(|(_, ids, ..)| !ids.contains(id)))
        .map(|id| link(id, chapters))
        .collect();
    writeln!(
        html,
        "<p>The lecture has no figure for {}.</p>\n</section>",
        others.join(", ")
    )?;
    Ok(())
}

/// A link into the page where the experiment is on it.
fn link(id: &str, chapters: &[Chapter]) -> String {
    let id = escape(id);
    match chapters.iter().any(|c| c.experiment.id() == id) {
        true => format!("<a href=\"#{id}\">{id}</a>"),
        false => id,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn every_experiment_that_is_named_exists_and_an_answer_has_one() {
        for (shown, ids, standing, remark) in LINES {
            for id in *ids {
                assert!(crate::list::find(id).is_some(), "{shown}: {id}");
            }
            let is_answered = matches!(standing, Standing::Same | Standing::Analogue);
            assert!(!is_answered || !ids.is_empty(), "{shown}");
            assert!(
                matches!(standing, Standing::Same) || !remark.is_empty(),
                "{shown}"
            );
        }
    }
}
