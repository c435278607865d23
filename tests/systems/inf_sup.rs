//! Claim: the local certificate of a scene lies below its inf-sup constant, a third of it in the median of scenes with contrasts of 1e±8, cells of
//! 1:1000 and ν up to 0.4999.
//!
//! `INF_SUP_CASES=400 INF_SUP_SEED=7 cargo test --release --test systems inf_sup:: -- --nocapture` tries more scenes.

use super::accuracy::{environment, flat_scene, scene};
use fracas::scene::{Scene, gallery};
use fracas_solvers::direct::DirectChoice;
use fracas_solvers::eigen::dense::symmetric_eigenvalues;
use fracas_solvers::saddle::{AugmentationChoice, SaddleBlocks};
use fracas_solvers::spectrum::certificate;

/// Scenes of each family tried where nobody asks for more.
const CASES: u64 = 12;

/// `λ_min(C₀⁻¹(S + H))` by its definition; `None` where A has no inverse or S + H is lost in rounding.
fn beta_squared(blocks: &SaddleBlocks) -> Option<f64> {
    let direct = DirectChoice::Faer.solver().unwrap();
    let exact = AugmentationChoice::ExactH.compute(blocks, direct.as_ref());
    let sum = exact.ok()?.matrix.to_dense();
    let mut c_0 = vec![0.0; blocks.n_t()];
    for (i, row) in blocks.b1.outer_iterator().enumerate() {
        row.iter()
            .for_each(|(k, b)| c_0[k] += b * b / blocks.a.get(i, i).unwrap());
    }
    // a traction on displacements that are all held has H alone
    let own = |k: usize| blocks.h.as_ref().and_then(|h| h.get(k, k).copied());
    for (k, c) in c_0.iter_mut().enumerate().filter(|(_, c)| **c == 0.0) {
        *c = own(k).unwrap_or(1.0);
    }
    let scaled = faer::Mat::from_fn(c_0.len(), c_0.len(), |i, j| {
        sum[(i, j)] / (c_0[i] * c_0[j]).sqrt()
    });
    let values = symmetric_eigenvalues(scaled.as_ref()).unwrap();
    (values[0] > 1e-9 * values[values.len() - 1]).then_some(values[0])
}

#[test]
fn the_certificate_of_a_scene_lies_below_its_inf_sup_constant() {
    let cases = environment("INF_SUP_CASES", CASES);
    let first = environment("INF_SUP_SEED", 1).wrapping_mul(0x5851_F42D_4C95_7F2D);
    let seeds = (0..cases).map(|seed| first.wrapping_add(seed));
    let texts = seeds.flat_map(|seed| [scene(seed), flat_scene(seed)]);
    let drawn = texts.map(|text| Scene::from_toml(&text, "scene.toml").unwrap());
    let shown = gallery().iter().map(|entry| entry.small_scene().unwrap());
    let (mut shares, mut gains) = (Vec::new(), Vec::new());
    for scene in drawn.chain(shown) {
        let body = scene.build().unwrap();
        let h = Some(body.jump_stabilization());
        let blocks = body.saddle_blocks(h).unwrap();
        let Some(found) = body.stick_system(h).certificate().unwrap() else {
            continue;
        };
        let of_matrix = certificate(&blocks).unwrap().unwrap();
        let Some(truth) = beta_squared(&blocks) else {
            continue;
        };
        let title = scene.title();
        assert!(
            found.beta_squared <= truth * (1.0 + 1e-6)
                && of_matrix.beta_squared <= truth * (1.0 + 1e-6),
            "{title}: {found:?} and {of_matrix:?} are not below {truth}"
        );
        shares.push(found.beta_squared / truth);
        if of_matrix.beta_squared > 0.0 {
            gains.push(found.beta_squared / of_matrix.beta_squared);
        }
        let both = body.stick_system(h).certificate_beside(&blocks).unwrap();
        let sharper = found.beta_squared.max(of_matrix.beta_squared);
        assert_eq!(both.unwrap().beta_squared, sharper, "{title}");
    }
    for list in [&mut shares, &mut gains] {
        list.sort_by(f64::total_cmp);
    }
    let middle = shares.len() / 2;
    println!(
        "{} scenes; bound over truth {:.3} to {:.3}, median {:.3}; over that of the matrix {:.3} to {:.3}, median {:.3}",
        shares.len(),
        shares[0],
        shares[shares.len() - 1],
        shares[middle],
        gains[0],
        gains[gains.len() - 1],
        gains[middle]
    );
    // most scenes have an A with an inverse, and a bound of zero would be none
    assert!(shares.len() as u64 > cases);
    assert!(shares[shares.len() / 20] > 0.0 && shares[middle] > 0.3);
}
