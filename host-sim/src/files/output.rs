//! Files that appear whole or not at all, tried before the work that they are to keep.

use super::target::{Place, Target, folder};
use crate::error::{Failure, Outcome};
use std::fs::{self, File, Metadata, OpenOptions};
use std::io::{self, Write};
use std::path::{Path, PathBuf};
use std::sync::{Mutex, MutexGuard, PoisonError};
use tempfile::{Builder, NamedTempFile};

/// Texts up to this length \[bytes\] are printed if no file takes them.
const PRINTABLE: usize = 20_000;

/// What a command reads and what it will write. Each output is tried when it is named; what cannot be written
/// in the end is kept elsewhere, and the command goes on with the rest.
#[derive(Debug, Default)]
pub struct Outputs {
    taken: Vec<Taken>,
    failures: Vec<String>,
    unwritten: Vec<String>,
}

#[derive(Debug)]
struct Taken {
    place: Place,
    flag: String,
    path: PathBuf,
    read: bool,
}

impl Outputs {
    /// Nothing is known yet.
    pub fn new() -> Self {
        Self::default()
    }

    /// `path` is read (or names no file), because `flag` says so.
    pub fn reads(&mut self, flag: &str, path: impl AsRef<Path>) {
        let path = path.as_ref();
        if fs::metadata(path).is_ok_and(|found| found.is_file()) {
            self.take(flag, path, true);
        }
    }

    /// Refuses a path that cannot be written to, that is read, or that something else is written to.
    ///
    /// # Errors
    ///
    /// If it is one of these: which, in one line.
    pub fn writes(&mut self, flag: &str, path: &Path) -> Outcome<()> {
        check(flag, path)?;
        self.spares(flag, path)?;
        self.take(flag, path, false);
        Ok(())
    }

    /// Refuses a path that is read, or that something else is written to.
    ///
    /// # Errors
    ///
    /// If it is one of these.
    pub fn spares(&self, flag: &str, path: &Path) -> Outcome<()> {
        let place = Target::of(path).ok().and_then(|target| target.place());
        if let Some(other) = self.taken.iter().find(|taken| Some(&taken.place) == place.as_ref()) {
            let what = if other.read { "is read" } else { "is written" };
            return Err(Failure::Input(format!(
                "{flag} is '{}', which {what} as {} '{}'; allowed: another file",
                path.display(),
                other.flag,
                other.path.display()
            )));
        }
        Ok(())
    }

    fn take(&mut self, flag: &str, path: &Path, read: bool) {
        if let Some(place) = Target::of(path).ok().and_then(|target| target.place()) {
            self.taken.push(Taken { place, flag: flag.to_owned(), path: path.to_owned(), read });
        }
    }

    /// Writes `bytes`, or keeps them elsewhere; [`Outputs::done`] tells.
    pub fn write(&mut self, path: &Path, bytes: &[u8]) {
        if let Err(failure) = write(path, bytes) {
            self.failures.push(failure.to_string());
            if let Some(text) = std::str::from_utf8(bytes).ok().filter(|text| text.len() <= PRINTABLE) {
                self.unwritten.push(format!("{}:\n{text}", path.display()));
            }
        }
    }

    /// Something else could not be kept; [`Outputs::done`] tells.
    pub fn fail(&mut self, why: String) {
        self.failures.push(why);
    }

    /// Texts that found no file, to be printed.
    pub fn unwritten(&self) -> String {
        self.unwritten.concat()
    }

    /// The end.
    ///
    /// # Errors
    ///
    /// If something could not be written where it was wanted: what, and where it is kept.
    pub fn done(self) -> Outcome<()> {
        if self.failures.is_empty() { Ok(()) } else { Err(Failure::Run(self.failures.join("; "))) }
    }
}

/// Refuses, before any work is done, a path that cannot be written to.
///
/// # Errors
///
/// If it cannot be written to.
pub fn check(flag: &str, path: &Path) -> Outcome<()> {
    let shown = path.display();
    let refuse = |why: String| Err(Failure::Input(format!("{flag} is '{shown}', {why}")));
    if path.as_os_str() == "-" {
        return refuse("which names a file; standard output is /dev/stdout".to_owned());
    }
    let cannot = |error: &io::Error| format!("which cannot be written: {error}");
    match Target::of(path) {
        Err(error) => refuse(cannot(&error)),
        Ok(Target::Folder(_)) => refuse("which is a folder; a file is needed".to_owned()),
        Ok(Target::Output | Target::Error) => Ok(()),
        Ok(Target::Stream(stream)) => try_stream(&stream).or_else(|error| refuse(cannot(&error))),
        Ok(Target::File(file)) => {
            let folder = folder(&file);
            if !folder.is_dir() {
                return refuse(format!("but there is no folder '{}'", folder.display()));
            }
            try_file(&file, &folder).or_else(|error| refuse(cannot(&error)))
        }
    }
}

/// Makes the folder if it is not there, and refuses one that nothing can be written into.
///
/// # Errors
///
/// If it cannot be made or written into.
pub fn check_folder(flag: &str, folder: &Path) -> Outcome<()> {
    let refuse = |why: String| Failure::Input(format!("{flag} is '{}', {why}", folder.display()));
    if folder.exists() && !folder.is_dir() {
        return Err(refuse("which is a file; a folder is needed".to_owned()));
    }
    fs::create_dir_all(folder).map_err(|e| refuse(format!("which cannot be made: {e}")))?;
    let tried = tempfile::tempfile_in(folder);
    tried.map(drop).map_err(|e| refuse(format!("which nothing can be written into: {e}")))
}

/// A file that is there must open, and where there is none its folder must take one.
fn try_file(file: &Path, folder: &Path) -> io::Result<()> {
    if file.exists() {
        return OpenOptions::new().write(true).open(file).map(drop);
    }
    Builder::new().tempfile_in(folder).map(drop)
}

/// A device must open; opening a pipe would wait for its reader.
fn try_stream(stream: &Path) -> io::Result<()> {
    #[cfg(unix)]
    if std::os::unix::fs::FileTypeExt::is_fifo(&fs::metadata(stream)?.file_type()) {
        return Ok(());
    }
    OpenOptions::new().write(true).open(stream).map(drop)
}

/// Writes `bytes` to `path`, and if that cannot be done to a place that is named.
///
/// # Errors
///
/// If it cannot be written where it was wanted.
pub fn write(path: &Path, bytes: &[u8]) -> Outcome<()> {
    let Err(error) = replace(path, bytes) else { return Ok(()) };
    let kept = match rescue(path, bytes) {
        Some(elsewhere) => format!("it is kept in {}", elsewhere.display()),
        None => "it is kept nowhere else either".to_owned(),
    };
    Err(Failure::Run(format!("{}: cannot be written: {error}; {kept}", path.display())))
}

/// Writes `bytes` to `path`: by a temporary file in the same folder, renamed over a regular or absent file;
/// straight into anything else (a pipe, a device, a descriptor). Links are followed; a file that is there
/// keeps its permissions, its owner and its other names, a new one gets what the umask leaves.
///
/// # Errors
///
/// If it cannot be written.
pub fn replace(path: &Path, bytes: &[u8]) -> io::Result<()> {
    match Target::of(path)? {
        Target::Output => heeded(io::stdout().lock(), bytes),
        Target::Error => heeded(io::stderr().lock(), bytes),
        Target::Stream(path) => {
            // A descriptor may be a file that others write to as well: nothing of theirs is lost.
            let regular = fs::metadata(&path).is_ok_and(|found| found.is_file());
            heeded(OpenOptions::new().write(true).append(regular).open(&path)?, bytes)
        }
        Target::Folder(_) => Err(io::ErrorKind::IsADirectory.into()),
        Target::File(path) => replace_file(&path, bytes),
    }
}

/// A reader that has gone away is no failure of ours.
fn heeded(mut stream: impl Write, bytes: &[u8]) -> io::Result<()> {
    match stream.write_all(bytes).and_then(|()| stream.flush()) {
        Err(error) if error.kind() == io::ErrorKind::BrokenPipe => Ok(()),
        other => other,
    }
}

fn replace_file(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let there = fs::metadata(path).ok();
    if there.as_ref().is_some_and(has_other_names) {
        return overwrite(path, bytes);
    }
    let (mut file, _named) = match Named::temporary(path, there.as_ref()) {
        Ok(both) => both,
        Err(_) if there.is_some() => return overwrite(path, bytes),
        Err(error) => return Err(error),
    };
    file.write_all(bytes)?;
    file.as_file().sync_all()?;
    match file.persist(path) {
        // A file that is mounted by itself, or in a folder that only its owner may take files out of.
        Err(_) if there.is_some() => overwrite(path, bytes),
        Err(error) => Err(error.error),
        Ok(_) => Ok(()),
    }
}

/// A new file beside `path`, with what belongs to the one that is there.
fn temporary(path: &Path, there: Option<&Metadata>) -> io::Result<NamedTempFile> {
    let file = new_file().tempfile_in(folder(path))?;
    if let Some(there) = there {
        keep_owner(there, file.path())?;
        fs::set_permissions(file.path(), there.permissions())?;
    }
    Ok(file)
}

/// A temporary file is its owner's alone unless it is said otherwise; the umask holds either way.
#[cfg(unix)]
fn new_file() -> Builder<'static, 'static> {
    let mut builder = Builder::new();
    builder.permissions(std::os::unix::fs::PermissionsExt::from_mode(0o666));
    builder
}

#[cfg(not(unix))]
fn new_file() -> Builder<'static, 'static> {
    Builder::new()
}

#[cfg(unix)]
fn keep_owner(there: &Metadata, file: &Path) -> io::Result<()> {
    use std::os::unix::fs::{MetadataExt, chown};
    let new = fs::metadata(file)?;
    if (new.uid(), new.gid()) == (there.uid(), there.gid()) {
        return Ok(());
    }
    chown(file, Some(there.uid()), Some(there.gid()))
}

#[cfg(not(unix))]
fn keep_owner(_: &Metadata, _: &Path) -> io::Result<()> {
    Ok(())
}

#[cfg(unix)]
fn has_other_names(there: &Metadata) -> bool {
    std::os::unix::fs::MetadataExt::nlink(there) > 1
}

#[cfg(not(unix))]
fn has_other_names(_: &Metadata) -> bool {
    false
}

/// Writes into the file that is there, where it cannot be replaced without losing what belongs to it. What it
/// held comes back if that fails.
fn overwrite(path: &Path, bytes: &[u8]) -> io::Result<()> {
    let _whole = lock(&IN_PLACE);
    let before = fs::read(path);
    let put = |bytes: &[u8]| -> io::Result<()> {
        let mut file = OpenOptions::new().write(true).truncate(true).open(path)?;
        file.write_all(bytes)?;
        File::sync_all(&file)
    };
    put(bytes).inspect_err(|_| {
        if let Ok(before) = before {
            let _ = put(&before);
        }
    })
}

/// Keeps what could not be written where it was wanted.
fn rescue(path: &Path, bytes: &[u8]) -> Option<PathBuf> {
    let part = |part: Option<&std::ffi::OsStr>| part.map(|p| p.to_string_lossy().into_owned());
    let stem = part(path.file_stem()).unwrap_or_default() + "-";
    let ending = part(path.extension()).map_or_else(String::new, |ending| format!(".{ending}"));
    let folders = [std::env::temp_dir(), PathBuf::from("."), std::env::home_dir().unwrap_or_default()];
    folders.iter().find_map(|folder| {
        let mut file = Builder::new().prefix(&stem).suffix(&ending).tempfile_in(folder).ok()?;
        file.write_all(bytes).ok()?;
        file.keep().ok().map(|(_, path)| path)
    })
}

/// The temporary file that is being written, if one is.
static UNDER_WAY: Mutex<Option<PathBuf>> = Mutex::new(None);
/// Held while a file is written that cannot be replaced.
static IN_PLACE: Mutex<()> = Mutex::new(());

fn lock<T>(mutex: &Mutex<T>) -> MutexGuard<'_, T> {
    mutex.lock().unwrap_or_else(PoisonError::into_inner)
}

/// As long as it lives, [`abandon`] knows of a temporary file.
struct Named;

impl Named {
    fn temporary(path: &Path, there: Option<&Metadata>) -> io::Result<(NamedTempFile, Self)> {
        let mut under_way = lock(&UNDER_WAY);
        let file = temporary(path, there)?;
        *under_way = Some(file.path().to_owned());
        Ok((file, Self))
    }
}

impl Drop for Named {
    fn drop(&mut self) {
        *lock(&UNDER_WAY) = None;
    }
}

/// Before the program ends in the middle of writing: takes away the temporary file, and waits for one that is
/// written in its place.
pub fn abandon() {
    // Kept to the end: nothing new is begun.
    std::mem::forget(lock(&IN_PLACE));
    let mut under_way = lock(&UNDER_WAY);
    if let Some(path) = under_way.take() {
        let _ = fs::remove_file(path);
    }
    std::mem::forget(under_way);
}
