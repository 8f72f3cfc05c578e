//! Where a path that somebody typed leads: links followed, descriptors told from files.

use std::fs::{self, Metadata};
use std::io;
use std::path::{Path, PathBuf};

/// What is at the end of a path.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Target {
    /// The program's own standard output.
    Output,
    /// The program's own standard error.
    Error,
    /// What takes bytes as they come: a pipe, a device, a descriptor.
    Stream(PathBuf),
    /// A regular file or none yet, links followed.
    File(PathBuf),
    /// A folder.
    Folder(PathBuf),
}

/// Links in a row before they are taken for a circle.
const MOST_LINKS: usize = 40;

impl Target {
    /// Of `path`. A link that leads nowhere yet leads to the file that will be there.
    ///
    /// # Errors
    ///
    /// If links go in a circle, or the system does not let us look.
    pub(super) fn of(path: &Path) -> io::Result<Self> {
        let mut at = path.to_path_buf();
        for _ in 0..MOST_LINKS {
            let Some(name) = at.file_name() else { return Ok(Self::Folder(at)) };
            if at.to_string_lossy().ends_with(std::path::is_separator) {
                return Ok(Self::Folder(at));
            }
            let folder = match fs::canonicalize(folder(&at)) {
                Ok(folder) => folder,
                Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Self::File(at)),
                Err(error) => return Err(error),
            };
            let whole = folder.join(name);
            if let Some(stream) = descriptor(&folder, &whole) {
                return Ok(stream);
            }
            match fs::symlink_metadata(&whole) {
                Ok(found) if found.is_symlink() => at = folder.join(fs::read_link(&whole)?),
                Ok(found) if found.is_dir() => return Ok(Self::Folder(whole)),
                Ok(found) if !found.is_file() => return Ok(Self::Stream(whole)),
                Ok(_) => return Ok(Self::File(whole)),
                Err(error) if error.kind() == io::ErrorKind::NotFound => return Ok(Self::File(whole)),
                Err(error) => return Err(error),
            }
        }
        Err(io::Error::other("its links go in a circle"))
    }

    /// What two paths have in common that lead to the same place; nothing for what may be written to by many.
    pub(super) fn place(&self) -> Option<Place> {
        match self {
            Self::Output => Some(Place::Path(PathBuf::from("/dev/stdout"))),
            Self::Error => Some(Place::Path(PathBuf::from("/dev/stderr"))),
            Self::Folder(_) => None,
            Self::Stream(path) => fs::metadata(path).ok().filter(|m| !is_device(m)).map(|m| of(&m, path)),
            Self::File(path) => {
                Some(fs::metadata(path).map_or_else(|_| Place::Path(path.clone()), |m| of(&m, path)))
            }
        }
    }
}

/// A place in the file system.
#[derive(Debug, Clone, PartialEq, Eq)]
pub(super) enum Place {
    /// A device's number and a file's on it: the same for all its names.
    #[cfg(unix)]
    Node(u64, u64),
    /// Where nothing is yet.
    Path(PathBuf),
}

/// The folder that `path` lies in.
pub(super) fn folder(path: &Path) -> PathBuf {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder.to_path_buf(),
        _ => PathBuf::from("."),
    }
}

/// An open descriptor, as Linux and others show them in a folder: nothing that could be replaced.
fn descriptor(folder: &Path, whole: &Path) -> Option<Target> {
    let number: u32 = whole.file_name()?.to_str()?.parse().ok()?;
    let parts: Vec<&str> = folder.iter().filter_map(|part| part.to_str()).collect();
    let own = match parts[..] {
        ["/", "dev", "fd"] => true,
        ["/", "proc", process, "fd"] | ["/", "proc", process, "task", _, "fd"] => {
            process.parse() == Ok(std::process::id())
        }
        _ => return None,
    };
    Some(match number {
        1 if own => Target::Output,
        2 if own => Target::Error,
        _ => Target::Stream(whole.to_path_buf()),
    })
}

#[cfg(unix)]
fn of(found: &Metadata, _: &Path) -> Place {
    use std::os::unix::fs::MetadataExt;
    Place::Node(found.dev(), found.ino())
}

#[cfg(not(unix))]
fn of(_: &Metadata, path: &Path) -> Place {
    Place::Path(fs::canonicalize(path).unwrap_or_else(|_| path.to_path_buf()))
}

#[cfg(unix)]
fn is_device(found: &Metadata) -> bool {
    std::os::unix::fs::FileTypeExt::is_char_device(&found.file_type())
}

#[cfg(not(unix))]
fn is_device(_: &Metadata) -> bool {
    true
}

#[cfg(all(test, unix))]
mod tests {
    use super::*;
    use std::os::unix::fs::symlink;

    #[test]
    fn links_are_followed_to_files_that_are_there_and_that_are_not() {
        let folder = tempfile::tempdir().unwrap();
        let at = |name: &str| folder.path().join(name);
        let real = fs::canonicalize(folder.path()).unwrap();
        fs::create_dir(at("real")).unwrap();
        symlink("real/new.toml", at("first.toml")).unwrap();
        symlink("first.toml", at("second.toml")).unwrap();
        assert_eq!(Target::of(&at("second.toml")).unwrap(), Target::File(real.join("real/new.toml")));
        let place = || Target::of(&at("second.toml")).unwrap().place();
        assert_eq!(place(), Some(Place::Path(real.join("real/new.toml"))));
        fs::write(at("real/new.toml"), "x").unwrap();
        fs::hard_link(at("real/new.toml"), at("hard.toml")).unwrap();
        assert!(matches!(place(), Some(Place::Node(..))));
        assert_eq!(place(), Target::of(&at("hard.toml")).unwrap().place());
        symlink("round", at("round")).unwrap();
        assert!(Target::of(&at("round")).is_err());
    }

    #[test]
    fn descriptors_devices_and_folders_are_no_files() {
        assert_eq!(Target::of(Path::new("/dev/stdout")).unwrap(), Target::Output);
        assert_eq!(Target::of(Path::new("/dev/fd/2")).unwrap(), Target::Error);
        let null = Target::of(Path::new("/dev/null")).unwrap();
        assert_eq!((&null, null.place()), (&Target::Stream("/dev/null".into()), None));
        for folder in ["/", "..", "new/", "/tmp"] {
            assert!(matches!(Target::of(Path::new(folder)).unwrap(), Target::Folder(_)), "{folder}");
        }
    }
}
