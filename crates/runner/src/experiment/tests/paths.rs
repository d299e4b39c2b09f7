//! Paths of files: where they are found, and what cells are called by them.

use std::{fs, path::Path};

use super::plan;
use crate::experiment::Plan;

#[test]
fn models_are_found_from_the_file_or_from_where_the_command_is_given() {
    let folder = tempfile::tempdir().unwrap();
    let folder = folder.path().canonicalize().unwrap();
    fs::create_dir(folder.join("experiments")).unwrap();
    fs::write(folder.join("robot.toml"), "").unwrap();
    let file = folder.join("experiments/x.toml");
    fs::write(&file, "model = '../robot.toml'").unwrap();
    let model = |overrides: &[String]| {
        Plan::open(&file, overrides).unwrap().cells()[0].experiment.model.clone()
    };
    assert_eq!(Path::new(&model(&[])), folder.join("robot.toml"));
    let here = std::env::current_dir().unwrap();
    assert_eq!(Path::new(&model(&["model='other.toml'".into()])), here.join("other.toml"));
}

/// However the key is written, in a sweep or not.
#[test]
fn policies_to_start_from_are_found_likewise() {
    let initial = |text: &str, overrides: &[&str]| {
        let folder = tempfile::tempdir().unwrap();
        let (file, place) = (folder.path().join("x.toml"), folder.path().canonicalize().unwrap());
        fs::write(&file, format!("model = 'm'\n{text}")).unwrap();
        let overrides: Vec<_> = overrides.iter().map(|text| (*text).to_owned()).collect();
        let plan = Plan::open(&file, &overrides).unwrap();
        let path = plan.cells().last().unwrap().experiment.initial().unwrap();
        path.replace(place.to_str().unwrap(), "HERE")
    };
    for text in [
        "policy.initial = 'a/b'",
        "[policy]\ninitial = './a/b'",
        "[sweep]\n'policy.initial' = ['c', 'a/b']",
        "[sweep.policy]\ninitial = ['c', 'a/b']",
        "[sweep]\npolicy = [{ label = 'none' }, { initial = 'a/b' }]",
    ] {
        assert_eq!(initial(text, &[]), "HERE/a/b", "{text}");
    }
    let here = std::env::current_dir().unwrap().join("a/b");
    for set in ["policy.initial='a/b'", "policy={ initial = 'a/b' }"] {
        assert_eq!(Path::new(&initial("policy.initial = 'c'", &[set])), here, "{set}");
    }
    let set = "sweep.policy=[{ label = 'none' }, { initial = 'a/b' }]";
    assert_eq!(Path::new(&initial("", &[set])), here);
}

/// Two cells of two runs export files of the same name.
#[test]
fn cells_are_named_by_the_cells_that_they_start_from() {
    let export = |run: &str| format!("'/{run}/cells/xi=1/seed=2/policy.safetensors'");
    let paths = format!("{}, {}, '/x/good.safetensors'", export("a"), export("b"));
    let plan = plan(&format!("model = '/m'\n[sweep]\n'policy.initial' = [{paths}]"));
    let names: Vec<_> = plan.listing().map(|(_, setting, _)| setting).collect();
    assert_eq!(names, ["initial=xi-1-seed-2", "initial=xi-1-seed-2-2", "initial=good"]);
}
