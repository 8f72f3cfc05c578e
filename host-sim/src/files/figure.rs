//! Figures on disk: SVG or PNG by the file's extension.

use super::output;
use crate::error::{Failure, Outcome};
use std::path::Path;
use twinrotor_plot::{Figure, Layout};

/// Refuses, before any work is done, a figure's path that could not be written.
///
/// # Errors
///
/// If it could not be.
pub fn check(flag: &str, path: &Path) -> Outcome<()> {
    match path.extension().and_then(|e| e.to_str()) {
        Some("svg") => output::check(flag, path),
        #[cfg(feature = "formats")]
        Some("png") => output::check(flag, path),
        #[cfg(not(feature = "formats"))]
        Some("png") => Err(super::not_built(flag, path)),
        _ => Err(Failure::Input(format!(
            "{flag} is '{}'; allowed: a name that ends in .svg or .png",
            path.display()
        ))),
    }
}

/// Writes a figure, as SVG or PNG by the extension.
///
/// # Errors
///
/// If it cannot be drawn or written.
pub fn write(figure: &Figure, path: &Path) -> Outcome<()> {
    #[cfg(feature = "formats")]
    if path.extension().is_some_and(|e| e == "png") {
        return output::write(path, &figure.to_png()?);
    }
    output::write(path, figure.to_svg(Layout::Wide)?.as_bytes())
}
