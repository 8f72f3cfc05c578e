//! Carries the kernels that `scripts/build-ptx.sh` has made, if it has.

use std::path::Path;
use std::{env, fs};

fn main() {
    let top = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let kernels = top.join("target/ptx/twinrotor.ptx");
    // That script touches this file: one that is not there would be looked for in every build.
    println!("cargo::rerun-if-changed=build.rs");
    let code = if kernels.exists() {
        println!("cargo::rerun-if-changed={}", kernels.display());
        format!("Some(include_str!({kernels:?}))")
    } else {
        "None".to_owned()
    };
    let out = env::var("OUT_DIR").expect("cargo says where to");
    fs::write(Path::new(&out).join("kernels.rs"), code).expect("the build folder can be written");
}
