//! What every board's image takes of its chip, read from the built files: `cargo fw-test`. What has not been
//! built, or not since the default board's was, is left out, unless `TWINROTOR_ALL_IMAGES` is set.

use object::{Object, ObjectSection, ObjectSegment};
use std::path::{Path, PathBuf};
use twinrotor::board::{self, Board};

/// \[byte\] Of the flash behind the parameters' place: 512 KiB less 64, of which an image has these. The
/// F405's sectors 4 and 5, and as much of the others.
const FLASH: u64 = 192 * 1024;
/// \[byte\] For statics: 10 KiB of it are room for laws of matrices, of which the loop, a trial and each
/// message on its way have one.
const RAM: u64 = 26 * 1024;
/// \[byte\] What boards may differ by: they are one program, and their chips' crates.
const APART: u64 = 8 * 1024;

/// \[byte\] Loadable, and static RAM.
fn sizes(path: &Path) -> Option<[u64; 2]> {
    let bytes = std::fs::read(path).ok()?;
    let elf = object::File::parse(&*bytes).expect("an ELF file");
    let loadable = elf.segments().map(|segment| segment.file_range().1).sum();
    let ram = elf.sections().filter(|s| (0x2000_0000..0x2002_0000).contains(&s.address()));
    Some([loadable, ram.map(|section| section.size()).sum()])
}

/// Where a board's image is built, with its own folder for all but the default one; a Discovery has none
/// without a rig.
fn images() -> impl Iterator<Item = (String, PathBuf)> {
    let test = std::env::current_exe().expect("a test has a path");
    let target = test.ancestors().nth(3).expect("target/debug/deps/test").to_owned();
    let names = |board: Board| [board.name.to_owned(), format!("{}-sim", board.name)];
    board::ALL.into_iter().flat_map(names).filter(|name| name != "f407-sim").map(move |name| {
        let folder = if name == Board::default().name { target.clone() } else { target.join(&name) };
        (name, folder.join("thumbv7em-none-eabihf/firmware/firmware"))
    })
}

#[test]
#[cfg_attr(not(feature = "elf-tests"), ignore = "reads the ELFs: cargo fw and the like, then cargo fw-test")]
fn every_boards_image_keeps_its_bounds() {
    let every = std::env::var_os("TWINROTOR_ALL_IMAGES").is_some();
    let bounds = format!("{FLASH} and {RAM} at most");
    println!("{:<16}{:>12}{:>12}   {bounds}", "image", "flash", "static RAM");
    let mut found = Vec::new();
    let built = |path: &Path| std::fs::metadata(path).and_then(|file| file.modified()).ok();
    let default = images().next().and_then(|(_, path)| built(&path));
    for (name, path) in images() {
        if !every && built(&path).is_some_and(|at| Some(at) < default) {
            println!("{name:<16}{:>12}", "of before");
            continue;
        }
        let Some([flash, ram]) = sizes(&path) else {
            assert!(!every, "{name} is not built: cargo fw-{name}");
            println!("{name:<16}{:>12}", "not built");
            continue;
        };
        println!("{name:<16}{flash:>12}{ram:>12}");
        assert!(flash <= FLASH && ram <= RAM, "{name}: {flash} bytes of flash, {ram} of RAM");
        found.push((name, flash));
    }
    let (_, default) = found.first().expect("cargo fw comes first").clone();
    for (name, flash) in found.iter().filter(|(name, _)| !name.ends_with("-sim")) {
        assert!(flash.abs_diff(default) <= APART, "{name}: {flash} bytes, the default board {default}");
    }
}
