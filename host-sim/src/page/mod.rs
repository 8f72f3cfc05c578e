//! The page as one file that needs nothing else: `web/page/` with its scripts in order, uPlot, and the module
//! that computes, packed.

mod bundle;
mod septets;
#[cfg(feature = "monitor")]
pub mod served;

use bundle::Module;
use flate2::Compression;
use flate2::write::GzEncoder;
use std::io::Write;

/// The page's own scripts.
macro_rules! modules {
    ($($name:literal),+ $(,)?) => {
        [$( Module { name: $name, text: include_str!(concat!("../../../web/page/", $name)) } ),+]
    };
}

const MODULES: [Module; 28] = modules![
    "app.js",
    "attempt.js",
    "boot.js",
    "carried.js",
    "clock.js",
    "control.js",
    "dom.js",
    "flights.js",
    "helicopter.js",
    "history.js",
    "lessons.js",
    "link.js",
    "machine.js",
    "matrix.js",
    "mesh.js",
    "pace.js",
    "player.js",
    "plots.js",
    "recorder.js",
    "rig.js",
    "search.js",
    "septets.js",
    "serial.js",
    "settings.js",
    "socket.js",
    "steps.js",
    "tuner.js",
    "tuner-worker.js",
];
const PAGE: &str = include_str!("../../../web/page/index.html");
const STYLE: &str = include_str!("../../../web/page/style.css");
const PLOT_STYLE: &str = include_str!("../../../web/page/vendor/uPlot.min.css");
#[cfg(feature = "monitor")]
const PLOT: &str = include_str!("../../../web/page/vendor/uPlot.iife.min.js");
const PLOT_LICENCE: &str = include_str!("../../../web/page/vendor/LICENSE-uPlot");

/// Where `scripts/build-page.sh` puts the module.
pub const MODULE: &str = "target/page/twinrotor.wasm.gz";
/// What it puts beside it: the script that plots, packed, too.
pub const PACKED_PLOT: &str = "uplot.js.gz";
/// What a file of gzip begins with.
const MAGIC: &[u8] = &[0x1f, 0x8b];

/// Can these bytes be packed with gzip?
#[must_use]
pub fn is_packed(bytes: &[u8]) -> bool {
    bytes.starts_with(MAGIC)
}

/// The page around the module that computes and the script that plots, both packed.
#[must_use]
pub fn page(module: &[u8], plot: &[u8]) -> String {
    let parts = [
        ("/*STYLE*/", style()),
        ("/*WASM*/", septets::encode(module)),
        ("/*WORKER*/", script("tuner-worker.js")),
        ("/*UPLOT*/", septets::encode(plot)),
        ("/*APP*/", script("app.js")),
        ("/*BOOT*/", bundle::bundle(&MODULES, "boot.js")),
    ];
    filled(&flush(PAGE), &parts)
}

/// A script of the page's own, packed.
fn script(entry: &str) -> String {
    let mut packer = GzEncoder::new(Vec::new(), Compression::best());
    packer.write_all(bundle::bundle(&MODULES, entry).as_bytes()).expect("memory takes what is written");
    septets::encode(&packer.finish().expect("memory takes what is written"))
}

/// With uPlot's licence, which is its script's, too.
fn style() -> String {
    format!("/* uPlot\n{}*/\n{PLOT_STYLE}\n{}", PLOT_LICENCE.trim_end(), flush(STYLE))
}

/// A text with each part in the place of its mark.
fn filled(whole: &str, parts: &[(&str, String)]) -> String {
    let mut rest = whole;
    let mut page = String::new();
    for (mark, part) in parts {
        let (before, after) =
            rest.split_once(mark).expect("the page has a place for each part, in this order");
        page.push_str(before);
        page.push_str(part);
        rest = after;
    }
    page + rest
}

/// A text without its indent.
fn flush(text: &str) -> String {
    text.lines().flat_map(|line| [line.trim_start(), "\n"]).collect()
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn the_page_is_whole_and_asks_for_nothing_outside() {
        let page = page(&[0x1f, 0x8b, 8], &[0x1f, 0x8b, 9]);
        assert!(page.trim_end().ends_with("</html>"));
        for packed in [[0x1f, 0x8b, 8], [0x1f, 0x8b, 9]] {
            assert!(page.contains(&format!(">{}</script>", septets::encode(&packed))));
        }
        let of = |text: &str| page.matches(text).count();
        // A script that held the end of one would end there.
        assert_eq!((of("<script"), of("</script>")), (5, 5));
        for outside in ["src=\"", "href=\"http", "await import(", "@import", "fetch(", "XMLHttpRequest"] {
            assert_eq!(of(outside), 0, "{outside}");
        }
        assert!(page.contains("MIT License"), "uPlot's licence goes with it");
    }
}
