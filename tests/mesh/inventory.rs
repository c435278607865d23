//! Claim: the inventory of a body has the volume of its box and the sums of its nodal forces.

use approx::assert_relative_eq;
use fracas::scene::named;

#[test]
fn volumes_and_forces_are_those_of_the_box() {
    for scene in ["patch", "cycle", "layered", "stretched"] {
        let body = named(scene)
            .unwrap()
            .small_scene()
            .unwrap()
            .build()
            .unwrap();
        let found = body.inventory();
        let corner = |pick: fn(f64, f64) -> f64, start: f64| {
            [0, 1, 2].map(|i| body.mesh.nodes.iter().map(|x| x[i]).fold(start, pick))
        };
        let (low, high) = (
            corner(f64::min, f64::INFINITY),
            corner(f64::max, f64::NEG_INFINITY),
        );
        let size: f64 = (0..3).map(|i| high[i] - low[i]).product();
        let volume: f64 = found.materials.iter().map(|m| m.volume).sum();
        assert_relative_eq!(volume, size, max_relative = 1e-10);
        let held: usize = found.held.iter().sum();
        assert_eq!(held, body.constraints.prescribed().len(), "{scene}");
        // the sum over the faces is that of the nodal forces
        let mut total = [0.0; 3];
        for push in &found.pushes {
            (0..3).for_each(|i| total[i] += push.force[i]);
        }
        for stock in &found.materials {
            (0..3).for_each(|i| total[i] += stock.weight[i]);
        }
        let mut nodal = [0.0; 3];
        for history in 0..body.histories.len() {
            let forces = body.forces_of(history).unwrap();
            forces
                .iter()
                .enumerate()
                .for_each(|(dof, f)| nodal[dof % 3] += f);
        }
        let scale = found
            .pushes
            .iter()
            .flat_map(|p| p.force)
            .fold(1.0, |a: f64, b| a.max(b.abs()));
        for i in 0..3 {
            assert!(
                (total[i] - nodal[i]).abs() < 1e-9 * scale,
                "{scene}: {total:?} {nodal:?}"
            );
        }
    }
}
