//! Compiles the C interface against the PETSc and MPI that pkg-config finds.

use std::error::Error;

/// What there is to do where a package is missing.
const INSTALL: &str = "the feature petsc needs PETSc 3.18 or later with real scalars, hypre and MUMPS, and MPI, where pkg-config finds them: apt-get install petsc-dev, or PKG_CONFIG_PATH";

fn main() -> Result<(), Box<dyn Error>> {
    println!("cargo:rerun-if-changed=build.rs");
    for file in ["wrapper.c", "ranks.c", "shared.h"] {
        println!("cargo:rerun-if-changed=src/{file}");
    }
    if std::env::var_os("CARGO_FEATURE_SYSTEM").is_none() {
        return Ok(());
    }
    let mut build = cc::Build::new();
    build.files(["src/wrapper.c", "src/ranks.c"]);
    build.opt_level(2).warnings(true);
    for (names, version) in [(["PETSc", "petsc"], "3.18"), (["mpi-c", "ompi-c"], "0")] {
        let found = names.iter().find_map(|name| {
            pkg_config::Config::new()
                .atleast_version(version)
                .probe(name)
                .ok()
        });
        let Some(library) = found else {
            return Err(format!("pkg-config does not know {}; {INSTALL}", names[0]).into());
        };
        // system folders of headers: their warnings are not ours
        for folder in library.include_paths {
            build
                .flag("-isystem")
                .flag(folder.to_string_lossy().as_ref());
        }
    }
    build.try_compile("fracas_petsc")?;
    Ok(())
}
