//! Matrices that rows share: assembled once, kept for the rows behind.

use super::product::Case;
use super::refine::refined;
use super::state::{Laboratory, Linearized};
use crate::scenes;
use fracas::memory;
use fracas::scene::{Body, Scene};
use fracas::solve::{Problem, StuckBody};
use fracas_solvers::Silent;
use fracas_solvers::direct::DirectChoice;
use fracas_solvers::saddle::{AugmentationChoice, Measure, SaddleBlocks};
use fracas_solvers::spectrum::condition::{
    Ends, StiffnessEnds, scaled_schur_ends, schur_ends, stiffness_ends,
};
use std::sync::Arc;
use std::time::Instant;

/// The system of a row.
pub(super) struct Prepared {
    case: Case,
    /// Tractions are in the unit of the system.
    raw: bool,
    /// Of a scene.
    pub(super) body: Option<(Arc<Body>, StuckBody)>,
    /// In a balanced unit of tractions, unless eigenvalues are asked for, too, or residuals of another code are compared.
    pub(super) blocks: Arc<SaddleBlocks>,
    /// Newton's method for a contact state, without its blocks.
    pub(super) state: Option<Linearized>,
    pub(super) mesh_s: f64,
    pub(super) assembly_s: f64,
    /// Of a scene, or exported by fracas.
    pub(super) is_ours: bool,
    /// Tractions may be counted in another unit.
    is_free: bool,
    /// Of tractions in these blocks [Pa].
    unit: f64,
    stiffness: Option<StiffnessEnds>,
    schur: Option<(AugmentationChoice, [Option<Ends>; 2])>,
}

impl Case {
    /// Reads what is solved; nothing is meshed.
    pub(super) fn problem(&self) -> anyhow::Result<Problem> {
        let Some(stuck) = self.stuck()? else {
            let folder = self.setting.system.clone().unwrap_or_default();
            return Ok(Problem::Folder(folder.into()));
        };
        Ok(Problem::Body(stuck))
    }

    /// The scene with its keys, refined.
    pub(super) fn scene(&self) -> anyhow::Result<Option<Scene>> {
        let Some(name) = &self.setting.scene else {
            return Ok(None);
        };
        let set = self.setting.set.iter();
        let set: Vec<String> = set.map(|(key, value)| format!("{key}={value}")).collect();
        let scene = scenes::load(name)?.with_overrides(&set)?;
        Ok(Some(match self.setting.refine {
            Some(factor) => refined(scene, factor)?,
            None => scene,
        }))
    }

    pub(super) fn stuck(&self) -> anyhow::Result<Option<StuckBody>> {
        let (Some(name), Some(scene)) = (&self.setting.scene, self.scene()?) else {
            return Ok(None);
        };
        let mut stuck = StuckBody::of_scene(name, scene);
        stuck.stabilization = self.setting.stabilization.unwrap_or(1.0);
        Ok(Some(stuck))
    }
}

impl Prepared {
    /// Meshes and assembles.
    ///
    /// # Errors
    /// As the scene or the folder; a state that Newton's method cannot reach.
    pub(super) fn new(case: &Case, raw: bool, measure: Measure) -> anyhow::Result<Self> {
        let start = Instant::now();
        let mut prepared = match case.stuck()? {
            None => {
                let loaded = case.problem()?.load(&mut Silent)?;
                let has_flow = loaded.blocks.flow.is_some();
                Self {
                    case: case.clone(),
                    raw,
                    body: None,
                    blocks: loaded.blocks,
                    state: None,
                    mesh_s: 0.0,
                    assembly_s: start.elapsed().as_secs_f64(),
                    is_ours: loaded.is_ours,
                    is_free: loaded.is_ours || measure == Measure::Error && !has_flow,
                    unit: 1.0,
                    stiffness: None,
                    schur: None,
                }
            }
            Some(stuck) => {
                let body = stuck.mesh(memory::BLOCKS, &mut Silent)?;
                let mesh_s = start.elapsed().as_secs_f64();
                let start = Instant::now();
                let h = stuck.stabilization(&body);
                let (blocks, state) = match case.setting.state {
                    None => (body.saddle_blocks(h)?, None),
                    Some(state) => {
                        let linearized = Laboratory::new(&body, h)?.linearize(state)?;
                        (linearized.blocks.clone(), Some(linearized))
                    }
                };
                Self {
                    case: case.clone(),
                    raw,
                    body: Some((body, stuck)),
                    blocks: blocks.into(),
                    is_ours: true,
                    is_free: state.is_none(),
                    state,
                    mesh_s,
                    assembly_s: start.elapsed().as_secs_f64(),
                    unit: 1.0,
                    stiffness: None,
                    schur: None,
                }
            }
        };
        if !raw {
            let (blocks, unit) = prepared.balanced();
            (prepared.blocks, prepared.unit, prepared.is_free) = (blocks, unit, false);
        }
        Ok(prepared)
    }

    /// True where it serves this row, too.
    pub(super) fn serves(&self, case: &Case, raw: bool) -> bool {
        self.raw == raw && self.case.same_matrices(case)
    }

    /// The blocks in a balanced unit of tractions where that is free, and this unit [Pa].
    pub(super) fn balanced(&self) -> (Arc<SaddleBlocks>, f64) {
        let unit = self.blocks.traction_unit();
        match self.is_free {
            true => (self.blocks.in_traction_unit(unit).into(), unit),
            false => (self.blocks.clone(), self.unit),
        }
    }

    /// Both ends of the spectrum of A.
    pub(super) fn stiffness(&mut self) -> anyhow::Result<StiffnessEnds> {
        if let Some(known) = self.stiffness {
            return Ok(known);
        }
        let direct = DirectChoice::Auto.solver()?;
        Ok(*self
            .stiffness
            .insert(stiffness_ends(&self.blocks, &*direct)?))
    }

    /// Both ends of the spectrum of S_u, and of S_u after scaling to a unit diagonal, as asked for.
    pub(super) fn schur(
        &mut self,
        c: AugmentationChoice,
        wanted: [bool; 2],
    ) -> anyhow::Result<[Option<Ends>; 2]> {
        let known = self.schur.filter(|(known, _)| *known == c);
        let mut ends = known.map_or([None; 2], |(_, ends)| ends);
        let lacks = |k: usize| wanted[k] && ends[k].is_none();
        let missing = [0, 1].map(lacks);
        if missing.contains(&true) {
            let direct = DirectChoice::Auto.solver()?;
            let matrix = c.compute(&self.blocks, &*direct)?.matrix;
            let of = [schur_ends, scaled_schur_ends];
            for k in (0..2).filter(|k| missing[*k]) {
                ends[k] = Some(of[k](&self.blocks, &matrix, None, &*direct)?);
            }
            self.schur = Some((c, ends));
        }
        let asked = |k: usize| ends[k].filter(|_| wanted[k]);
        Ok([0, 1].map(asked))
    }
}
