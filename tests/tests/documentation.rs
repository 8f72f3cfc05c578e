//! The documentation speaks of things that are there, names every file, and keeps to its line length.

use std::fs;
use std::path::{Path, PathBuf};

/// \[characters\] The longest line.
const LINE: usize = 110;

fn root() -> PathBuf {
    Path::new(env!("CARGO_MANIFEST_DIR")).parent().unwrap().to_path_buf()
}

/// Every file below `folder`, but what is built or hidden (`.ci`, `.cargo` and `.github` are ours).
fn files(folder: &Path) -> Vec<PathBuf> {
    let entries = fs::read_dir(folder).unwrap().map(|entry| entry.unwrap().path());
    let skipped = |path: &PathBuf| {
        let name = path.file_name().unwrap().to_string_lossy().into_owned();
        name == "target" || (name.starts_with('.') && ![".ci", ".cargo", ".github"].contains(&&*name))
    };
    let kept = entries.filter(|path| !skipped(path));
    kept.flat_map(|path| if path.is_dir() { files(&path) } else { vec![path] }).collect()
}

/// Those of these endings, each with its text and its path from the top.
fn texts(endings: &[&str]) -> Vec<(String, String)> {
    let root = root();
    let wanted = files(&root).into_iter().filter(|path| {
        let ending = path.extension().map(|e| e.to_string_lossy().into_owned()).unwrap_or_default();
        endings.contains(&&*ending)
    });
    let relative = |path: &PathBuf| path.strip_prefix(&root).unwrap().to_str().unwrap().replace('\\', "/");
    wanted.map(|path| (relative(&path), fs::read_to_string(&path).unwrap())).collect()
}

/// What stands in back quotes outside of fenced blocks, and where links lead.
fn named(text: &str) -> Vec<String> {
    let mut fenced = false;
    let prose = text.lines().filter(|line| {
        let fence = line.trim_start().starts_with("```");
        fenced ^= fence;
        !fenced && !fence
    });
    let prose: String = prose.collect::<Vec<_>>().join("\n");
    let quoted = prose.split('`').skip(1).step_by(2).map(str::to_owned);
    let links = prose.split("](").skip(1).filter_map(|rest| rest.split_once(')'));
    let links = links.map(|(link, _)| link.split('#').next().unwrap_or_default().to_owned());
    quoted.chain(links).collect()
}

/// Is it meant as a path of this repository: something that begins with what lies at its top or beside the
/// document, or that ends as documents do? What is built (`target/`) is not.
fn is_path(name: &str, root: &Path, beside: &Path) -> bool {
    let plain = |c: char| c.is_ascii_alphanumeric() || "_-./*".contains(c);
    let first = name.split('/').next().unwrap_or_default();
    let begins_here = name.contains('/')
        && !first.is_empty()
        && first != "target"
        && (root.join(first).is_dir() || beside.join(first).is_dir());
    name.chars().all(plain) && (begins_here || Path::new(name).extension().is_some_and(|e| e == "md"))
}

/// A `*` stands for any name: what is before it must be there.
fn exists(name: &str, folder: &Path) -> bool {
    let fixed: PathBuf = name.split('/').take_while(|part| !part.contains('*')).collect();
    folder.join(fixed).exists()
}

#[test]
fn every_path_in_the_documentation_exists() {
    let (root, mut checked) = (root(), 0);
    for (document, text) in texts(&["md"]) {
        let beside = root.join(&document).parent().unwrap().to_path_buf();
        for name in named(&text).iter().filter(|name| is_path(name, &root, &beside)) {
            assert!(exists(name, &root) || exists(name, &beside), "{document}: there is no {name}");
            checked += 1;
        }
    }
    assert!(checked > 100, "{checked} paths");
}

/// The site's contents name every page once, and each is named for one of the four kinds of reading.
#[test]
fn every_page_is_in_the_contents() {
    let folder = root().join("docs");
    let contents = fs::read_to_string(folder.join("SUMMARY.md")).unwrap();
    let pages = files(&folder).into_iter().filter(|path| path.extension().is_some_and(|e| e == "md"));
    let mut checked = 0;
    for page in pages.map(|path| path.file_name().unwrap().to_string_lossy().into_owned()) {
        if page == "SUMMARY.md" {
            continue;
        }
        assert_eq!(contents.matches(&format!("]({page})")).count(), 1, "{page} in docs/SUMMARY.md");
        checked += 1;
    }
    assert!(checked > 15, "{checked} pages");
    let kinds: Vec<&str> = contents.lines().filter(|line| line.starts_with("# ")).collect();
    assert_eq!(kinds, ["# Summary", "# Learn", "# Do", "# Look up", "# Understand"]);
}

/// A heading as the anchor that pages and forges make of it.
fn anchor(heading: &str) -> String {
    let lower = heading.to_lowercase();
    let kept: String = lower.chars().filter(|c| c.is_alphanumeric() || " -_".contains(*c)).collect();
    kept.replace(' ', "-")
}

#[test]
fn every_link_into_a_page_finds_its_heading() {
    let (root, mut checked) = (root(), 0);
    for (document, text) in texts(&["md"]) {
        let beside = root.join(&document).parent().unwrap().to_path_buf();
        let links = text.split("](").skip(1).filter_map(|rest| rest.split_once(')')).map(|(link, _)| link);
        for (page, wanted) in links.filter_map(|link| link.split_once('#')) {
            if page.contains(':') {
                continue;
            }
            let there =
                if page.is_empty() { text.clone() } else { fs::read_to_string(beside.join(page)).unwrap() };
            let headings = there.lines().filter(|line| line.starts_with('#'));
            let found = headings.map(|line| anchor(line.trim_start_matches('#').trim())).any(|a| a == wanted);
            assert!(found, "{document}: {page} has no heading #{wanted}");
            checked += 1;
        }
    }
    assert!(checked > 3, "{checked} links");
}

/// Every source file of the core and of the firmware has its place in the map: a module in the list of
/// `core/src/lib.rs`, or its path in ARCHITECTURE.md.
#[test]
fn every_file_of_core_and_firmware_is_named() {
    let root = root();
    let list = fs::read_to_string(root.join("core/src/lib.rs")).unwrap();
    let list: Vec<&str> = list.lines().filter(|line| line.starts_with("//!")).collect();
    let list = list.join("\n");
    let architecture = fs::read_to_string(root.join("ARCHITECTURE.md")).unwrap();
    let mut checked = 0;
    for (path, _) in texts(&["rs"]) {
        let Some((krate, file)) = path.split_once("/src/") else { continue };
        let module = file.trim_end_matches(".rs").trim_end_matches("/mod");
        let test = module.split('/').any(|part| part == "tests");
        if !["core", "firmware"].contains(&krate) || test || path == "core/src/lib.rs" {
            continue;
        }
        let links = [format!("[`{module}`]"), format!("[`mod@{module}`]")];
        let listed = krate == "core" && links.iter().any(|link| list.contains(link));
        assert!(
            listed || architecture.contains(&format!("`{path}`")),
            "{path} is named neither in ARCHITECTURE.md nor in the list of core/src/lib.rs"
        );
        checked += 1;
    }
    assert!(checked > 60, "{checked} files");
}

/// May it be longer? A row of a table may, and what has nowhere to break: a link, a path, a number.
fn may_be_long(line: &str) -> bool {
    let text = line.trim_start().trim_start_matches(['/', '!', '#']).trim_start();
    text.starts_with('|') || !text.trim_start_matches("- ").contains(' ')
}

/// Prose and code wrap; of TOML, whose values are data, the comments do.
#[test]
fn lines_wrap() {
    let long = |line: &str| line.chars().count() > LINE && !may_be_long(line);
    let mut wrong = Vec::new();
    for (path, text) in texts(&["rs", "md", "sh", "py", "toml", "yml"]) {
        let data = path.ends_with(".toml");
        let lines = text.lines().enumerate().filter(|(_, line)| !data || line.trim_start().starts_with('#'));
        wrong.extend(lines.filter(|(_, line)| long(line)).map(|(k, _)| format!("{path}:{}", k + 1)));
    }
    assert!(wrong.is_empty(), "longer than {LINE} characters:\n{}", wrong.join("\n"));
}

/// What the commands of a page write: the flag's file, or a file that is typed in. Names in capitals stand
/// for the reader's own.
fn written(text: &str) -> Vec<String> {
    let flags =
        ["--out", "--record", "--log", "--csv", "--plot", "--image", "--suggest", "--export", "--report"];
    let mut code = String::new();
    let mut fenced = false;
    for line in text.lines() {
        let fence = line.starts_with("```");
        fenced ^= fence;
        if fenced && !fence {
            code += &format!("{}\n", line.split(" # ").next().unwrap_or_default());
        }
    }
    let words: Vec<&str> = code.split_whitespace().collect();
    let writes = |pair: &[&str]| flags.contains(&pair[0]) || pair[0] == ">";
    let names = words.windows(2).filter(|pair| writes(pair)).map(|pair| pair[1].to_owned());
    names.filter(|name| name.contains('.') && name.contains(|c: char| c.is_ascii_lowercase())).collect()
}

/// Whoever follows two pages in one folder loses nothing of the first by the second.
#[test]
fn no_two_pages_write_the_same_file() {
    let mut by_name: std::collections::BTreeMap<String, Vec<String>> = std::collections::BTreeMap::new();
    for (document, text) in texts(&["md"]) {
        // The program's own help shows many commands, each for itself.
        if !document.starts_with("docs/") || document == "docs/commands.md" {
            continue;
        }
        let names: std::collections::BTreeSet<String> = written(&text).into_iter().collect();
        names.into_iter().for_each(|name| by_name.entry(name).or_default().push(document.clone()));
    }
    assert!(by_name.len() > 15, "{by_name:?}");
    by_name.retain(|_, documents| documents.len() > 1);
    assert!(by_name.is_empty(), "{by_name:?}");
}

/// Who tries the commands has no new files to tell from the repository's.
#[test]
fn what_commands_write_by_default_is_ignored() {
    let ignored = fs::read_to_string(root().join(".gitignore")).unwrap();
    let ignored: Vec<&str> = ignored.lines().collect();
    let manual = fs::read_to_string(root().join("docs/commands.md")).unwrap();
    let mut seen = 0;
    for flag in manual.split("--out <").skip(1) {
        let words =
            flag.split("\n      --").next().unwrap_or_default().split("\n#").next().unwrap_or_default();
        let Some((_, name)) = words.split_once("[default: ") else { continue };
        let name = name.split(']').next().unwrap_or_default();
        let ending = Path::new(name).extension().and_then(|e| e.to_str()).unwrap_or_default();
        let lines = [format!("/{name}"), format!("/{name}/"), format!("/*.{ending}")];
        assert!(lines.iter().any(|line| ignored.contains(&line.as_str())), "{name} is not ignored");
        seen += 1;
    }
    assert!(seen >= 5, "only {seen} defaults were found");
    for name in ["/report/", "/*.svg", "/*.csv"] {
        assert!(ignored.contains(&name), "{name}");
    }
}
