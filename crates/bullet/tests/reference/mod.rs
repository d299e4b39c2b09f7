//! Compiles the C++ programs of this directory. They know Bullet's own API and nothing of the
//! crate or its shim: what the crate is measured against.

use std::{
    path::{Path, PathBuf},
    process::Command,
};

/// Compiles `source` against Bullet's headers of one precision and its libraries of another, both
/// told in bytes of a `btScalar`. Gives the program, or what pkg-config or the compiler said.
pub(crate) fn compile(source: &str, headers: usize, libraries: usize) -> Result<PathBuf, String> {
    let directory = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/reference");
    let program = Path::new(env!("CARGO_TARGET_TMPDIR")).join(format!(
        "{source}-{}-{}",
        8 * headers,
        8 * libraries
    ));
    // -O2 without fused multiply-add is how the shim is compiled.
    let mut compiler = Command::new("c++");
    compiler
        .args(["-std=c++17", "-O2", "-ffp-contract=off", "-o"])
        .arg(&program)
        .args(pkg_config("--cflags", headers)?)
        .arg(directory.join(source))
        .args(pkg_config("--libs", libraries)?);
    run(&mut compiler).map(|_| program)
}

fn pkg_config(what: &str, scalar_bytes: usize) -> Result<Vec<String>, String> {
    let package = if scalar_bytes == 8 { "bullet-float64" } else { "bullet" };
    let flags = run(Command::new("pkg-config").args([what, package]))?;
    Ok(flags.split_whitespace().map(str::to_owned).collect())
}

fn run(command: &mut Command) -> Result<String, String> {
    // Messages in English: a test reads one.
    let output =
        command.env("LC_ALL", "C").output().map_err(|error| format!("{command:?}: {error}"))?;
    if output.status.success() {
        Ok(String::from_utf8_lossy(&output.stdout).into_owned())
    } else {
        let said = String::from_utf8_lossy(&output.stderr);
        Err(format!("{command:?}: {}\n{said}", output.status))
    }
}
