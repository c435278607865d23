//! What the fractures of a run did, from the rows of its `fault.csv`.

use super::csv::{columns, number};
use super::measured::Faults;

/// Its columns that are read.
const NAMES: [&str; 9] = [
    "step",
    "time_s",
    "slipping_area_m2",
    "slip_max_m",
    "chi_max",
    "open_area_m2",
    "moment_step_Nm",
    "dissipated_J",
    "aperture_max_m",
];

/// Sums and largest values over all fractures and steps; `None` where the run has no fracture or no step.
///
/// # Errors
/// Of a column that is missing, and of what is no number.
pub(super) fn faults(text: &str) -> anyhow::Result<Option<Faults>> {
    let rows = columns("fault.csv", text, NAMES)?;
    let mut faults = Faults::default();
    let (mut step, mut areas) = (f64::NAN, [0.0; 2]);
    for (k, row) in rows.iter().enumerate() {
        let mut values = [0.0; NAMES.len()];
        for ((value, field), name) in values.iter_mut().zip(row).zip(NAMES) {
            *value = number("fault.csv", k, name, field)?;
        }
        let [
            of,
            time,
            slipping,
            slip,
            chi,
            open,
            moment,
            dissipated,
            aperture,
        ] = values;
        if of != step {
            (step, areas) = (of, [0.0; 2]);
        }
        // a row per fracture: areas of a step add up
        areas = [areas[0] + slipping, areas[1] + open];
        faults.slipping = faults.slipping.max(areas[0]);
        faults.open = faults.open.max(areas[1]);
        faults.slip = faults.slip.max(slip);
        faults.criticality = faults.criticality.max(chi);
        faults.moment += moment;
        faults.dissipated += dissipated;
        faults.aperture = faults.aperture.max(aperture);
        // rows are in the order of steps; the moment of faces that stick is rounding
        if slipping > 0.0 {
            faults.onset.get_or_insert(time);
        }
        if open > 0.0 {
            faults.opening.get_or_insert(time);
        }
    }
    Ok((!rows.is_empty()).then_some(faults))
}

#[cfg(test)]
mod tests {
    use super::*;

    const HEADING: &str = "step,time_s,fracture,slipping_area_m2,slip_mean_m,slip_max_m,normal_force_N,shear_force_N,moment_Nm,chi_max,open_area_m2,moment_step_Nm,released_J,dissipated_J,aperture_max_m\n";

    #[test]
    fn fractures_of_a_step_add_up_and_steps_do_not() {
        let rows = "0,0.0,a,0,0,0,-1,0,0,0.5,0,1e-9,0,0,0\n0,0.0,b,0,0,0,-1,0,0,0.7,0,0,0,0,0\n\
                    1,2.5,a,3,0,0.01,-1,0,4,1,0,4,0,10,0\n1,2.5,b,4,0,0.02,-1,0,5,1,0,5,0,20,0\n\
                    2,5.0,a,6,0,0.015,-1,0,3,0.9,1,1,0,2,0.25\n2,5.0,b,0,0,0.02,-1,0,5,0,2,0,0,0,0.5\n";
        let found = faults(&format!("{HEADING}{rows}")).unwrap().unwrap();
        let expected = Faults {
            onset: Some(2.5),
            opening: Some(5.0),
            aperture: 0.5,
            slip: 0.02,
            slipping: 7.0,
            open: 3.0,
            moment: 10.0 + 1e-9,
            criticality: 1.0,
            dissipated: 32.0,
        };
        assert_eq!(found, expected);
    }

    #[test]
    fn a_run_without_steps_has_none_and_a_torn_heading_is_named() {
        assert_eq!(faults(HEADING).unwrap(), None);
        let error = faults("step,time_s\n0,0\n").unwrap_err().to_string();
        assert!(error.contains("slipping_area_m2"), "{error}");
        let torn = format!("{HEADING}0,0.0,a,x,0,0,-1,0,0,0.5,0,0,0,0,0\n");
        let error = faults(&torn).unwrap_err().to_string();
        assert!(
            error.contains("line 2: slipping_area_m2 is \"x\""),
            "{error}"
        );
    }
}
