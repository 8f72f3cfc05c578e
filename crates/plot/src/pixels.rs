//! An SVG document in pixels: what is in one figure is in the other.

use crate::FONT_DATA;
use resvg::tiny_skia::{Pixmap, Transform};
use resvg::usvg::{Options, Tree, fontdb};
use std::sync::Arc;
use twinrotor_sim::{Error, Outcome};

/// \[pixels\] Of one unit of the document, across and down: sharp on the screens that there are.
pub const SCALE: u16 = 2;

/// The figure's own font, whatever the system has.
fn fonts() -> Arc<fontdb::Database> {
    let mut fonts = fontdb::Database::new();
    fonts.load_font_data(FONT_DATA.to_vec());
    fonts.set_sans_serif_family("DejaVu Sans");
    Arc::new(fonts)
}

/// The document as a PNG picture, with smooth edges, [`SCALE`] pixels for each of its units.
///
/// # Errors
///
/// If it cannot be drawn.
pub fn png(svg: &str) -> Outcome<Vec<u8>> {
    let failed = |e: &dyn std::fmt::Display| Error::Failed(format!("the figure cannot be drawn: {e}"));
    let options = Options { fontdb: fonts(), ..Options::default() };
    let tree = Tree::from_str(svg, &options).map_err(|e| failed(&e))?;
    let scale = f32::from(SCALE);
    let size = tree.size().to_int_size().scale_by(scale).ok_or_else(|| failed(&"it has no size"))?;
    let mut picture =
        Pixmap::new(size.width(), size.height()).ok_or_else(|| failed(&"it is too large for a picture"))?;
    resvg::render(&tree, Transform::from_scale(scale, scale), &mut picture.as_mut());
    picture.encode_png().map_err(|e| failed(&e))
}
