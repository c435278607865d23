//! What happened on the way, as JSON.

use fracas::nonlinear::Event;
use serde_json::{Value, json};

/// Name and members of an event in `log.jsonl`.
pub(super) fn event(event: &Event) -> (&'static str, Value) {
    match event {
        Event::Cycle {
            round,
            period,
            faces,
            remedy,
        } => (
            "cycle",
            json!({ "round": round, "period": period, "faces": faces, "remedy": remedy.text() }),
        ),
        Event::Retry { reason } => ("retry", json!({ "reason": reason })),
        Event::Cut { reason, next } => ("cut", json!({ "reason": reason, "next": next })),
        Event::Precision { reason } => ("precision", json!({ "reason": reason, "now": "f64" })),
        Event::Setup { faces } => ("setup", json!({ "faces": faces })),
    }
}
