//! The files that a robot's file names: where they may be, and the meshes among them.
//!
//! A file may name what lies in its own folder, in its own ROS package, and in the folders that were
//! given for packages. Nothing else is opened.

use std::{
    cell::RefCell,
    collections::BTreeMap,
    path::{Component, Path, PathBuf},
    rc::Rc,
};

use crate::mesh::Mesh;

/// Where a robot's file is, and what it may name beyond its folder.
#[derive(Debug)]
pub(crate) struct Files {
    folder: PathBuf,
    /// Names and folders.
    packages: Vec<(String, PathBuf)>,
    meshes: RefCell<BTreeMap<PathBuf, Result<Rc<Mesh>, String>>>,
}

impl Files {
    pub(crate) fn new(file: &Path, packages: &[(String, PathBuf)]) -> Self {
        let folder = file.parent().filter(|it| !it.as_os_str().is_empty());
        Self {
            folder: folder.unwrap_or(Path::new(".")).into(),
            packages: packages.to_vec(),
            meshes: RefCell::default(),
        }
    }

    /// Where a path or a URI leads, whether or not a file is there.
    ///
    /// # Errors
    /// Why it mustn't be opened, to be put behind its name.
    pub(crate) fn resolve(&self, uri: &str) -> Result<PathBuf, String> {
        let uri = uri.trim().replace('\\', "/");
        for scheme in ["package://", "model://"] {
            if let Some(rest) = uri.strip_prefix(scheme) {
                let (package, path) = rest.split_once('/').unwrap_or((rest, ""));
                return self.in_package(package, path);
            }
        }
        let path = PathBuf::from(uri.strip_prefix("file://").unwrap_or(&uri));
        if path.to_string_lossy().contains("://") {
            return Err("isn't on this machine".into());
        }
        self.allowed(self.folder.join(path))
    }

    fn in_package(&self, package: &str, path: &str) -> Result<PathBuf, String> {
        let given = self.packages.iter().find(|(name, _)| name == package);
        let given = given.map(|(_, folder)| folder.clone());
        let beside = Some(self.folder.join(package)).filter(|it| it.is_dir());
        match given.or_else(|| self.own_package(package)).or(beside) {
            Some(folder) if is_within(&folder.join(path), &folder) => Ok(folder.join(path)),
            Some(folder) => self.allowed(folder.join(path)),
            None => Err(format!(
                "is in a package whose folder isn't known: --package {package}=DIR says it"
            )),
        }
    }

    /// The folder above the file with that name.
    fn own_package(&self, package: &str) -> Option<PathBuf> {
        let folder = self.folder.canonicalize().ok()?;
        let mut above = folder.ancestors();
        above.find(|it| it.file_name().is_some_and(|name| name == package)).map(Path::to_owned)
    }

    /// A path that stays where it may be.
    fn allowed(&self, path: PathBuf) -> Result<PathBuf, String> {
        let own = self.folder.canonicalize().unwrap_or_else(|_| plain(&self.folder));
        // A ROS package is the folder that has this file.
        let ros = own.ancestors().find(|it| it.join("package.xml").is_file());
        let packages = self.packages.iter().map(|(_, folder)| folder.as_path());
        let mut folders = [Some(own.as_path()), ros].into_iter().flatten().chain(packages);
        if folders.any(|folder| is_within(&path, folder)) {
            return Ok(path);
        }
        Err("is outside the file's folder: --package NAME=DIR allows what is in DIR".into())
    }

    /// A mesh that was found at a path.
    pub(crate) fn known(&self, path: &Path) -> Option<Rc<Mesh>> {
        self.meshes.borrow().get(path)?.clone().ok()
    }

    /// The mesh at a path or URI, and where it is.
    ///
    /// # Errors
    /// Why there is none, to be put behind its name.
    pub(crate) fn mesh(&self, uri: &str) -> Result<(PathBuf, Rc<Mesh>), String> {
        let path = self.resolve(uri)?;
        let mut meshes = self.meshes.borrow_mut();
        let mesh = meshes.entry(path.clone()).or_insert_with(|| Mesh::open(&path).map(Rc::new));
        mesh.clone().map(|mesh| (path, mesh))
    }
}

/// Whether a path stays in a folder, links followed.
fn is_within(path: &Path, folder: &Path) -> bool {
    let real = |path: &Path| path.canonicalize().unwrap_or_else(|_| plain(path));
    real(path).starts_with(real(folder))
}

/// Without `.` and `..`, as it's written.
fn plain(path: &Path) -> PathBuf {
    let path = std::path::absolute(path).unwrap_or_else(|_| path.into());
    let mut plain = PathBuf::new();
    for part in path.components() {
        match part {
            Component::ParentDir => drop(plain.pop()),
            Component::CurDir => {}
            _ => plain.push(part),
        }
    }
    plain
}

#[cfg(test)]
mod tests {
    use std::fs;

    use super::*;

    #[test]
    fn nothing_is_opened_outside_the_folder_unless_asked_for() {
        let folder = tempfile::tempdir().unwrap();
        let at = |path: &str| folder.path().join(path);
        for path in ["go/urdf", "go/meshes", "lib/meshes"] {
            fs::create_dir_all(at(path)).unwrap();
        }
        fs::write(at("go/meshes/a.stl"), "").unwrap();
        let file = at("go/urdf/go.urdf");
        let files = Files::new(&file, &[("lib".into(), at("lib"))]);
        assert!(files.resolve("meshes/a.stl").is_ok());
        assert!(files.resolve("package://go/meshes/a.stl").unwrap().is_file(), "its own package");
        assert!(files.resolve("package://lib/meshes/a.stl").unwrap().starts_with(at("lib")));
        let outside = "is outside the file's folder: --package NAME=DIR allows what is in DIR";
        for path in ["../meshes/a.stl", "/etc/passwd", "file:///etc/passwd", "a/../../../x.stl"] {
            assert_eq!(files.resolve(path).unwrap_err(), outside, "{path}");
        }
        assert_eq!(files.resolve("package://lib/../../x.stl").unwrap_err(), outside);
        let unknown = files.resolve("package://more/a.stl").unwrap_err();
        assert!(unknown.ends_with("--package more=DIR says it"), "{unknown}");
        fs::write(at("go/package.xml"), "<package/>").unwrap();
        assert!(files.resolve("../meshes/a.stl").unwrap().is_file(), "within its own package");
    }
}
