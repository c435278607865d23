//! From the finest matrix to all levels.

use super::level::{Step, step};
use crate::SetupError;
use crate::amg::coarse::NotPositive;
use crate::amg::finest::Finest;
use crate::amg::hierarchy::{Hierarchy, Level, MOST_LEVELS, Representatives};
use crate::amg::transfer::Transfer;
use crate::amg::{Amg, Smoothing};
use fracas_operators::Real;

impl<R: Real> Hierarchy<R> {
    /// Coarsens until a direct solver takes over, as [`Hierarchy::new`] does, but every coarse node is a fine one.
    ///
    /// # Errors
    /// As [`Hierarchy::new`].
    pub(in crate::amg) fn classical<const K: usize>(
        settings: &Amg,
        finest: Finest<R>,
        modes: &[[[f64; K]; 3]],
        near_null_space: &'static str,
        unknown: &dyn Fn(usize) -> usize,
    ) -> Result<Self, SetupError> {
        let first = finest.matrix;
        let mut names = Representatives::new(first.rows(), unknown);
        let smoothing = Smoothing::new(settings, &first);
        let settings = &smoothing.in_settings(settings);
        let about = (near_null_space, smoothing);
        let mut levels = Vec::new();
        if 3 * first.rows() <= settings.coarsest {
            return Self::ending(levels, &first, &names, about);
        }
        let coarse = step(&first, &finest.defect, finest.bonds.as_ref(), modes);
        let Some(mut coarse) = coarse.map_err(|NotPositive(row)| names.indefinite(row))? else {
            return Self::ending(levels, &first, &names, about);
        };
        levels.push(Level {
            fsai: names.smoother(settings, &first)?,
            matrix: first,
            transfer: transfer(&coarse),
            lambda_max: coarse.lambda_max,
        });
        names.adopt(&coarse.closest, 1, 1);
        while coarse.goes_on(settings) && levels.len() < MOST_LEVELS {
            let next = step(&coarse.matrix, &[], coarse.bonds.as_ref(), &coarse.modes);
            let Some(next) = next.map_err(|NotPositive(row)| names.indefinite(row))? else {
                break;
            };
            levels.push(Level {
                fsai: names.smoother(settings, &coarse.matrix)?,
                matrix: coarse.matrix.cast(),
                transfer: transfer(&next),
                lambda_max: next.lambda_max,
            });
            names.adopt(&next.closest, 1, 1);
            coarse = next;
        }
        Self::ending(levels, &coarse.matrix, &names, about)
    }
}

fn transfer<R: Real, const K: usize>(step: &Step<K>) -> Transfer<R> {
    Transfer::new(&step.prolongation, step.closest.count)
}
