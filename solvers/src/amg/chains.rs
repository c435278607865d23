//! Where Gauss–Seidel by nodes smooths badly.

use super::Amg;
use super::matrix::NodeMatrix;
use super::reach::Reach;
use crate::multigrid::{Smoother, Smoothing};
use fracas_operators::Real;
use fracas_operators::small::norm_squared;
use rayon::prelude::*;

/// `‖A_ij‖_F / √(‖A_ii‖_F ‖A_jj‖_F)` from which a neighbour counts as a link of a chain. Unit: 1.
///
/// A chain of nodes that are coupled to nothing else has 1/2: half of the diagonal on either side. Cubes of Q1 elements
/// have 0.20 (ν = 0.25), cells of 1:3, 1:5, 1:10, 1:50 have 0.41, 0.46, 0.49, 0.50 (limit: the chains across the layers);
/// cubes with ν = 0.40, 0.45, 0.47, 0.49, 0.499 have 0.31, 0.39, 0.42, 0.47, 0.50 (along diagonals of faces).
const LINK: f64 = 0.45;

/// `‖A_ij‖_F / |tr A_ij|` from which a link resists changes of volume above all: `√(2 + r²)/(2 + r)` across flat cells with
/// `r = (λ+2G)/G`, which is 0.66, 0.77, 0.85, 0.96 for ν = 0.25, 0.40, 0.45, 0.49, and 1 along diagonals. Unit: 1.
///
/// Below it the links of a node that has far neighbours do not count: aggregates follow them, and Gauss–Seidel smooths along them. Flat
/// cells of 1:2.5, 1:4, 1:8 with ν = 0.49 take 82, 59, 64 iterations by Gauss–Seidel, 33, 33, 29 by FSAI.
const VOLUME: f64 = 0.8;

/// What the settings say, or what the finest matrix asks for; no positions where they are not known, or where coarsening does not
/// heed them.
///
/// # Cost
/// Under [`Smoother::Auto`] one pass over the blocks.
pub(super) fn smoothing<R: Real>(
    settings: &Amg,
    finest: &NodeMatrix<R>,
    positions: &[[f64; 3]],
) -> Smoothing {
    if settings.smoother != Smoother::Auto {
        return Smoothing {
            smoother: settings.smoother,
            chained: None,
        };
    }
    let chained = chained(finest, &Reach::new(finest, None, positions, 1));
    Smoothing {
        smoother: if chained >= Smoothing::CHAINED {
            Smoother::Fsai
        } else {
            Smoother::GaussSeidel
        },
        chained: Some(chained),
    }
}

/// Share of the nodes with a neighbour that is a link.
fn chained<R: Real>(a: &NodeMatrix<R>, reach: &Reach<'_>) -> f64 {
    let sizes: Vec<f64> = (0..a.rows())
        .into_par_iter()
        .map(|i| norm_squared(a.diagonal(i)))
        .collect();
    let is_link = |i: usize| {
        let flat = reach.has_far(a, i);
        a.row(i).any(|(j, block)| {
            // squares on both sides
            let limit = LINK.powi(4) * sizes[i] * sizes[j];
            let size = norm_squared(block);
            let trace = block[0][0] + block[1][1] + block[2][2];
            let volume = size >= (VOLUME * trace.to_f64_exact()).powi(2);
            j != i && size * size >= limit && (volume || !flat)
        })
    };
    let links = (0..a.rows())
        .into_par_iter()
        .filter(|i| is_link(*i))
        .count();
    links as f64 / a.rows().max(1) as f64
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::elastic_sample::clamped_box;
    use fracas_operators::sparse::SparseMatrix;

    fn chosen(a: &SparseMatrix<f64>, at: &[crate::DofCoordinate]) -> Smoothing {
        let m = Amg::default().build(a, Some(at));
        m.unwrap().summary().smoothing
    }

    #[test]
    fn flat_cells_are_chains_and_cubes_are_not_in_any_unit() {
        for (h, smoother) in [
            ([1.0, 1.0, 1.0], Smoother::GaussSeidel),
            ([1.0, 0.6, 0.8], Smoother::GaussSeidel),
            ([1.0, 1.0, 0.1], Smoother::Fsai),
            ([0.01, 1.0, 1.0], Smoother::Fsai),
        ] {
            let (a, at) = clamped_box([8, 7, 7], h, |_| 1.0);
            // aggregates along the chains take their place where the nodes are known
            assert_eq!(chosen(&a, &at).smoother, Smoother::GaussSeidel, "{h:?}");
            let found = Amg::default().build(&a, None).unwrap().summary().smoothing;
            assert_eq!(found.smoother, smoother, "{h:?}: {found}");
            let chained = found.chained.unwrap();
            assert!(chained == 0.0 || chained > 0.8, "{h:?}: {found}");
            // D A D with one factor per node
            let factor = |i: usize| 10f64.powf(3.0 * (1.7 * (i / 3) as f64).sin());
            let mut scaled = a.clone();
            for (i, mut row) in scaled.outer_iterator_mut().enumerate() {
                row.iter_mut()
                    .for_each(|(j, v)| *v *= factor(i) * factor(j));
            }
            let map = crate::amg::node_map::NodeMap::new(&scaled, Some(&at));
            let blocks = crate::amg::finest::Sum::new(&scaled, None).unwrap();
            let blocks = blocks.blocks::<f64>(&map, blocks.pattern(&map)).unwrap();
            let again = smoothing(&Amg::default(), &blocks.matrix, &[]);
            assert!((again.chained.unwrap() - chained).abs() < 0.01);
        }
    }

    #[test]
    fn a_stiff_layer_in_a_body_of_cubes_does_not_decide() {
        // a stiff layer couples its nodes; the others are as in cubes
        let (a, at) = clamped_box([8, 7, 12], [1.0; 3], |c| if c[2] == 6 { 1e3 } else { 1.0 });
        let found = chosen(&a, &at);
        assert_eq!(found.smoother, Smoother::GaussSeidel, "{found}");
    }

    #[test]
    fn a_named_smoother_is_taken_as_it_is() {
        let (a, at) = clamped_box([6, 6, 6], [1.0, 1.0, 0.01], |_| 1.0);
        for smoother in [Smoother::GaussSeidel, Smoother::Chebyshev, Smoother::Fsai] {
            let m = Amg::with(smoother).build(&a, Some(&at)).unwrap();
            let found = m.summary().smoothing;
            assert_eq!((found.smoother, found.chained), (smoother, None));
        }
    }
}
