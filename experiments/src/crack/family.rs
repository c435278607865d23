//! Sequences of meshes around a crack.

use anyhow::Context;
use fracas::scene::{Body, named};

/// A scene of the gallery with a crack in the middle of its mesh.
#[derive(Clone, Copy, Debug)]
pub struct CrackScene {
    /// Name in the gallery.
    pub name: &'static str,
    /// Axes along the crack, those in which it has tips.
    along: &'static [&'static str],
    /// Axis across it.
    across: &'static str,
    /// Half-length along those axes before the map of the mesh [m].
    tip: f64,
}

/// cos 20°: a crack of 2 m at 20° to z spans ± this in z [m].
const COS_20_DEG: f64 = 0.939_692_620_785_908_4;

/// The inclined crack.
pub const INCLINED: CrackScene = CrackScene {
    name: "inclined_crack",
    along: &["z"],
    across: "x",
    tip: COS_20_DEG,
};

/// The line crack.
pub const LINE: CrackScene = CrackScene {
    name: "line_crack",
    along: &["x"],
    across: "z",
    tip: 1.0,
};

/// The penny crack.
pub const PENNY: CrackScene = CrackScene {
    name: "penny_crack",
    along: &["x", "y"],
    across: "z",
    tip: 1.0,
};

/// Residual relative to the loads: the load on the sides is a hundred times that on the crack, and tables show six digits.
const TOLERANCE: f64 = 1e-10;

/// How a sequence refines.
#[derive(Clone, Copy, Debug, PartialEq)]
pub enum Family {
    /// n equal faces along the crack; cells grow by 1 + 4/n away from it.
    Uniform(usize),
    /// Cells of s²/2 at the tips, growing by the factor e^s away from them: a tip of singularity √r is resolved as well as
    /// the rest when the smallest cell goes with the square of the others.
    Graded(f64),
}

impl Family {
    /// Its name in tables.
    pub fn name(self) -> &'static str {
        match self {
            Self::Uniform(_) => "uniform",
            Self::Graded(_) => "graded",
        }
    }
}

impl CrackScene {
    /// The body on a mesh of a family.
    ///
    /// # Errors
    /// A mesh that cannot be made.
    pub fn body(&self, family: Family) -> anyhow::Result<Body> {
        let scene = named(self.name).with_context(|| format!("no scene {}", self.name))?;
        let (size, growth) = match family {
            Family::Uniform(n) => (2.0 * self.tip / n as f64, 1.0 + 4.0 / n as f64),
            Family::Graded(s) => (0.5 * s * s, s.exp()),
        };
        let mut sets = vec![
            format!("solver.tolerance={TOLERANCE:e}"),
            "solver.measure=residual".to_owned(),
        ];
        for axis in self.along.iter().chain([&self.across]) {
            sets.push(format!("mesh.{axis}.size={size} m"));
            sets.push(format!("mesh.{axis}.growth={growth}"));
        }
        if let Family::Uniform(_) = family {
            for axis in self.along {
                sets.push(format!(
                    "mesh.{axis}.fine=['-{tip} m', '{tip} m']",
                    tip = self.tip
                ));
            }
        }
        Ok(scene.scene()?.with_overrides(&sets)?.build()?)
    }
}
