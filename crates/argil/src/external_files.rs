//! Which files outside of its folder a scene may read.

use crate::mesh_file_error::MeshFileError;
use std::collections::BTreeSet;
use std::path::{Component, Path, PathBuf};

/// The files outside of a scene's folder that the scene may read: by default none. `true` becomes all, and `false` none.
///
/// ```
/// use argil::ExternalFiles;
/// let mut files = ExternalFiles::default();
/// files.allow("/meshes/statue.obj");
/// assert_eq!(files.listed().len(), 1);
/// ```
#[derive(Clone, Debug, Default, PartialEq, Eq)]
pub struct ExternalFiles {
    all: bool,
    listed: BTreeSet<PathBuf>,
}

impl From<bool> for ExternalFiles {
    fn from(all: bool) -> Self {
        Self {
            all,
            ..Self::default()
        }
    }
}

impl<P: AsRef<Path>> FromIterator<P> for ExternalFiles {
    fn from_iter<I: IntoIterator<Item = P>>(files: I) -> Self {
        let mut all = Self::default();
        for file in files {
            all.allow(file);
        }
        all
    }
}

impl ExternalFiles {
    /// Allows a file. A link means the file that it leads to now.
    pub fn allow(&mut self, file: impl AsRef<Path>) {
        let file = file.as_ref();
        let place = file.canonicalize().or_else(|_| std::path::absolute(file));
        self.listed.insert(place.unwrap_or_else(|_| file.into()));
    }

    /// Returns the files that were allowed one by one, by absolute path.
    pub fn listed(&self) -> &BTreeSet<PathBuf> {
        &self.listed
    }

    /// Returns the path of a file that a scene names. `folder` is the folder of the scene's file.
    ///
    /// # Errors
    /// If the file is outside of the folder, and not allowed.
    pub(crate) fn place_of(&self, path: &str, folder: &Path) -> Result<PathBuf, MeshFileError> {
        let folder = if folder.as_os_str().is_empty() {
            Path::new(".")
        } else {
            folder
        };
        let place = folder.join(path);
        if self.all {
            return Ok(place);
        }
        let found = place.canonicalize();
        if found
            .as_ref()
            .is_ok_and(|found| self.listed.contains(found))
        {
            return Ok(place);
        }
        let refuse = || MeshFileError::ExternalMesh {
            path: path.to_owned(),
            folder: folder.into(),
        };
        let plain = |part: Component<'_>| matches!(part, Component::Normal(_) | Component::CurDir);
        if !Path::new(path).components().all(plain) {
            return Err(refuse());
        }
        // A link may also lead outside. A missing file is reported when it is read.
        match (found, folder.canonicalize()) {
            (Ok(found), Ok(folder)) if !found.starts_with(&folder) => Err(refuse()),
            _ => Ok(place),
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn paths_that_lead_out_are_refused() {
        let here = tempfile::tempdir().expect("a folder");
        let inner = here.path().join("scene");
        std::fs::create_dir(&inner).expect("a folder");
        for name in ["secret.obj", "other.obj"] {
            std::fs::write(here.path().join(name), "").expect("a file");
        }
        let none = ExternalFiles::default();
        let refused = |path: &str| none.place_of(path, &inner).is_err();
        assert!(refused("../secret.obj") && refused("/etc/passwd.obj") && refused("a/../../b.obj"));
        assert!(!refused("a.obj") && !refused("sub/a.obj") && !refused("./a.obj"));
        let all = ExternalFiles::from(true);
        assert!(all.place_of("../secret.obj", &inner).is_ok());
        // One file is allowed, and no other.
        let one = ExternalFiles::from_iter([inner.join("../other.obj")]);
        let refused_by_one = |path: &str| one.place_of(path, &inner).is_err();
        assert!(!refused_by_one("../other.obj") && refused_by_one("../secret.obj"));
        assert!(!refused_by_one("a.obj"));
        #[cfg(unix)]
        {
            let link = inner.join("link.obj");
            std::os::unix::fs::symlink(here.path().join("secret.obj"), link).expect("a link");
            assert!(refused("link.obj") && refused_by_one("link.obj"));
        }
    }
}
