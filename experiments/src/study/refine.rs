//! A finer grid of the same scene.

use fracas::scene::{AxisSection, Scene};
use std::num::NonZeroU32;

/// A mesh that no factor refines.
#[derive(Debug, thiserror::Error)]
#[error("`refine` needs a grid, and the mesh of {0} is a file")]
pub(super) struct NoGrid(String);

/// The scene with every cell cut into `factor` parts along each axis: counts times the factor, sizes over it; of cells that grow by g
/// the parts grow by g^(1/factor).
pub(super) fn refined(scene: Scene, factor: NonZeroU32) -> anyhow::Result<Scene> {
    if factor.get() == 1 {
        return Ok(scene);
    }
    let mesh = &scene.sections().mesh;
    if mesh.file.is_some() {
        return Err(NoGrid(scene.title().to_owned()).into());
    }
    let axes = [("x", &mesh.x), ("y", &mesh.y), ("z", &mesh.z)];
    let finer: Vec<String> = (axes.into_iter())
        .flat_map(|(name, axis)| finer(name, axis, factor.get()))
        .collect();
    Ok(scene.with_overrides(&finer)?)
}

fn finer(name: &str, axis: &AxisSection, factor: u32) -> Vec<String> {
    let mut set = Vec::new();
    if let Some(cells) = axis.cells {
        let cells = u64::from(cells.get()) * u64::from(factor);
        set.push(format!("mesh.{name}.cells={cells}"));
    }
    if let Some(size) = &axis.size {
        let size = size.si() / f64::from(factor);
        set.push(format!("mesh.{name}.size={size:?} m"));
    }
    if let Some(growth) = &axis.growth {
        let growth = growth.si().powf(1.0 / f64::from(factor));
        set.push(format!("mesh.{name}.growth={growth:?}"));
    }
    if let Some(lines) = &axis.lines {
        let lines: Vec<f64> = lines.iter().map(|line| line.si()).collect();
        let parts = (lines.windows(2)).flat_map(|ends| {
            let step = (ends[1] - ends[0]) / f64::from(factor);
            (0..factor).map(move |part| ends[0] + f64::from(part) * step)
        });
        let parts: Vec<String> = (parts.chain(lines.last().copied()))
            .map(|line| format!("'{line:?} m'"))
            .collect();
        set.push(format!("mesh.{name}.lines=[{}]", parts.join(", ")));
    }
    set
}

#[cfg(test)]
mod tests {
    use super::*;
    use fracas::scene::named;

    #[test]
    fn every_cell_is_cut() {
        let scene = named("crossing").unwrap().small_scene().unwrap();
        let finer = refined(scene.clone(), NonZeroU32::new(2).unwrap()).unwrap();
        let [coarse, fine] = [scene, finer].map(|s| s.build().unwrap().mesh.elements.len());
        assert_eq!(fine, 8 * coarse);
    }

    #[test]
    fn lines_get_lines_between_them() {
        let lines = toml::from_str("lines = ['0 m', '1 m', '3 m']").unwrap();
        assert_eq!(
            finer("x", &lines, 2),
            ["mesh.x.lines=['0.0 m', '0.5 m', '1.0 m', '2.0 m', '3.0 m']"]
        );
    }
}
