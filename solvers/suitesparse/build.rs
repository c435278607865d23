//! Compiles the parts of SuiteSparse 7.7.0 that one symmetric and one unsymmetric solver need, with a C compiler alone.

use std::error::Error;
use std::path::{Path, PathBuf};
use std::process::Command;

/// Registry package that contains the sources; pinned by Cargo.lock.
const PACKAGE: &str = "suitesparse_sys";

/// Folder of the sources, as `cargo metadata` knows it; it downloads the package if it is missing.
fn sources() -> Result<PathBuf, Box<dyn Error>> {
    let manifest = Path::new(&std::env::var("CARGO_MANIFEST_DIR")?).join("Cargo.toml");
    let output = Command::new(std::env::var("CARGO")?)
        .args([
            "metadata",
            "--format-version",
            "1",
            "--locked",
            "--manifest-path",
        ])
        .arg(manifest)
        .output()?;
    if !output.status.success() {
        return Err(String::from_utf8_lossy(&output.stderr).into());
    }
    let metadata: serde_json::Value = serde_json::from_slice(&output.stdout)?;
    let package = metadata["packages"]
        .as_array()
        .and_then(|packages| packages.iter().find(|p| p["name"] == PACKAGE))
        .and_then(|package| package["manifest_path"].as_str())
        .ok_or("cargo metadata does not list suitesparse_sys")?;
    Ok(Path::new(package).with_file_name("vendor"))
}

/// C files of a folder whose names begin with a prefix and contain none of `without`, in alphabetical order.
fn files(folder: &Path, prefix: &str, without: &[&str]) -> Result<Vec<PathBuf>, Box<dyn Error>> {
    let mut files = Vec::new();
    for entry in std::fs::read_dir(folder)? {
        let path = entry?.path();
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        if name.starts_with(prefix)
            && name.ends_with(".c")
            && !without.iter().any(|part| name.contains(part))
        {
            files.push(path);
        }
    }
    files.sort();
    Ok(files)
}

fn main() -> Result<(), Box<dyn Error>> {
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-changed=src/wrapper.c");
    if cfg!(clippy) {
        // lints link nothing, and cargo runs the script of a member of the workspace for them once more
        return Ok(());
    }
    let root = sources()?;
    let cholmod = root.join("CHOLMOD");
    let umfpack = root.join("UMFPACK");
    let mut build = cc::Build::new();
    for folder in [
        "SuiteSparse_config",
        "AMD/Include",
        "AMD/Source",
        "COLAMD/Include",
        "CHOLMOD",
        "CHOLMOD/Include",
        "UMFPACK/Include",
        "UMFPACK/Source",
    ] {
        build.include(root.join(folder));
    }
    build
        .file("src/wrapper.c")
        .file(root.join("SuiteSparse_config/SuiteSparse_config.c"))
        .file(root.join("COLAMD/Source/colamd_l.c"))
        .file(cholmod.join("Utility/cholmod_mult_uint64_t.c"))
        .files(files(&root.join("AMD/Source"), "amd_l", &[])?);
    for module in ["Cholesky", "Utility", "Supernodal"] {
        build.files(files(&cholmod.join(module), "cholmod_l_", &[])?);
    }
    // interfaces that read, write or print
    let unused = [
        "report",
        "save",
        "load",
        "serialize",
        "copy",
        "triplet_to",
        "to_triplet",
    ];
    let source2 = umfpack.join("Source2");
    build
        .file(umfpack.join("Source/umfpack_tictoc.c"))
        .files(files(&source2, "umf_l_", &[])?)
        .files(files(&source2, "umf_dl_", &[])?)
        .files(files(&source2, "umfpack_dl_", &unused)?);
    // 64-bit indices, 32-bit BLAS integers, our BLAS symbols; orderings come from outside
    for define in [
        "NDEBUG",
        "BLAS32",
        "NTIMER",
        "NPARTITION",
        "NCAMD",
        "NMODIFY",
        "NMATRIXOPS",
        "NCHECK",
        "NCHOLMOD",
    ] {
        build.define(define, None);
    }
    build
        .define("BLAS64__SUFFIX", "_ffm")
        .opt_level(3)
        .warnings(false)
        .try_compile("fracas_suitesparse")?;
    Ok(())
}
