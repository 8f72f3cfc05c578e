//! The documentation speaks of things that are there.

use std::fs;
use std::path::{Path, PathBuf};

/// Every path that ARCHITECTURE.md and README.md name in back quotes exists.
#[test]
fn every_path_in_the_documentation_exists() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    for document in ["ARCHITECTURE.md", "README.md"] {
        let text = fs::read_to_string(root.join(document)).unwrap();
        let quoted = text.split('`').skip(1).step_by(2);
        let paths = quoted.filter(|q| {
            let first = q.split('/').next().unwrap_or_default();
            q.contains('/')
                && !q.contains([' ', '*', '<', '\n'])
                && [
                    "core", "crates", "host-sim", "firmware", "tests", "scripts", "docs", ".cargo", ".ci",
                    "gains",
                ]
                .contains(&first)
        });
        let mut checked = 0;
        for path in paths {
            assert!(root.join(path).exists(), "{document} names {path}, which does not exist");
            checked += 1;
        }
        assert!(checked > 0, "{document} names {checked} paths");
    }
}

/// Every source file of the core is named: a module in the list of `core/src/lib.rs`, or by its path in
/// ARCHITECTURE.md.
#[test]
fn every_file_of_the_core_is_named() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("..");
    let source = root.join("core/src");
    let list = fs::read_to_string(source.join("lib.rs")).unwrap();
    let list: Vec<&str> = list.lines().filter(|line| line.starts_with("//!")).collect();
    let list = list.join("\n");
    let architecture = fs::read_to_string(root.join("ARCHITECTURE.md")).unwrap();
    let files = rust_files(&source);
    assert!(files.len() > 40, "{files:?}");
    for file in files {
        let path = file.strip_prefix(&root).unwrap().to_str().unwrap();
        let module = path.trim_start_matches("core/src/").trim_end_matches(".rs").trim_end_matches("/mod");
        let tests = module.ends_with("tests") || module == "lib";
        let links = [format!("[`{module}`]"), format!("[`mod@{module}`]")];
        let listed = links.iter().any(|link| list.contains(link));
        assert!(
            tests || listed || architecture.contains(&format!("`{path}`")),
            "{path} is named neither in core/src/lib.rs nor in ARCHITECTURE.md"
        );
    }
}

fn rust_files(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    entries
        .flat_map(|path| match path.is_dir() {
            true => rust_files(&path),
            false => Vec::from_iter(path.extension().is_some_and(|e| e == "rs").then_some(path)),
        })
        .collect()
}
