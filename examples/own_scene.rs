//! A scene from code: the slip of a fault over its friction angle.
//!
//! `cargo run --release --example own_scene`

use fracas::nonlinear::Simulation;
use fracas::scene::Scene;
use fracas_solvers::Silent;

/// A block of 4 m with a cut, one half pushed by 1 mm against the other, and by 2 mm along it.
fn scene(friction_angle: f64) -> String {
    format!(
        "title = 'pushed'
         mesh = {{ x = {{ from = '0 m', to = '4 m', cells = 6 }}, y = {{ from = '0 m', to = '4 m', cells = 6 }}, z = {{ from = '0 m', to = '4 m', cells = 6 }} }}
         material = [{{ name = 'rock', young = '10 GPa', poisson = 0.25 }}]
         fracture = [{{ name = 'cut', plane = 'x', at = '2 m', friction_angle = '{friction_angle} deg' }}]
         boundary = [
             {{ side = 'x-', hold = 'fixed' }},
             {{ side = 'y-', hold = 'roller' }},
             {{ side = 'y+', hold = 'roller' }},
             {{ side = 'x+', displacement = {{ x = '-1 mm', z = '2 mm' }} }},
         ]"
    )
}

pub(crate) fn main() -> Result<(), Box<dyn std::error::Error>> {
    let mut before = f64::INFINITY;
    for friction_angle in [10.0, 15.0, 20.0, 25.0] {
        let body = Scene::from_toml(&scene(friction_angle), "pushed.toml")?.build()?;
        let mut simulation = Simulation::new(&body)?;
        let state = simulation
            .advance(&simulation.initial_state(), &mut Silent)?
            .state;
        let fields = simulation.face_fields(&state);
        let area: f64 = body.fractures.faces.iter().map(|face| face.area).sum();
        let faces = body.fractures.faces.iter().zip(&fields.slip);
        let mean = faces.map(|(face, slip)| face.area * slip).sum::<f64>() / area;
        println!("friction {friction_angle}°: mean slip {:.4} mm", 1e3 * mean);
        assert!(0.0 < mean && mean < before, "less friction, more slip");
        before = mean;
    }
    Ok(())
}
