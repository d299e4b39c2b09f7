//! What an import costs, from a file to a model's text, of each robot in tests/robots; and of those in
//! the folder `ROBOTS`, where it's set.
#![allow(missing_docs, clippy::unwrap_used)]

use std::{
    env, fs,
    path::{Path, PathBuf},
};

use criterion::{Criterion, criterion_group, criterion_main};
use formats::{Options, import, is_foreign};

/// The robots in a folder and below it, by their paths.
fn robots(folder: &Path) -> Vec<PathBuf> {
    let mut paths: Vec<_> = fs::read_dir(folder).unwrap().map(|it| it.unwrap().path()).collect();
    paths.sort();
    let below = paths.into_iter().flat_map(|path| match path.is_dir() {
        true => robots(&path),
        false => vec![path],
    });
    below.filter(|path| is_foreign(path)).collect()
}

fn import_robots(criterion: &mut Criterion) {
    let ours = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../tests/robots");
    let folder = env::var_os("ROBOTS").map_or(ours, PathBuf::from);
    for path in robots(&folder) {
        let name = path.strip_prefix(&folder).unwrap().display().to_string();
        if import(&path, &Options::default()).is_ok() {
            criterion.bench_function(&name, |bench| {
                bench.iter(|| import(&path, &Options::default()).unwrap());
            });
        }
    }
}

criterion_group!(benches, import_robots);
criterion_main!(benches);
