//! The list of experiments, written in Rust or as study files: the only place besides its own file that a new one touches.

use crate::report::Experiment;
use crate::study::gallery;

/// Every experiment, in the order of the report.
pub static EXPERIMENTS: &[&dyn Experiment] = &[
    &crate::e01_checkerboard::Checkerboard,
    &gallery::E02,
    &gallery::E02B,
    &gallery::E03,
    &gallery::E04,
    &gallery::E04B,
    &gallery::E05,
    &gallery::E06,
    &gallery::E06B,
    &gallery::E07,
    &gallery::E08,
    &gallery::E09,
    &crate::e10_inclined_crack::Inclined,
    &crate::e11_pressurised_cracks::PressurisedCracks,
    &crate::e12_orders::ObservedOrders,
    &crate::e13_checkerboard_traction::CheckerboardTractions,
    &crate::e14_cycle::Cycle,
    &crate::e15_nonlinear::Nonlinear,
    &crate::e16_settings::Sensitivity,
    &crate::e17_four_fractures::FourFractures,
    &crate::e19_tilted_well::TiltedWell,
    &gallery::E20,
    &crate::e22_gas_storage::GasStorage,
    &crate::e23_ground_ruptures::GroundRuptures,
    &gallery::E24,
    &gallery::E25,
    &gallery::E26,
    &crate::e27_ranks::Ranks,
    &gallery::E28,
];

/// What `fracas reproduce --level paper` runs without names: about two minutes on two cores.
pub static SHORT_SELECTION: &[&str] = &["e01", "e02", "e03"];

/// The experiment with this id.
pub fn find(id: &str) -> Option<&'static dyn Experiment> {
    EXPERIMENTS.iter().copied().find(|e| e.id() == id)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn ids_are_unique_and_the_short_selection_exists() {
        for (k, e) in EXPERIMENTS.iter().enumerate() {
            assert!(
                EXPERIMENTS[..k].iter().all(|other| other.id() != e.id()),
                "{} appears twice",
                e.id()
            );
        }
        assert!(SHORT_SELECTION.iter().all(|id| find(id).is_some()));
    }
}
