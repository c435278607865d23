//! A scene without an assembled A: RACP around geometric multigrid.

use super::iteration::{Built, Names};
use super::precision::Double;
use super::{Inner, Solve, Status, memory};
use crate::command::progress::Progress;
use anyhow::Context;
use fracas::matrix_free::{MatrixFreeError, MatrixFreeSystem, RacpParts};
use fracas_solvers::saddle::{Racp, SaddleBlocks, T, U};
use std::io::Write;
use std::time::Instant;

impl Solve {
    /// Nothing is assembled but H, C and the coarse levels.
    pub(super) fn matrix_free(
        &self,
        scene: &str,
        racp: Racp,
        mut inner: Inner,
        mut progress: Progress,
        out: &mut dyn Write,
    ) -> anyhow::Result<Status> {
        let assembly = self.source.assembly();
        let body = assembly.mesh(scene, memory::MATRIX_FREE, &mut progress)?;
        let context = || format!("{scene} cannot be solved");
        let system = body.stick_system(assembly.stabilization(&body));
        let force = body.forces().with_context(context)?;
        let equations = MatrixFreeSystem::new(&system, self.traction_unit).with_context(context)?;
        let saddle = &equations.saddle;
        let unit = saddle.unit();
        let own = saddle.rhs(&system, &force);
        drop(force);
        let [n_u, n_t] = [U, T].map(|field| saddle.layout().length(field));
        progress.say(&format!("n_u = {n_u}, n_t = {n_t}, n_p = 0"));
        let has_rhs = own.iter().any(|b| *b != 0.0);
        let (rhs, b) = self.right_hand_side(has_rhs, own, &mut progress);

        let start = Instant::now();
        progress.say("setting up");
        let RacpParts {
            inverse,
            hierarchy,
            lost,
            ..
        } = match RacpParts::new(&racp, saddle, &system, &mut progress) {
            Ok(ready) => ready,
            Err(error @ MatrixFreeError::Stopped) => return Err(error.into()),
            Err(error) => {
                let method = inner.instead(error.into(), &mut progress)?;
                return self.by(method, inner, progress, out);
            }
        };
        let fallbacks = usize::from(lost.is_some());
        let mut findings = inner.findings;
        if let Some(lost) = lost {
            let found = format!("precision: {lost}; the hierarchy is in f64");
            progress.say(&found);
            findings.push(found);
        }
        // the operators carry what they need: the mesh has done its work
        drop(body);
        let in_double = |progress: &mut Progress| -> anyhow::Result<Double> {
            // the body was given back: it is made again
            let body = assembly.mesh(scene, memory::MATRIX_FREE, progress)?;
            let system = body.stick_system(assembly.stabilization(&body));
            let racp = racp.in_double();
            let ready = RacpParts::new(&racp, saddle, &system, progress)?;
            Ok(Double {
                preconditioner: Box::new(ready.inverse),
                hierarchy: Some(ready.hierarchy),
                inner: racp.inner.to_string(),
            })
        };
        let in_entries = |progress: &mut Progress| -> anyhow::Result<SaddleBlocks> {
            let system = assembly.assemble(scene, progress)?;
            Ok(system.blocks.into_traction_unit(unit))
        };
        let setup_s = start.elapsed().as_secs_f64();
        self.iterate(
            &Built {
                equations: &equations,
                preconditioner: &inverse,
                hierarchy: Some(hierarchy),
                names: Names {
                    method: "racp".into(),
                    augmentation: Some(racp.augmentation.to_string()),
                    inner: Some(match lost {
                        None => racp.inner.to_string(),
                        Some(_) => racp.in_double().inner.to_string(),
                    }),
                    relaxation: inverse.relaxation(),
                },
                rhs,
                b: &b,
                unit,
                setup_s,
                findings,
                explain: None,
                fallbacks,
                inner_fallbacks: inner.fallbacks,
                in_double: Some(Box::new(in_double)),
                in_entries: Some(Box::new(in_entries)),
            },
            progress,
            out,
        )
    }
}
