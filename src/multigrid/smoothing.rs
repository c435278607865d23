//! The polynomial that smooths.

use super::{Geometric, GeometricError};
use crate::elasticity::Elastic;
use fracas_solvers::multigrid::Chebyshev;

/// Smallest over largest eigenvalue of the interval on which the polynomial of rocks with ν = ¼ smooths. Unit: 1.
const SHARE: f64 = 1.0 / 20.0;

/// Power of the volumetric stiffness that the degree grows with. `incompressible` takes 22, 16, 13, 12 iterations with 0, 0.2, 0.4, 0.8, C_s
/// 208, 232, 287, 629: it pays on fine grids, below. Unit: 1.
const POWER: f64 = 0.4;

/// Degree beyond which rock is not smoothed: with ν = ½ − 1e-8, of 1,900, `crossing` takes 10 s and 50 iterations; with ½ − 1e-10, of 12,000, there
/// was no end in a minute, and no factorization has a digit. Unit: 1.
pub(super) const MOST_DEGREE: usize = 2_000;

/// The polynomial for the rock among `regions` (material of each element) that resists a change of volume most.
///
/// A diagonal block of a cube is a multiple of λ + 4G: it overestimates waves that keep the volume, whose stiffness is a multiple of
/// G, by `q = (λ+4G)/5G`, 1 for ν = ¼. To damp those as well at every ν takes an interval that begins q times lower, and √q times the
/// degree, since a Chebyshev polynomial reduces by the same factor on intervals of equal degree²·share. Part of those waves is for no
/// smoother, as coarse functions do not keep the volume; the least time on `layered_crossing` with 32³ cells is about where the degree
/// is `3 q^0.4` (ν = 0.45, 0.49, 0.495, 0.499: 4, 8, 10, 19; iterations 18, 22, 24, 29 in place of 23, 47, 66, 140).
///
/// Blocks smaller than a coarse cell, at which the hierarchy ends early, bend in ways that their coarse functions do not have: one degree
/// more, beside a solver of the bottom that costs more than the smoothing (columns of one cell, `analogue_c`: 28 iterations for 33).
///
/// # Errors
/// [`GeometricError::Incompressible`] where the degree would be above [`MOST_DEGREE`].
pub(super) fn polynomial(
    settings: &Geometric,
    materials: &[Elastic],
    regions: &[u16],
    ends_early: bool,
) -> Result<Chebyshev, GeometricError> {
    let mut present = vec![false; materials.len()];
    regions.iter().for_each(|r| present[usize::from(*r)] = true);
    let volumetric = |m: &Elastic| (m.lambda() + 4.0 * m.shear()) / (5.0 * m.shear());
    let rocks = materials.iter().zip(present);
    let rocks = rocks.filter(|(_, present)| *present);
    let rocks = rocks.map(|(m, _)| (volumetric(m), m.poisson));
    let (most, poisson) = rocks.fold(
        (1.0, 0.25),
        |most, rock| {
            if rock.0 > most.0 { rock } else { most }
        },
    );
    let asked = settings.degree.max(1) + usize::from(ends_early);
    let degree = (asked as f64 * most.powf(POWER)).round() as usize;
    if degree > MOST_DEGREE.max(asked) {
        return Err(GeometricError::Incompressible { poisson, degree });
    }
    let times = asked as f64 / degree as f64;
    Ok(Chebyshev {
        degree,
        share: SHARE * times * times,
    })
}

#[cfg(test)]
#[allow(clippy::unwrap_used)]
mod tests {
    use super::*;

    fn rock(poisson: f64) -> Elastic {
        Elastic {
            young: 1.0,
            poisson,
        }
    }

    #[test]
    fn the_degree_grows_with_the_stiffness_against_a_change_of_volume() {
        let settings = Geometric::default();
        let degrees = [-0.4, 0.0, 0.25, 0.3, 0.4, 0.45, 0.49, 0.495, 0.499].map(|nu| {
            polynomial(&settings, &[rock(nu)], &[0], false)
                .unwrap()
                .degree
        });
        assert_eq!(degrees, [3, 3, 3, 3, 4, 4, 8, 10, 19]);
    }

    #[test]
    fn rock_that_hardly_changes_its_volume_is_refused_at_once() {
        let settings = Geometric::default();
        let of = |nu: f64| polynomial(&settings, &[rock(0.2), rock(nu)], &[0, 1], false);
        assert!(of(0.5 - 1e-8).is_ok());
        let text = of(0.5 - 1e-10).unwrap_err().to_string();
        assert!(text.starts_with("rock of ν = 0.4999999999 "), "{text}");
    }

    #[test]
    fn only_rocks_of_the_body_count_and_every_polynomial_reduces_by_the_same() {
        let settings = Geometric::default();
        let rocks = [rock(0.25), rock(0.499)];
        let of = |regions: &[u16]| polynomial(&settings, &rocks, regions, false).unwrap();
        assert_eq!(of(&[0, 0]).degree, 3);
        assert_eq!(of(&[0, 1]).degree, 19);
        for p in [of(&[0]), of(&[1])] {
            let squared = (p.degree * p.degree) as f64 * p.share;
            assert!((squared - 9.0 * SHARE).abs() < 1e-14);
        }
    }
}
