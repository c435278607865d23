//! Claim: patches of fracture faces are what a search over shared nodes finds.

use fracas::scene::named;
use fracas_operators::random::Random;

/// Two taken faces are of one patch where a way over shared edges of taken faces of their fracture joins them, and nowhere else.
#[test]
fn patches_are_what_a_search_over_nodes_finds() {
    let body = named("crossing").unwrap().small_scene().unwrap();
    let body = body.build().unwrap();
    let fractures = &body.fractures;
    let n = fractures.faces.len();
    // copies of a node lie in one place
    let corner = |f: usize| -> Vec<[i64; 3]> {
        let nodes = fractures.faces[f].minus.nodes;
        let place = nodes.map(|a| body.mesh.nodes[a as usize]);
        place.map(|x| x.map(|x| (1e6 * x).round() as i64)).to_vec()
    };
    let corners: Vec<Vec<[i64; 3]>> = (0..n).map(corner).collect();
    let beside = |a: usize, b: usize| {
        let shared = corners[a].iter().filter(|x| corners[b].contains(x));
        fractures.faces[a].fracture == fractures.faces[b].fracture && shared.count() == 2
    };
    let mut random = Random::new(5);
    for round in 0..30 {
        let share = random.between(0.2, 1.0);
        let taken: Vec<bool> = (0..n).map(|_| random.chance(share)).collect();
        let patches = fractures.patches(|f| taken[f]);
        let mut seen = vec![false; n];
        let mut expected = Vec::new();
        for first in (0..n).filter(|f| taken[*f]) {
            if seen[first] {
                continue;
            }
            let (mut patch, mut at) = (vec![first], 0);
            seen[first] = true;
            while at < patch.len() {
                for f in 0..n {
                    if taken[f] && !seen[f] && beside(patch[at], f) {
                        seen[f] = true;
                        patch.push(f);
                    }
                }
                at += 1;
            }
            patch.sort_unstable();
            expected.push(patch);
        }
        assert_eq!(patches, expected, "round {round}");
        let area: f64 = patches
            .iter()
            .map(|p| fractures.area_of(p.iter().copied()))
            .sum();
        let whole = fractures.area_of((0..n).filter(|f| taken[*f]));
        assert!((area - whole).abs() <= 1e-12 * whole);
    }
}
