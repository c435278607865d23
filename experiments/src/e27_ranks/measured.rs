//! Solves on the ranks of `mpirun`, each a process of its own, with what they say of their time and memory.

use serde_json::Value;
use std::path::{Path, PathBuf};
use std::process::Command;

/// The scene, on `cells` cells per axis.
pub(super) const SCENE: &str = "layered_crossing";

/// Who solves.
#[derive(Clone, Copy, PartialEq, Eq)]
pub(super) enum Who {
    /// So many ranks, one thread each.
    Ranks(usize),
    /// One process with so many threads.
    Threads(usize),
}

impl Who {
    /// As in a table.
    pub(super) fn name(self) -> String {
        match self {
            Self::Ranks(1) => "1 rank".into(),
            Self::Ranks(n) => format!("{n} ranks"),
            Self::Threads(n) => format!("one process, {n} threads"),
        }
    }
}

/// One solve.
pub(super) struct Run {
    pub(super) who: Who,
    pub(super) n_u: usize,
    pub(super) n_t: usize,
    pub(super) iterations: usize,
    /// Displacements of other ranks that a rank reads, of the one with the most.
    pub(super) ghosts: Option<usize>,
    /// Of the rank with the most [bytes].
    pub(super) peak: f64,
    /// Of the rows of A [s].
    pub(super) assembly: Option<f64>,
    /// [s].
    pub(super) setup: f64,
    /// [s].
    pub(super) solve: f64,
    pub(super) times: Option<Times>,
}

/// Parts of an iteration [s].
#[derive(Clone, Copy)]
pub(super) struct Times {
    pub(super) product: f64,
    pub(super) inverse: f64,
    /// Over all ranks.
    pub(super) sum: f64,
    pub(super) message: f64,
    pub(super) per_byte: f64,
}

impl Run {
    /// Assembly, set-up and iterations [s].
    pub(super) fn whole(&self) -> f64 {
        self.assembly.unwrap_or(0.0) + self.setup + self.solve
    }

    /// An iteration [s].
    pub(super) fn per_iteration(&self) -> f64 {
        self.solve / self.iterations.max(1) as f64
    }
}

/// The program that can solve over ranks, or why there is none.
pub(super) fn program() -> Result<PathBuf, String> {
    if !cfg!(feature = "petsc") {
        return Err("this build has no PETSc (compile with --features petsc)".into());
    }
    let program = std::env::current_exe().map_err(|e| e.to_string())?;
    let is_fracas = program.file_stem().is_some_and(|name| name == "fracas");
    if !is_fracas {
        return Err(format!("{} is not fracas", program.display()));
    }
    match Command::new("mpirun").arg("--version").output() {
        Ok(output) if output.status.success() => Ok(program),
        _ => Err("there is no mpirun".into()),
    }
}

/// Solves with GAMG inside, in processes of their own.
///
/// # Errors
/// What keeps a solve from its end, in the words of the program.
pub(super) fn solve(program: &Path, who: Who, cells: usize) -> anyhow::Result<Run> {
    let mut command = match who {
        Who::Ranks(ranks) => {
            let mut command = Command::new("mpirun");
            command.args(["-n", &ranks.to_string()]).arg(program);
            command
        }
        Who::Threads(_) => Command::new(program),
    };
    // more ranks than cores, as root in a container; other MPIs do not read these
    command.env("OMPI_MCA_rmaps_base_oversubscribe", "1");
    command.env("OMPI_MCA_hwloc_base_binding_policy", "none");
    command.env("OMPI_ALLOW_RUN_AS_ROOT", "1");
    command.env("OMPI_ALLOW_RUN_AS_ROOT_CONFIRM", "1");
    // PETSc's BLAS would take threads of its own
    command.env("OPENBLAS_NUM_THREADS", "1");
    command.args(["solve", SCENE, "--inner", "gamg", "--json", "-"]);
    for axis in ["x", "y", "z"] {
        command.args(["--set", &format!("mesh.{axis}.cells={cells}")]);
    }
    match who {
        Who::Ranks(_) => command.args(["--engine", "petsc", "--explain"]),
        Who::Threads(threads) => command.args(["--threads", &threads.to_string()]),
    };
    let output = command.output()?;
    let said = String::from_utf8_lossy(&output.stderr);
    anyhow::ensure!(
        output.status.success(),
        "{} on {cells} cells: {}",
        who.name(),
        said.trim()
    );
    let report: Value = serde_json::from_slice(&output.stdout)?;
    let number = |value: &Value, key: &str| {
        let number = value[key].as_f64();
        number.ok_or_else(|| anyhow::anyhow!("the report of {} has no {key}", who.name()))
    };
    let engine = &report["engine"];
    let peak = match engine["peak_memory_bytes"].as_array() {
        Some(all) => all.iter().filter_map(Value::as_f64).fold(0.0, f64::max),
        None => number(&report, "peak_memory_bytes")?,
    };
    let ghosts = engine["ghosts"].as_array();
    let ghosts = ghosts.and_then(|all| all.iter().filter_map(Value::as_u64).max());
    let times = &engine["times"];
    let times = match times.is_object() {
        true => Some(Times {
            product: number(times, "product_s")?,
            inverse: number(times, "application_s")?,
            sum: number(times, "sum_s")?,
            message: number(times, "message_s")?,
            per_byte: number(times, "per_byte_s")?,
        }),
        false => None,
    };
    Ok(Run {
        who,
        n_u: number(&report, "n_u")? as usize,
        n_t: number(&report, "n_t")? as usize,
        iterations: number(&report, "iterations")? as usize,
        ghosts: ghosts.map(|n| n as usize),
        peak,
        assembly: engine["assembly_s"].as_f64(),
        setup: number(&report, "setup_s")?,
        solve: number(&report, "solve_s")?,
        times,
    })
}
