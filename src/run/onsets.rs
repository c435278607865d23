//! When slip began: rows of `onset.csv`, and the same as JSON.

use super::history::quoted;
use crate::nonlinear::{Event, SlipOnset};
use serde_json::{Value, json};

/// First line of `onset.csv`: a row per onset.
pub(super) const ONSET: &str = "step,fracture,begins,time_before_s,time_after_s,x_m,y_m,z_m,area_m2,alphaDeltaP_minus_Pa,alphaDeltaP_plus_Pa,pressure_Pa\n";

/// Rows of the onsets among the events of a step.
pub(super) fn rows(step: usize, events: &[Event]) -> String {
    let row = |event: &Event| match event {
        Event::Onset { fracture, onset } => row(step, fracture, onset),
        _ => String::new(),
    };
    events.iter().map(row).collect()
}

fn row(step: usize, fracture: &str, onset: &SlipOnset) -> String {
    let before = onset.before.map_or(String::new(), |s| format!("{s:?}"));
    let ([x, y, z], [minus, plus]) = (onset.center, onset.drained);
    let numbers = [
        onset.after,
        x,
        y,
        z,
        onset.area,
        minus,
        plus,
        onset.pressure,
    ];
    let numbers: String = numbers.iter().map(|v| format!(",{v:?}")).collect();
    let (name, begins) = (quoted(fracture), onset.begins.name());
    format!("{step},{name},{begins},{before}{numbers}\n")
}

/// An onset in `log.jsonl` and `run.json`.
pub(super) fn json(fracture: &str, onset: &SlipOnset) -> Value {
    json!({
        "text": onset.told(fracture),
        "fracture": fracture,
        "begins": onset.begins.name(),
        "time_before_s": onset.before,
        "time_after_s": onset.after,
        "center_m": onset.center,
        "area_m2": onset.area,
        "alpha_delta_p_pa": onset.drained,
        "pressure_pa": onset.pressure,
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::nonlinear::Begins;

    #[test]
    fn a_row_has_a_number_per_column() {
        let onset = SlipOnset::sample(Begins::Patch, None);
        let event = Event::Onset {
            fracture: "a,b".into(),
            onset: Box::new(onset.clone()),
        };
        let row = rows(4, &[Event::Setup { faces: [0; 4] }, event]);
        assert_eq!(row.matches(',').count(), ONSET.matches(',').count());
        let expected = "4,a_b,patch,,0.30000000000000004,-0.5,0.3333333333333333,2.0,2.5,-10000000.0,0.0,3.0\n";
        assert_eq!(row, expected);
        let told = json("F", &onset);
        assert_eq!(told["time_before_s"], Value::Null);
        let text = "on fracture \"F\" a patch of 2.500000 m2 slips or opens by t = 0.30000000000000004 s, around (-0.500000, 0.333333, 2.000000) m";
        assert_eq!(told["text"], text);
    }
}
