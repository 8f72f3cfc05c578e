//! The documentation speaks of things that are there.

use std::fs;
use std::path::Path;

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
