//! The rank of B in words: consequences, then places.

use std::fmt;

use super::error::{AXES, point};
use super::kernel::{CouplingKernel, KernelFinding, KernelReason};
use fracas_solvers::words::by_number;

/// Names of the three traction components.
const COMPONENTS: [&str; 3] = ["t_N", "t_1", "t_2"];

/// Writes the rank, what follows from it, and at most `shown` places; `names` are those of the fractures.
pub(super) fn write(
    f: &mut fmt::Formatter<'_>,
    kernel: &CouplingKernel,
    names: &[&str],
    shown: usize,
) -> fmt::Result {
    let free = kernel.stabilized_dimension;
    match kernel.dimension {
        Some(0) => writeln!(f, "rank        B has full rank")?,
        Some(k) if free == 0 => writeln!(
            f,
            "rank        dim ker B = {k}: singular without stabilization, regular with it"
        )?,
        Some(k) => writeln!(f, "rank        dim ker B = {k}")?,
        None => writeln!(
            f,
            "rank        too many faces for a dense rank of B; local counts below"
        )?,
    }
    let idle = kernel.idle_dimension;
    if idle > 0 {
        writeln!(
            f,
            "warning     {idle} traction {} on prescribed displacements or tips only and keep{} the initial stress until faces beside them slip; all else is unique",
            by_number(idle, "mode pushes", "modes push"),
            by_number(idle, "s", "")
        )?;
    }
    let singular = free - idle.min(free);
    if singular > 0 {
        writeln!(
            f,
            "warning     {singular} traction {} free even with stabilization: the system is singular",
            by_number(singular, "mode stays", "modes stay")
        )?;
    }
    let groups = grouped(&kernel.findings);
    for (finding, faces) in groups.iter().take(shown) {
        let label = match finding.reason {
            KernelReason::Counting { .. } => "note",
            _ => "warning",
        };
        let name = names[usize::from(finding.fracture)];
        let plural = by_number(*faces, "", "s");
        writeln!(
            f,
            "{label:<12}\"{name}\" on {faces} face{plural}, first face {} at {}: {}",
            finding.face,
            point(&finding.center),
            finding.reason
        )?;
    }
    match groups.len() > shown {
        true => writeln!(
            f,
            "            … and {} more findings on rank",
            groups.len() - shown
        ),
        false => Ok(()),
    }
}

/// Findings on single faces, one per fracture and reason, with the number of faces that they concern.
fn grouped(findings: &[KernelFinding]) -> Vec<(&KernelFinding, usize)> {
    let mut groups: Vec<(&KernelFinding, usize)> = Vec::new();
    for finding in findings {
        match finding.reason {
            KernelReason::UniformPatch { faces, .. } | KernelReason::Counting { faces, .. } => {
                groups.push((finding, faces));
            }
            KernelReason::NotSplit | KernelReason::EmptyColumn { .. } => {
                let same = groups
                    .iter_mut()
                    .find(|(g, _)| g.fracture == finding.fracture && g.reason == finding.reason);
                match same {
                    Some((_, faces)) => *faces += 1,
                    None => groups.push((finding, 1)),
                }
            }
        }
    }
    groups
}

impl fmt::Display for KernelReason {
    fn fmt(&self, f: &mut fmt::Formatter<'_>) -> fmt::Result {
        match self {
            Self::NotSplit => f.write_str(
                "all four corners are tips, so it cannot open (empty columns of B); refine, or let the fracture reach further",
            ),
            Self::EmptyColumn { component } => write!(
                f,
                "{} acts on prescribed displacements only (empty column of B); free one side or refine across",
                COMPONENTS[*component]
            ),
            Self::UniformPatch { direction, .. } => write!(
                f,
                "a uniform traction along {} on this patch does no work",
                AXES[*direction]
            ),
            Self::Counting {
                faces,
                direction,
                jumps,
            } => write!(
                f,
                "this patch has {faces} tractions along {} but {jumps} free jumps: stabilization is needed",
                AXES[*direction]
            ),
        }
    }
}
