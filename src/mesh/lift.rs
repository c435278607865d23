//! Levels of a grid that become surfaces.

use super::{MeshError, Relief, Warp, WarpContext};

/// Nodes move along z: those of a level lie on its surface afterwards, those between two levels keep their share of the distance,
/// ```text
/// z ← Z_j + (z − z_j) (Z_{j+1} − Z_j) / (z_{j+1} − z_j)        Z_j: height of the surface of level z_j over (x, y)
/// ```
/// and those below the lowest or above the highest level move along with it. Faces across x and y stay in their planes.
#[derive(Clone, Debug, PartialEq)]
pub struct Lift {
    /// Levels [m], increasing, and their surfaces.
    pub levels: Vec<(f64, Relief)>,
}

impl Lift {
    /// Height of a point after the map [m], and the levels around it with their heights where they do not go up.
    fn height(&self, [x, y, z]: [f64; 3]) -> Result<f64, [f64; 4]> {
        let at = |j: usize| (self.levels[j].0, self.levels[j].1.at([x, y]));
        let last = self.levels.len() - 1;
        let above = self.levels.partition_point(|(level, _)| *level <= z);
        let below = above.saturating_sub(1);
        let (level, height) = at(below);
        if level == z || above == 0 || above > last {
            return Ok(z - level + height);
        }
        let (next, top) = at(above);
        match top > height {
            true => Ok(height + (z - level) * ((top - height) / (next - level))),
            false => Err([level, next, height, top]),
        }
    }
}

impl Warp for Lift {
    fn advice(&self) -> &'static str {
        "make the surfaces of `lift` less steep, or move them apart"
    }

    fn apply(&self, nodes: &mut [[f64; 3]], _: &WarpContext) -> Result<(), MeshError> {
        let increase = |pair: &[(f64, Relief)]| pair[0].0 < pair[1].0;
        if self.levels.is_empty() || !self.levels.windows(2).all(increase) {
            let first = self.levels.first().map_or(f64::NAN, |(level, _)| *level);
            return Err(MeshError::BadWarp {
                map: "lift",
                parameter: "level",
                value: first,
                requirement: "one of several that increase",
            });
        }
        for node in nodes {
            node[2] = self.height(*node).map_err(|[lower, upper, low, high]| {
                MeshError::SurfacesMeet {
                    levels: [lower, upper],
                    at: [node[0], node[1]],
                    heights: [low, high],
                }
            })?;
        }
        Ok(())
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::mesh::{BoxGrid, MeshError};

    fn slope(low: f64, high: f64) -> Relief {
        Relief::new([vec![0.0, 4.0], vec![0.0]], vec![low, high])
    }

    fn built(levels: Vec<(f64, Relief)>) -> Result<Vec<[f64; 3]>, MeshError> {
        let mut grid = BoxGrid::uniform([0.0; 3], [4.0, 1.0, 4.0], [4, 1, 4]);
        grid.warps.push(Box::new(Lift { levels }));
        grid.build().map(|built| built.mesh.nodes)
    }

    #[test]
    fn levels_become_surfaces_and_the_rest_keeps_its_share() {
        let levels = vec![(1.0, Relief::level(1.5)), (3.0, slope(2.0, 3.5))];
        for [x, _, z] in built(levels).unwrap() {
            let top = 2.0 + 1.5 * x / 4.0;
            // lines that were at 0, 1, 2, 3 and 4
            let lines = [0.5, 1.5, 0.5 * (1.5 + top), top, top + 1.0];
            assert!(lines.iter().any(|line| (line - z).abs() < 1e-14), "{x} {z}");
        }
    }

    #[test]
    fn surfaces_that_meet_are_refused_with_the_place() {
        let error = built(vec![(1.0, Relief::level(2.0)), (3.0, slope(4.0, 2.0))]);
        assert_eq!(
            error.unwrap_err().to_string(),
            "map lift: the levels z = 1 m and z = 3 m would lie at 2 m and 2 m at x = 4 m, y = 0 m; the upper one has to stay above the lower one"
        );
        let error = built(vec![(1.0, Relief::level(2.0)), (1.0, Relief::level(3.0))]);
        assert!(
            error
                .unwrap_err()
                .to_string()
                .contains("several that increase")
        );
    }
}
