//! Files that appear whole or not at all.

use crate::error::{Failure, Outcome};
use std::fs;
use std::io::Write;
use std::path::{Path, PathBuf};

/// Writes `bytes` to `path`: by a temporary file in the same folder, renamed over a regular or absent file;
/// straight into anything else (a pipe, a device).
///
/// # Errors
///
/// If it cannot be written.
pub fn write(path: &Path, bytes: &[u8]) -> Outcome<()> {
    let failed =
        |error: std::io::Error| Failure::Run(format!("{}: cannot be written: {error}", path.display()));
    let special = fs::metadata(path).is_ok_and(|m| !m.is_file());
    if special {
        let mut file = fs::OpenOptions::new().write(true).open(path).map_err(failed)?;
        return file.write_all(bytes).and_then(|()| file.flush()).map_err(failed);
    }
    let mut file = tempfile::NamedTempFile::new_in(folder(path)).map_err(failed)?;
    file.write_all(bytes).map_err(failed)?;
    file.as_file().sync_all().map_err(failed)?;
    if let Some(permissions) = permissions(path) {
        fs::set_permissions(file.path(), permissions).map_err(failed)?;
    }
    file.persist(path).map_err(|e| failed(e.error))?;
    Ok(())
}

/// A new file gets what any program would give it (a temporary file is the owner's alone); an old one keeps
/// its own.
fn permissions(path: &Path) -> Option<fs::Permissions> {
    #[cfg(unix)]
    let new = Some(std::os::unix::fs::PermissionsExt::from_mode(0o644));
    // Elsewhere a folder says who may read what is made in it.
    #[cfg(not(unix))]
    let new = None;
    fs::metadata(path).map_or(new, |m| Some(m.permissions()))
}

fn folder(path: &Path) -> PathBuf {
    match path.parent() {
        Some(folder) if !folder.as_os_str().is_empty() => folder.to_path_buf(),
        _ => PathBuf::from("."),
    }
}

/// Refuses, before any work is done, a path that cannot be written to: its folder must exist and it must not
/// be one.
///
/// # Errors
///
/// If it cannot be written to.
pub fn check(flag: &str, path: &Path) -> Outcome<()> {
    let folder = folder(path);
    if !folder.is_dir() {
        return Err(Failure::Input(format!(
            "{flag} is '{}', but there is no folder '{}'",
            path.display(),
            folder.display()
        )));
    }
    if path.is_dir() {
        return Err(Failure::Input(format!(
            "{flag} is '{}', which is a folder; a file is needed",
            path.display()
        )));
    }
    Ok(())
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn replaces_whole_and_leaves_nothing_beside() {
        let folder = tempfile::tempdir().unwrap();
        let path = folder.path().join("gains.toml");
        write(&path, b"one").unwrap();
        write(&path, b"two").unwrap();
        assert_eq!(fs::read(&path).unwrap(), b"two");
        assert_eq!(fs::read_dir(folder.path()).unwrap().count(), 1);
    }

    #[test]
    fn a_missing_folder_is_named() {
        let error = check("--out", Path::new("nowhere/at/all.toml")).unwrap_err();
        assert!(error.to_string().contains("no folder 'nowhere/at'"), "{error}");
        assert_eq!(error.exit_status(), 2);
    }

    #[test]
    fn a_device_is_written_straight() {
        write(Path::new("/dev/null"), b"anything").unwrap();
        assert!(matches!(write(Path::new("/dev/full"), b"anything"), Err(Failure::Run(_))));
    }
}
