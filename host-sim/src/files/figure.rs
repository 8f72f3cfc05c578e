//! Figures on disk: SVG or PNG by the file's extension.

use crate::error::{Failure, Outcome};
use std::path::Path;
use twinrotor_plot::{Figure, Layout};

/// Refuses, before any work is done, a figure's path whose ending says nothing.
///
/// # Errors
///
/// If its ending names no format, or one that was left out of the build.
pub fn check(flag: &str, path: &Path) -> Outcome<()> {
    match super::ending(path).as_deref() {
        Some("svg") => Ok(()),
        #[cfg(feature = "formats")]
        Some("png") => Ok(()),
        #[cfg(not(feature = "formats"))]
        Some("png") => Err(super::not_built(flag, path)),
        _ => Err(Failure::Input(format!(
            "{flag} is '{}'; allowed: a name that ends in .svg or .png",
            path.display()
        ))),
    }
}

/// A figure as SVG or PNG, by the ending of the file's name.
///
/// # Errors
///
/// If it cannot be drawn.
pub fn bytes(figure: &Figure, path: &Path) -> Outcome<Vec<u8>> {
    of_svg(figure.to_svg(Layout::Wide)?, path)
}

/// An SVG document as it is or in pixels, by the ending of the file's name.
///
/// # Errors
///
/// If it cannot be drawn.
pub fn of_svg(svg: String, path: &Path) -> Outcome<Vec<u8>> {
    #[cfg(feature = "formats")]
    if super::ending(path).as_deref() == Some("png") {
        return Ok(twinrotor_plot::pixels::png(&svg)?);
    }
    #[cfg(not(feature = "formats"))]
    let _ = path;
    Ok(svg.into_bytes())
}
