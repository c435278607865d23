//! What happened on the way, as JSON.

use super::onsets;
use crate::nonlinear::Event;
use serde_json::{Value, json};

/// What is done where states do not settle.
const PROJECTION: &str = "the stabilization is held on what returning states constrain; then Newton on Coulomb's law of all faces at once";

/// Name and members of an event in `log.jsonl`.
pub fn event(event: &Event) -> (&'static str, Value) {
    match event {
        Event::Cycle {
            round,
            period,
            faces,
        } => (
            "cycle",
            json!({ "round": round, "period": period, "faces": faces, "remedy": PROJECTION }),
        ),
        Event::Projection { round, reason } => (
            "projection",
            json!({ "round": round, "reason": reason, "remedy": PROJECTION }),
        ),
        Event::Stabilized { faces } => (
            "stabilized",
            json!({ "faces": faces, "text": "the stabilization of jumps or pressures acts on these many faces beyond their states" }),
        ),
        Event::Unstabilized { faces } => (
            "unstabilized",
            json!({ "faces": faces, "text": "the stabilization of jumps leaves out these many faces, whose states return with it" }),
        ),
        Event::Torn { faces } => (
            "torn",
            json!({ "faces": faces, "text": "faces that open and close again within the step have no cohesion until its end" }),
        ),
        Event::Rounding { part, error } => ("rounding", json!({ "part": part, "error": error })),
        Event::Arrested { patch } => (
            "arrested",
            json!({
                "text": format!("unstable: {patch}; the step goes to where slip comes to rest without inertia"),
                "fracture": patch.fracture,
                "faces": patch.faces,
                "center_m": patch.center,
                "extent_m": patch.extent,
                "slope_pa_per_m": patch.slope,
                "ratio": patch.ratio,
                "nucleation_half_length_m": patch.nucleation,
                "slip_m": patch.slip,
            }),
        ),
        Event::Onset { fracture, onset } => ("onset", onsets::json(fracture, onset)),
        Event::Raised { parts, reason } => (
            "raised",
            json!({ "parts": parts, "reason": reason, "text": "given pressures were raised within the step in so many parts" }),
        ),
        Event::Retry { reason } => ("retry", json!({ "reason": reason })),
        Event::Cut { reason, next } => ("cut", json!({ "reason": reason, "next": next })),
        Event::Precision { reason } => ("precision", json!({ "reason": reason, "now": "f64" })),
        Event::Inner { reason, now } => ("inner", json!({ "reason": reason, "now": now })),
        Event::Unknown { reason } => ("stability_unknown", json!({ "reason": reason })),
        Event::Setup { faces } => ("setup", json!({ "faces": faces })),
    }
}
