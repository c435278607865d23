//! The inf-sup constant of a mesh: among all eigenvalues, and alone where there are too many of them.

use faer::Mat;
use fracas::contact::{JumpStabilization, Rocks};
use fracas::elasticity::{Constraints, Elastic};
use fracas::mesh::BuiltMesh;
use fracas::system::StickSystem;
use fracas_solvers::direct::{DirectChoice, Kind};
use fracas_solvers::eigen::dense::{symmetric_eigen, symmetric_eigenvalues, to_dense};
use fracas_solvers::eigen::{Ends, LanczosSettings, extreme_eigenvalues};
use fracas_solvers::saddle::augmentation::dual_schur;
use fracas_solvers::saddle::{AugmentationChoice, SaddleBlocks, T};

/// A singular value below this fraction of the largest belongs to the kernel (rounding gives 1e-8 in the square root).
const KERNEL: f64 = 1e-6;

/// Share of β² that its bound gives away. Unit: 1.
const SHARE: f64 = 0.01;

/// Blocks of the body, fixed below and above.
fn blocks(
    built: &BuiltMesh,
    rock: Elastic,
    stabilization: JumpStabilization,
) -> anyhow::Result<SaddleBlocks> {
    let mut prescribed = vec![None; 3 * built.mesh.nodes.len()];
    for node in built.sides[4]
        .iter()
        .chain(&built.sides[5])
        .flat_map(|face| face.nodes)
    {
        for i in 0..3 {
            prescribed[3 * node as usize + i] = Some(0.0);
        }
    }
    let constraints = Constraints::new(prescribed);
    let system = StickSystem {
        mesh: &built.mesh,
        fractures: &built.fractures,
        materials: &[rock],
        jump_rocks: Rocks {
            elastic: &[rock],
            first_alike: &[0],
        },
        constraints: &constraints,
        stabilization: Some(stabilization),
    };
    Ok(system.assemble(&vec![0.0; constraints.full_len()])?)
}

/// What one mesh says.
pub(super) struct Row {
    pub(super) n_u: usize,
    pub(super) n_t: usize,
    pub(super) kernel: usize,
    pub(super) beta: [f64; 2],
    /// Normal traction of the weakest mode without H, per face.
    pub(super) weakest: Vec<f64>,
}

/// Kernel of B, and `β_h = λ_min(C_local⁻¹ (S + θH))^{1/2}` for θ = 0 and 1.
pub(super) fn measure(
    built: &BuiltMesh,
    rock: Elastic,
    stabilization: JumpStabilization,
) -> anyhow::Result<Row> {
    let blocks = blocks(built, rock, stabilization)?;
    let n_t = blocks.n_t();
    let b = to_dense(&blocks.b1);
    let gram = b.transpose() * &b;
    let squares = symmetric_eigenvalues(gram.as_ref())?;
    let largest = squares.iter().copied().fold(0.0, f64::max);
    let kernel = squares
        .iter()
        .filter(|v| **v < KERNEL * KERNEL * largest)
        .count();

    let s = dual_schur(&blocks, &*DirectChoice::Auto.solver()?)?;
    let c = local(&blocks)?;
    let h = h_of(&blocks);
    let (bare, modes) = symmetric_eigen(scaled(&s, None, &c).as_ref())?;
    let stabilized = symmetric_eigenvalues(scaled(&s, Some(&h), &c).as_ref())?;
    Ok(Row {
        n_u: blocks.n_u(),
        n_t,
        kernel,
        beta: [
            if kernel > 0 { 0.0 } else { root(bare[0]) },
            root(stabilized[0]),
        ],
        weakest: (0..n_t / 3).map(|f| modes[(3 * f, 0)]).collect(),
    })
}

/// `β_h` of a mesh with each of these H, from all eigenvalues.
pub(super) fn all<const N: usize>(
    built: &BuiltMesh,
    rock: Elastic,
    forms: [JumpStabilization; N],
) -> anyhow::Result<[f64; N]> {
    let first = blocks(built, rock, forms[0])?;
    // A and B, and with them S and C_local, know nothing of H
    let (s, c) = (
        dual_schur(&first, &*DirectChoice::Auto.solver()?)?,
        local(&first)?,
    );
    let mut found = [0.0; N];
    for (found, form) in found.iter_mut().zip(forms) {
        let h = h_of(&blocks(built, rock, form)?);
        *found = root(symmetric_eigenvalues(scaled(&s, Some(&h), &c).as_ref())?[0]);
    }
    Ok(found)
}

/// H, dense.
fn h_of(blocks: &SaddleBlocks) -> Mat<f64> {
    let n_t = blocks.n_t();
    (blocks.h.as_ref()).map_or_else(|| Mat::zeros(n_t, n_t), to_dense)
}

/// `C^{-1/2} (S + H) C^{-1/2}`, which has the eigenvalues of the pencil.
fn scaled(s: &Mat<f64>, h: Option<&Mat<f64>>, c: &[f64]) -> Mat<f64> {
    Mat::from_fn(c.len(), c.len(), |i, j| {
        (s[(i, j)] + h.map_or(0.0, |h| h[(i, j)])) / (c[i] * c[j]).sqrt()
    })
}

/// Of an eigenvalue that rounding may leave below zero.
fn root(value: f64) -> f64 {
    value.max(0.0).sqrt()
}

/// The diagonal of C_local.
fn local(blocks: &SaddleBlocks) -> anyhow::Result<Vec<f64>> {
    let solver = DirectChoice::Auto.solver()?;
    let c = AugmentationChoice::Local.compute(blocks, &*solver)?;
    Ok(c.matrix.diagonal_entries())
}

/// `β_h = λ_min(C_local⁻¹ (S + H))^{1/2}` alone.
#[derive(Clone, Copy, Debug)]
pub(super) struct Constant {
    pub(super) n_t: usize,
    pub(super) beta: f64,
    /// β_h is not below this but in one of 10⁹ cases.
    pub(super) at_least: f64,
}

/// By Lanczos on `C^{1/2}(S + H)⁻¹C^{1/2}`, whose largest eigenvalue is 1/β²: `[A B; Bᵀ −H]` is factorized once, and its solution with
/// `(0, −r)` on the right has `t = (S + H)⁻¹ r`.
///
/// [`LanczosSettings::within`] bounds it above, so that β is known from below to half a per cent.
pub(super) fn constant(
    built: &BuiltMesh,
    rock: Elastic,
    stabilization: JumpStabilization,
) -> anyhow::Result<Constant> {
    let blocks = blocks(built, rock, stabilization)?;
    let unit = blocks.traction_unit();
    let blocks = blocks.into_traction_unit(unit);
    let root: Vec<f64> = local(&blocks)?.into_iter().map(f64::sqrt).collect();
    let whole = blocks.assembled();
    let solver = DirectChoice::Auto.solver()?;
    let factor = solver.analyze(&whole, Kind::General)?.factor(&whole)?;
    let (n_t, own) = (blocks.n_t(), blocks.layout().range(T));
    let (mut r, mut z) = (vec![0.0; blocks.size()], vec![0.0; blocks.size()]);
    let mut work = vec![0.0; factor.work_len()];
    let mut product = |x: &[f64], y: &mut [f64]| {
        (r[own.clone()].iter_mut().zip(x).zip(&root)).for_each(|((r, x), c)| *r = -c * x);
        factor.solve(&r, &mut z, &mut work);
        (y.iter_mut().zip(&z[own.clone()]).zip(&root)).for_each(|((y, z), c)| *y = c * z);
    };
    let settings = LanczosSettings::within(n_t, SHARE, Ends::Largest);
    let (_, largest) = extreme_eigenvalues(n_t, &mut product, None, settings)?;
    let beta = largest.value.sqrt().recip();
    Ok(Constant {
        n_t,
        beta,
        at_least: beta * (1.0 - SHARE).sqrt(),
    })
}

#[cfg(test)]
mod tests {
    use super::super::{ROCK, columns};
    use super::*;
    use fracas::contact::Junctions;

    #[test]
    fn alone_it_is_the_least_of_all_eigenvalues() {
        let built = columns::mesh(4).unwrap();
        for junctions in [Junctions::Apart, Junctions::Joined] {
            let form = JumpStabilization {
                junctions,
                ..JumpStabilization::PUBLISHED
            };
            let [_, all] = measure(&built, ROCK, form).unwrap().beta;
            let alone = constant(&built, ROCK, form).unwrap();
            assert!((alone.beta / all - 1.0).abs() < 1e-8, "{alone:?} {all}");
            assert!(alone.at_least < all && alone.at_least > 0.99 * all);
        }
    }
}
