//! Compiles how METIS reports errors: without the signals of GKlib.

use std::error::Error;

fn main() -> Result<(), Box<dyn Error>> {
    let source = "src/direct/metis_errors.c";
    println!("cargo:rerun-if-changed=build.rs");
    println!("cargo:rerun-if-changed={source}");
    let mut build = cc::Build::new();
    if std::env::var("CARGO_CFG_TARGET_ENV").as_deref() == Ok("msvc") {
        build.define("__thread", "__declspec(thread)");
    }
    build.file(source).try_compile("fracas_metis_errors")?;
    Ok(())
}
