//! Rows of `history.csv`, `solver.csv`, `energy.csv` and `flow.csv`.

use crate::flow::{FlowRecord, WellRecord};
use crate::nonlinear::{EnergyRecord, FaultRecord, LinearRecord, StepRecord};
use fracas_solvers::saddle::{T, U};

/// First line of `history.csv`.
pub(super) const HISTORY: &str = "step,time_s,dt_s,active_it,newton_it,lin_it,lin_res,stick,newslip,slip,open,changed_area,max_pen,max_tau_viol,slip_max_m,h_jump_max_m,h_overlap_max_m,cuts,wall_s,max_slip_viol,arrested,error_u,error_t\n";

/// First line of `solver.csv`.
pub(super) const SOLVER: &str = "step,attempt,active,newton,krylov,iterations,tolerance,relative_residual,residual,step_length,setup,stick,newslip,slip,open\n";

/// First line of `energy.csv`.
pub(super) const ENERGY: &str = "step,time_s,external_work_J,pressure_work_J,elastic_energy_J,elastic_change_J,contact_work_J,dissipation_J,balance_error_J,stabilization_work_J\n";

/// What `energy.csv` has besides where rock creeps.
const ENERGY_CREEP: &str = "creep_work_J,creep_dissipation_J";

/// First line of `energy.csv`.
pub(super) fn energy_heading(creeps: bool) -> String {
    match creeps {
        true => format!("{},{ENERGY_CREEP}\n", ENERGY.trim_end()),
        false => ENERGY.into(),
    }
}

/// First line of `fault.csv`: a row per fracture and step.
const FAULT: &str = "step,time_s,fracture,slipping_area_m2,slip_mean_m,slip_max_m,normal_force_N,shear_force_N,moment_Nm,chi_max,open_area_m2,moment_step_Nm,released_J,dissipated_J,aperture_max_m\n";

/// What `fault.csv` has besides where friction follows the path of slip.
const FAULT_PATH: &str = "cumulated_slip_mean_m,cumulated_slip_max_m";

/// First line of `fault.csv`.
pub(super) fn fault_heading(paths: bool) -> String {
    match paths {
        true => format!("{},{FAULT_PATH}\n", FAULT.trim_end()),
        false => FAULT.into(),
    }
}

/// First line of `flow.csv`: volumes of the step, then rate and pressure of every well.
pub(super) fn flow_heading<'w>(wells: impl Iterator<Item = &'w str>) -> String {
    let mut heading =
        "step,time_s,injected_m3,stored_opening_m3,stored_compression_m3,out_m3,balance_error_m3"
            .to_owned();
    for well in wells {
        heading += &format!(",{well}_rate_m3_s,{well}_pressure_Pa");
    }
    heading + "\n"
}

/// Columns of a history row before `wall_s`.
pub(super) const NUMBERS: usize = 18;

/// A row of `history.csv`; numbers read back to the last bit, and `wall_s` stays empty where no clock was asked for.
pub(super) fn row(record: &StepRecord, wall_s: Option<f64>) -> String {
    let r = record;
    let [stick, newslip, slip, open] = r.faces;
    let wall = wall_s.map_or(String::new(), |s| format!("{s:.3}"));
    format!(
        "{},{:?},{:?},{},{},{},{:?},{stick},{newslip},{slip},{open},{:?},{:?},{:?},{:?},{:?},{:?},{},{wall},{:?},{},{},{}\n",
        r.step,
        r.time,
        r.dt,
        r.active_it,
        r.newton_it,
        r.lin_it,
        r.lin_res,
        r.changed_area,
        r.max_pen,
        r.max_tau_viol,
        r.slip_max,
        r.h_jump,
        r.h_overlap,
        r.cuts,
        r.max_slip_viol,
        u8::from(r.arrested),
        error(r.error[U]),
        error(r.error[T])
    )
}

/// An error, empty where only residuals are judged.
fn error(error: f64) -> String {
    if error.is_nan() {
        return String::new();
    }
    format!("{error:?}")
}

/// A row of `solver.csv`.
pub(super) fn solver_row(r: &LinearRecord) -> String {
    let [stick, newslip, slip, open] = r.faces;
    format!(
        "{},{},{},{},{},{},{:?},{:?},{:?},{:?},{},{stick},{newslip},{slip},{open}\n",
        r.step,
        r.attempt,
        r.active,
        r.newton,
        r.krylov,
        r.iterations,
        r.tolerance,
        r.relative_residual,
        r.residual,
        r.step_length,
        u8::from(r.setup)
    )
}

/// A row of `energy.csv`.
pub(super) fn energy_row(record: &StepRecord, e: &EnergyRecord, creeps: bool) -> String {
    let creep = match creeps {
        true => format!(",{:?},{:?}", e.creep_work, e.creep_dissipation),
        false => String::new(),
    };
    format!(
        "{},{:?},{:?},{:?},{:?},{:?},{:?},{:?},{:?},{:?}{creep}\n",
        record.step,
        record.time,
        e.external_work,
        e.pressure_work,
        e.elastic_energy,
        e.elastic_change,
        e.contact_work,
        e.dissipation,
        e.error,
        e.stabilization_work
    )
}

/// A name as a cell: a comma in it would be another column.
pub(super) fn quoted(name: &str) -> String {
    name.replace([',', '"', '\n'], "_")
}

/// Rows of `fault.csv`.
pub(super) fn fault_rows(record: &StepRecord, faults: &[FaultRecord], paths: bool) -> String {
    let row = |f: &FaultRecord| {
        let numbers = [
            f.slipping_area,
            f.slip_mean,
            f.slip_max,
            f.normal_force,
            f.shear_force,
            f.moment,
            f.chi_max,
            f.open_area,
            f.moment_step,
            f.released,
            f.dissipated,
            f.aperture_max,
        ];
        let numbers: String = numbers.iter().map(|v| format!(",{v:?}")).collect();
        let path = match paths {
            true => format!(",{:?},{:?}", f.path_mean, f.path_max),
            false => String::new(),
        };
        let name = quoted(&f.name);
        format!("{},{:?},{name}{numbers}{path}\n", record.step, record.time)
    };
    faults.iter().map(row).collect()
}

/// A row of `flow.csv`.
pub(super) fn flow_row(record: &StepRecord, f: &FlowRecord, wells: &[WellRecord]) -> String {
    let mut row = format!(
        "{},{:?},{:?},{:?},{:?},{:?},{:?}",
        record.step,
        record.time,
        f.injected,
        f.stored_opening,
        f.stored_compression,
        f.out,
        f.error
    );
    for well in wells {
        row += &format!(",{:?},{:?}", well.rate, well.pressure);
    }
    row + "\n"
}

/// The rows of `history.csv` up to `wall_s`, as numbers.
#[derive(Clone, Debug, Default, PartialEq)]
pub struct History(Vec<[f64; NUMBERS]>);

impl History {
    /// First line of `history.csv`, with its line break.
    pub const HEADING: &str = HISTORY;

    /// The line of a step without the time that it took, with its line break.
    pub fn line(record: &StepRecord) -> String {
        row(record, None)
    }

    /// Of the lines of a file, without its heading.
    pub(super) fn read(lines: &[String]) -> Self {
        Self(lines.iter().filter_map(|row| numbers(row)).collect())
    }

    pub(super) fn push(&mut self, row: &str) {
        self.0.extend(numbers(row));
    }

    /// Accepted steps.
    pub fn len(&self) -> usize {
        self.0.len()
    }

    /// True where no step was accepted.
    pub fn is_empty(&self) -> bool {
        self.0.is_empty()
    }

    /// A column by its name in the heading of `history.csv`, before `wall_s`.
    ///
    /// # Panics
    /// For a name that is not there: ours to get right.
    pub fn column(&self, name: &str) -> impl Iterator<Item = f64> + '_ {
        let k = column(name);
        self.0.iter().map(move |row| row[k])
    }
}

/// The numbers of a history row up to `wall_s`, or `None` where it is no such row.
pub(super) fn numbers(row: &str) -> Option<[f64; NUMBERS]> {
    let fields: Vec<&str> = row.trim_end().split(',').collect();
    if fields.len() != HISTORY.split(',').count() {
        return None;
    }
    let values: Option<Vec<f64>> = fields[..NUMBERS].iter().map(|f| f.parse().ok()).collect();
    values?.try_into().ok()
}

/// Column of a history row by its name.
///
/// # Panics
/// For a name that is not in the heading: ours to get right.
pub(super) fn column(name: &str) -> usize {
    let place = HISTORY.trim_end().split(',').position(|c| c == name);
    assert!(
        place.is_some_and(|p| p < NUMBERS),
        "history.csv has no column {name}"
    );
    place.unwrap_or(0)
}

#[cfg(test)]
mod tests {
    use super::*;
    use fracas_operators::Fields;

    fn record() -> StepRecord {
        StepRecord {
            step: 3,
            time: 0.1 + 0.2,
            dt: 1e-9,
            active_it: 2,
            newton_it: 5,
            lin_it: 61,
            lin_res: 1.0 / 3.0,
            faces: [10, 1, 2, 4],
            changed_area: 0.5,
            max_pen: 0.0,
            max_tau_viol: 1e20,
            max_slip_viol: 2e-7,
            arrested: true,
            error: Fields::new([(U, 1e-9), (T, f64::NAN)]),
            slip_max: 5e-324,
            h_jump: 2e-5,
            h_overlap: 1e-5,
            cuts: 1,
            setups: 4,
            reuses: 1,
        }
    }

    #[test]
    fn energies_have_a_number_per_column() {
        for creeps in [false, true] {
            let text = energy_row(&record(), &EnergyRecord::default(), creeps);
            let heading = energy_heading(creeps);
            assert_eq!(text.matches(',').count(), heading.matches(',').count());
        }
        for paths in [false, true] {
            let text = fault_rows(&record(), &[FaultRecord::default()], paths);
            let heading = fault_heading(paths);
            assert_eq!(text.matches(',').count(), heading.matches(',').count());
        }
        let well = WellRecord {
            name: "W".into(),
            rate: 1.0,
            pressure: 2.0,
        };
        let text = flow_row(&record(), &FlowRecord::default(), &[well]);
        let heading = flow_heading(["W"].into_iter());
        assert_eq!(text.matches(',').count(), heading.matches(',').count());
    }

    #[test]
    fn a_row_has_a_number_per_column_and_reads_back() {
        let text = row(&record(), None);
        assert_eq!(text.matches(',').count(), HISTORY.matches(',').count());
        assert!(text.ends_with(",1,,2e-7,1,1e-9,\n"));
        let values = numbers(&text).unwrap();
        for (name, expected) in [
            ("step", 3.0),
            ("time_s", 0.1 + 0.2),
            ("dt_s", 1e-9),
            ("lin_res", 1.0 / 3.0),
            ("stick", 10.0),
            ("open", 4.0),
            ("max_tau_viol", 1e20),
            ("slip_max_m", 5e-324),
            ("h_jump_max_m", 2e-5),
            ("h_overlap_max_m", 1e-5),
            ("cuts", 1.0),
        ] {
            assert_eq!(values[column(name)], expected, "{name}");
        }
        assert!(row(&record(), Some(1.5)).ends_with(",1,1.500,2e-7,1,1e-9,\n"));
        assert_eq!(numbers("1,2"), None);
    }
}
