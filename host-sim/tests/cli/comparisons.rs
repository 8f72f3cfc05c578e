//! What a comparison is held against, who is in it, and what is said of tunings that have not ended.

use super::{assert_refused, host_sim, json};
use std::fs;
use std::path::Path;

fn gains() -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../gains").display().to_string()
}

#[test]
fn p_can_be_held_against_any_controller() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let gains = gains();
    let compare =
        ["compare", "--preset", "paper", "--plants", "24", "--gains", &gains, "--controllers", "pid,lqr"];
    let p = |more: &[&str]| {
        let told = json(at, &[&compare[..], &["--json"], more].concat());
        let controllers = told["controllers"].as_array().unwrap().clone();
        let p: Vec<Option<f64>> = controllers.iter().map(|c| c["p_value"].as_f64()).collect();
        (told["against"].as_str().unwrap().to_owned(), p)
    };
    let (first, of_first) = p(&[]);
    let (other, of_lqr) = p(&["--against", "lqr"]);
    assert_eq!((first.as_str(), other.as_str()), ("ours", "lqr"));
    assert!(of_first[0].is_none() && of_first[1].is_some() && of_first[2].is_some());
    // The test is the same from both sides.
    assert!(of_lqr[2].is_none() && of_lqr[0] == of_first[2] && of_lqr[1].is_some());
    let out = host_sim(at, &[&compare[..], &["--against", "lqr"]].concat());
    let table = String::from_utf8(out.stdout).unwrap();
    assert!(table.contains("p: chance of such a difference to lqr"), "{table}");
    let hover = "duration = 3\n[pitch.steps]\njumps = []\n[yaw.steps]\njumps = [[0.5, 20]]\n";
    fs::write(at.join("hover.toml"), hover).unwrap();
    assert_eq!(p(&["--scenario", "hover.toml", "--against", "pid"]).0, "pid");
    let wrong: &[&str] = &[&compare[..], &["--against", "lqi"]].concat();
    assert_refused(at, &[(wrong, "--against is 'lqi'; allowed: one that is compared: ours, pid, lqr")]);
}

/// The flag that is named is the one that was typed, and a name that is none is told what is.
/// (What both take is in `matrices`, and in `src/cli/who.rs`.)
#[test]
fn an_unknown_controller_is_told_alike_by_compare_and_reproduce() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let missing = "--controllers is 'missing.toml'; allowed: 'paper' (Table 4) or the path of a gains file";
    let nobody = "unknown --controllers 'lqj'; did you mean 'lqi'? There are: ours, paper, backstepping";
    let reproduce = |name| ["reproduce", "--quick", "--controllers", name];
    let compare = |name| ["compare", "--preset", "paper", "--plants", "4", "--controllers", name];
    assert_refused(
        at,
        &[
            (&compare("missing.toml"), missing),
            (&reproduce("missing.toml"), missing),
            (&compare("lqj"), nobody),
            (&reproduce("lqj"), nobody),
        ],
    );
}

/// A search that its box has held back says which number is at which bound, wherever it is told.
#[test]
fn a_tuning_that_ends_at_a_bound_says_so() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let tune = ["tune", "--population", "12", "--iterations", "12", "--bounds", "1,5"];
    let told = json(at, &[&tune[..], &["--json"]].concat());
    let ends = told["at_bounds"].as_array().unwrap();
    assert!(!ends.is_empty(), "{told}");
    for end in ends {
        assert_eq!((&end["side"], &end["bound"]), (&"most".into(), &5.0.into()), "{end}");
    }
    let robust = [
        "tune",
        "--objective",
        "robust",
        "--preset",
        "paper",
        "--controller",
        "lqr",
        "--rounds",
        "1",
        "--plants",
        "4",
        "--scenes",
        "step",
        "--at-most",
        "none",
        "--population",
        "10",
        "--iterations",
        "20",
        "--range",
        "1.2",
    ];
    let told = json_of(at, &[&robust[..], &["--json"]].concat());
    let ends = told["at_bounds"].as_array().unwrap();
    assert!(ends.iter().any(|end| end["name"].as_str().unwrap().contains('.')), "{told}");
    let text = String::from_utf8(host_sim(at, &robust).stdout).unwrap();
    let name = ends[0]["name"].as_str().unwrap();
    assert!(text.contains(&format!("warning: {name} = ")) && text.contains("of the last round"), "{text}");
    let compare = [
        "compare",
        "--preset",
        "paper",
        "--plants",
        "4",
        "--controllers",
        "lqr",
        "--tune",
        "1",
        "--gains",
        "g",
    ];
    let told = json(at, &[&compare[..], &["--json"]].concat());
    let tuning = &told["tunings"][0];
    assert_eq!((&tuning["name"], &tuning["rounds"]), (&"lqr".into(), &1.into()), "{told}");
    let text = String::from_utf8(host_sim(at, &compare).stdout).unwrap();
    let unfinished = !tuning["at_bounds"].as_array().unwrap().is_empty() || tuning["failures"] != 0;
    assert_eq!(text.contains("warning: lqr: "), unfinished, "{text}");
}

/// Whatever its exit status, which says what came of flying it once more.
fn json_of(folder: &Path, args: &[&str]) -> serde_json::Value {
    serde_json::from_slice(&host_sim(folder, args).stdout).unwrap()
}

/// The page of a comparison says how it was made, all of it.
#[test]
fn the_page_of_a_comparison_has_its_command() {
    let folder = tempfile::tempdir().unwrap();
    let at = folder.path();
    let args =
        ["compare", "--preset", "paper", "--plants", "4", "--controllers", "pid,lqr", "--spread", ".2"];
    assert!(host_sim(at, &[&args[..], &["--report", "page"]].concat()).status.success());
    let page = fs::read_to_string(at.join("page/index.html")).unwrap();
    assert!(page.contains("host-sim compare --preset paper --plants 4 --controllers pid,lqr --spread .2"));
}
