//! Finds Debian's Bullet, compiles the shim in `cpp/` against it, and reads from Bullet's own
//! headers what mustn't be copied by hand.

use std::{env, error::Error, path::Path, path::PathBuf};

const SOURCES: [&str; 22] = [
    "world.cc",
    "shapes.cc",
    "bodies.cc",
    "joints.cc",
    "motors.cc",
    "contacts.cc",
    "snapshot.cc",
    "pausing.cc",
    "collisions.cc",
    "joint_rows.cc",
    "lockstep/structure.cc",
    "lockstep/schedule.cc",
    "lockstep/joint_form.cc",
    "lockstep/gatherer.cc",
    "lockstep/gyroscopic.cc",
    "lockstep/layout.cc",
    "lockstep/world_rows.cc",
    "lockstep/packing.cc",
    "lockstep/plane_pairs.cc",
    "lockstep/cohort.cc",
    "lockstep/alone.cc",
    "lockstep/lockstep.cc",
];
/// Without Bullet's headers, each with its compiler flags; the first holds the choice.
const SWEEPS: [(&str, &[&str]); 3] = [
    ("lockstep/sweep_plain.cc", &[]),
    ("lockstep/sweep_avx2.cc", &["-mavx2"]),
    // GCC 12 warns of its own header's way to leave lanes undefined.
    ("lockstep/sweep_avx512.cc", &["-mavx512f", "-Wno-maybe-uninitialized", "-Wno-uninitialized"]),
];
/// Where the shim's comments on Bullet's inner workings, and its snapshots, were checked.
const BULLET_VERSION: &str = "3.24";

fn main() {
    if let Err(error) = build() {
        // Cargo shows a build script's standard error only if it fails, as it does here.
        eprintln!("\nerror: {error}\n");
        std::process::exit(1);
    }
}

fn build() -> Result<(), Box<dyn Error>> {
    let float64 = env::var_os("CARGO_FEATURE_FLOAT64").is_some();
    let include_paths = find_bullet(float64)?;
    let cpp = Path::new(&env::var("CARGO_MANIFEST_DIR")?).join("../../cpp");

    // The precision is set here and not left to pkg-config's flags, whose defines differ between
    // packagings; state.h and the linker hold headers and library to it.
    let define = float64.then_some("BT_USE_DOUBLE_PRECISION");

    let compile = |build: &mut cc::Build, library: &str| {
        build.std("c++17").opt_level(2).flag("-Wall").flag("-Wextra");
        // No fused multiply-add, whatever -march someone sets: the bits are the same everywhere.
        build.flag("-ffp-contract=off");
        if let Some(define) = define {
            build.define(define, None).define("ITARL_FLOAT64", None);
        }
        build.try_compile(library).map_err(|error| {
            format!(
                "the C++ shim did not compile: {error}\n  A C++17 compiler is needed \
                 (Debian: apt-get install g++)."
            )
        })
    };
    let mut shim = cxx_build::bridge("src/bridge.rs");
    shim.include(&cpp)
        .files(SOURCES.map(|file| cpp.join(file)))
        // How vectors are passed differs between instruction sets, but only joint_rows.cc's own
        // functions pass any.
        .flag("-Wno-psabi")
        // Bullet's headers aren't ours to warn about.
        .flags(include_paths.iter().map(|path| format!("-isystem{}", path.display())));
    compile(&mut shim, "itarl_bullet_shim")?;
    // After the shim, which needs them: the linker looks through libraries in this order.
    let x86_64 = env::var("CARGO_CFG_TARGET_ARCH")? == "x86_64";
    for (file, flags) in SWEEPS.iter().take(if x86_64 { 3 } else { 1 }) {
        let mut sweep = cc::Build::new();
        sweep.cpp(true).include(&cpp).file(cpp.join(file)).flags(*flags);
        compile(&mut sweep, &file.replace("lockstep/", "itarl_").replace(".cc", ""))?;
    }
    println!("cargo::rerun-if-changed={}", cpp.display());
    // bindgen panics where it finds no libclang.
    std::panic::catch_unwind(|| read_headers(&include_paths, define)).unwrap_or_else(|_| {
        Err("libclang was not found (Debian: apt-get install libclang-dev).".into())
    })
}

/// Tells cargo what to link; gives the include paths.
fn find_bullet(float64: bool) -> Result<Vec<PathBuf>, Box<dyn Error>> {
    let package = if float64 { "bullet-float64" } else { "bullet" };
    let library = pkg_config::Config::new()
        .atleast_version(BULLET_VERSION)
        .probe(package)
        .map_err(|error| {
            format!(
                "Bullet {BULLET_VERSION} or newer was not found.\n  Install its development files \
                 (Debian: apt-get install libbullet-dev pkg-config), or run `make test`, which \
                 does.\n  What pkg-config said of {package}:\n{error}"
            )
        })?;
    if library.version != BULLET_VERSION {
        println!(
            "cargo::warning=Bullet {} in place of {BULLET_VERSION}: run the tests, since snapshots \
             depend on its inner workings",
            library.version
        );
    }
    // The compiler's own /usr/include must keep its place behind those of C++.
    let own = |path: &PathBuf| path != Path::new("/usr/include");
    Ok(library.include_paths.into_iter().filter(own).collect())
}

/// Version, solver modes and collision groups, as constants.
fn read_headers(include_paths: &[PathBuf], define: Option<&str>) -> Result<(), Box<dyn Error>> {
    let constants = bindgen::Builder::default()
        .header_contents(
            "constants.hpp",
            "#include <btBulletDynamicsCommon.h>\nconst int SCALAR_BYTES = sizeof(btScalar);",
        )
        .clang_args(["-x", "c++", "-std=c++17"])
        .clang_args(include_paths.iter().map(|path| format!("-I{}", path.display())))
        .clang_args(define.map(|define| format!("-D{define}")))
        .allowlist_var("BT_BULLET_VERSION|SCALAR_BYTES")
        .allowlist_type("btSolverMode|btBroadphaseProxy_CollisionFilterGroups")
        .default_enum_style(bindgen::EnumVariation::Consts)
        .prepend_enum_name(false)
        .generate()
        .map_err(|error| {
            format!(
                "bindgen could not read Bullet's headers: {error}\n  It needs libclang \
                 (Debian: apt-get install libclang-dev)."
            )
        })?;
    constants.write_to_file(Path::new(&env::var("OUT_DIR")?).join("constants.rs"))?;
    Ok(())
}
