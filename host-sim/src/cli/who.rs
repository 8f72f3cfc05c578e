//! Controllers by name or gains file, as `compare` and `reproduce` take them.

use crate::error::{Failure, Outcome};
use crate::files;
use std::path::{Path, PathBuf};
use twinrotor::controller::ControllerSettings;
use twinrotor_sim::Error;
use twinrotor_sim::error::known_name;
use twinrotor_sim::gains_file::GainsFile;
use twinrotor_sim::is_text;
use twinrotor_sim::rig::NamedRig;
use twinrotor_tune::design::CATALOGUE;

/// After the name of what flies as it was designed.
pub(super) const UNTUNED: &str = " (untuned)";

/// A controller and how it is shown.
pub(super) type Named = (String, ControllerSettings<f64>);

/// Ours, in the folder of tuned gains.
pub(super) fn ours_path(folder: &Path, named: &NamedRig) -> PathBuf {
    folder.join(format!("{}.toml", file_stem(named)))
}

/// One of the catalogue, there.
pub(super) fn compared_path(folder: &Path, named: &NamedRig, name: &str) -> PathBuf {
    folder.join("compared").join(file_stem(named)).join(format!("{name}.toml"))
}

fn file_stem(named: &NamedRig) -> String {
    Path::new(&named.name)
        .file_stem()
        .map_or_else(|| named.name.clone(), |s| s.to_string_lossy().into_owned())
}

/// Gains that `flag` led to, whose loop holds where they are matrices.
fn load(flag: &str, path: &Path, named: &NamedRig) -> Outcome<ControllerSettings<f64>> {
    let name = path.display().to_string();
    let file = files::gains(flag, &name)?;
    file.require_stable(&named.name, &named.rig).map_err(|error| error.within(&name))?;
    Ok(file.controller)
}

/// What has no tuned gains, as on a rig of one's own, flies as it was designed and is marked so.
fn tuned_or_designed(path: &Path, shown: &str, design: &str, named: &NamedRig) -> Outcome<Named> {
    let unknown = |error| match error {
        Error::Unknown { field, value, nearest, mut known } => {
            known.insert(0, "ours".to_owned());
            known.push("or the path of a gains file".to_owned());
            Error::Unknown { field, value, nearest, known }
        }
        other => other,
    };
    let design = known_name("controllers", design, &CATALOGUE).map_err(unknown).map_err(Failure::of_flag)?;
    if path.exists() {
        return Ok((shown.to_owned(), load("--gains", path, named)?));
    }
    Ok((format!("{shown}{UNTUNED}"), design(&named.rig)))
}

/// One of `--controllers`: `ours`, `paper`, a name of the catalogue, or a gains file. `folder` is that of
/// `--gains`.
pub(super) fn one(name: &str, folder: &Path, named: &NamedRig) -> Outcome<Named> {
    match name {
        "ours" => tuned_or_designed(&ours_path(folder, named), "ours", "integral", named),
        "paper" => Ok((name.to_owned(), GainsFile::paper().controller)),
        file if is_text(file) => Ok((file.to_owned(), load("--controllers", Path::new(file), named)?)),
        _ => tuned_or_designed(&compared_path(folder, named, name), name, name, named),
    }
}

/// Ours first, then what was asked for, or all.
pub(super) fn all(asked: &[String], folder: &Path, named: &NamedRig) -> Outcome<Vec<Named>> {
    let catalogue = CATALOGUE.map(|(name, _)| name.to_owned());
    let others = if asked.is_empty() { &catalogue[..] } else { asked };
    let others = others.iter().filter(|name| *name != "ours").map(String::as_str);
    std::iter::once("ours").chain(others).map(|name| one(name, folder, named)).collect()
}

#[cfg(test)]
mod tests {
    use super::*;
    use twinrotor::plant::presets;

    /// Without a folder of tuned gains a name is its design, and says so; the paper's has no other.
    #[test]
    fn what_has_no_tuned_gains_flies_as_designed_and_says_so() {
        let paper = NamedRig { name: "paper".to_owned(), rig: presets::PAPER };
        let shown = |folder: &str| {
            let shown = |name| one(name, Path::new(folder), &paper).map(|(shown, _)| shown);
            ["lqi-plus", "ours", "paper"].map(|name| shown(name).unwrap_or_else(|_| panic!("{name}")))
        };
        assert_eq!(shown("no such folder"), ["lqi-plus (untuned)", "ours (untuned)", "paper"]);
        let tuned = concat!(env!("CARGO_MANIFEST_DIR"), "/../gains");
        assert_eq!(shown(tuned), ["lqi-plus", "ours", "paper"]);
    }
}
