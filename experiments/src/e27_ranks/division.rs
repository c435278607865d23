//! What ranks have and what they ask of each other: a body divided by METIS.

use fracas::elasticity::Constraints;
use fracas::mesh::node_graph;
use fracas::scene::Body;
use fracas_solvers::SetupError;
use fracas_solvers::direct::partition;

/// A body in parts.
pub(super) struct Division {
    /// How many.
    pub(super) parts: usize,
    /// Nodes with a free displacement.
    pub(super) nodes: usize,
    /// Such nodes of the largest part.
    pub(super) most: usize,
    /// Nodes of other parts that rows of A and B of a part name, of the part with the most.
    pub(super) ghosts: usize,
    /// Parts that have them, of the part with the most.
    pub(super) neighbours: usize,
}

impl Division {
    /// Nodes of all parts in equal shares.
    pub(super) fn share(&self) -> f64 {
        self.nodes as f64 / self.parts as f64
    }

    /// Ghosts over those of a cube of as many nodes. Unit: 1.
    pub(super) fn over_cube(&self) -> f64 {
        self.ghosts as f64 / shell(self.share())
    }
}

/// Nodes around a cube of so many, one layer thick: a surface of a volume.
pub(super) fn shell(nodes: f64) -> f64 {
    (nodes.cbrt() + 2.0).powi(3) - nodes
}

/// Divides the nodes as ranks do.
///
/// # Errors
/// Those of [`partition`].
pub(super) fn divide(body: &Body, parts: usize) -> Result<Division, SetupError> {
    let mesh = &body.mesh;
    let (number, nodes) = body.constraints.free_nodes();
    let numbered = |node: u32| Some(number[node as usize]).filter(|n| *n != Constraints::NO_NUMBER);
    let (offsets, around) = node_graph(mesh, &body.fractures, nodes, numbered);
    let part = partition(&offsets, &around, parts)?;
    let mut own = vec![0; parts];
    part.iter().for_each(|p| own[*p as usize] += 1);
    // rows name the nodes of all elements around a node, and of the faces that it is pushed by
    let mut asked: Vec<(u32, u32)> = Vec::new();
    let mut meet = |nodes: &[u32]| {
        let nodes = || nodes.iter().filter_map(|node| numbered(*node));
        for a in nodes() {
            let rank = part[a as usize];
            let others = nodes().filter(|b| part[*b as usize] != rank);
            asked.extend(others.map(|b| (rank, b)));
        }
    };
    mesh.elements.iter().for_each(|element| meet(element));
    for face in &body.fractures.faces {
        let [minus, plus] = [face.minus.nodes, face.plus.nodes];
        meet(&[minus, plus].concat());
    }
    asked.sort_unstable();
    asked.dedup();
    let mut ghosts = vec![0; parts];
    let mut from: Vec<(u32, u32)> = Vec::new();
    for (rank, node) in asked {
        ghosts[rank as usize] += 1;
        from.push((rank, part[node as usize]));
    }
    from.sort_unstable();
    from.dedup();
    let mut neighbours = vec![0; parts];
    from.iter()
        .for_each(|(rank, _)| neighbours[*rank as usize] += 1);
    let largest = |of: &[usize]| of.iter().copied().max().unwrap_or(0);
    Ok(Division {
        parts,
        nodes,
        most: largest(&own),
        ghosts: largest(&ghosts),
        neighbours: largest(&neighbours),
    })
}

#[cfg(test)]
mod tests {
    use super::*;
    use fracas::scene::named;

    /// A slab one cell wide in y and z that is cut across: each side reads the four nodes beyond, and with more parts those in the middle
    /// read eight.
    #[test]
    fn a_bar_reads_the_nodes_beyond_its_cuts() {
        let bar = "title = 'bar'\n[mesh]\nx = { from = '0 m', to = '32 m', cells = 32 }\n\
                   y = { from = '0 m', to = '1 m', cells = 1 }\nz = { from = '0 m', to = '1 m', cells = 1 }\n\
                   [[material]]\nname = 'rock'\nyoung = '1 GPa'\npoisson = 0.25\n\
                   [[boundary]]\nside = 'x-'\nhold = 'fixed'\n";
        let bar = fracas::scene::Scene::from_toml(bar, "bar.toml").unwrap();
        let bar = bar.build().unwrap();
        let [one, two, four] = [1, 2, 4].map(|parts| divide(&bar, parts).unwrap());
        assert_eq!(one.nodes, 4 * 32);
        assert_eq!([one.ghosts, one.neighbours], [0, 0]);
        assert_eq!([two.ghosts, two.neighbours], [4, 1]);
        assert_eq!([four.ghosts, four.neighbours], [8, 2]);
    }

    /// A part has no fewer ghosts than one side of a cube of as many nodes, and not twice those of a whole one.
    #[test]
    fn parts_of_a_body_are_compact() {
        let body = named("layered_crossing").unwrap().scene().unwrap();
        let body = body.build().unwrap();
        for parts in [2, 8, 16] {
            let division = divide(&body, parts).unwrap();
            let over = division.over_cube();
            assert!((0.125..2.0).contains(&over), "{parts}: {over}");
            let even = division.most as f64 / division.share();
            assert!((1.0..1.1).contains(&even), "{parts}: {even}");
        }
    }
}
