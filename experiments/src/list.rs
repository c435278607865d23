//! The list of experiments: the only place besides its own file that a new experiment touches.

use crate::report::Experiment;

/// Every experiment, in the order of the report.
pub static EXPERIMENTS: &[&dyn Experiment] = &[
    &crate::e01_checkerboard::Checkerboard,
    &crate::e02_spectra::Spectra,
    &crate::e02b_spectrum_amg::SpectrumAmg,
    &crate::e03_conditioning::Conditioning,
    &crate::e04_efficiency::Efficiency,
    &crate::e05_mesh_independence::MeshIndependence,
    &crate::e06_c_laboratory::CLaboratory,
    &crate::e06b_relaxation::Relaxed,
    &crate::e07_contact_state::ContactStates,
    &crate::e08_size::Size,
    &crate::e09_work_precision::WorkPrecision,
    &crate::e10_inclined_crack::Inclined,
    &crate::e11_pressurised_cracks::PressurisedCracks,
    &crate::e12_orders::ObservedOrders,
    &crate::e13_checkerboard_traction::CheckerboardTractions,
    &crate::e14_cycle::Cycle,
    &crate::e15_nonlinear::Nonlinear,
];

/// What `fracas reproduce` runs without arguments: about two minutes on two cores.
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
