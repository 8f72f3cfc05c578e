//! `compare --worst`: plants as files, and how sure a count of failures makes one.

use super::{host_sim, json};
use std::fs;
use std::path::Path;

fn gains() -> String {
    Path::new(env!("CARGO_MANIFEST_DIR")).join("../gains").display().to_string()
}

/// A column of a CSV file, without its head.
fn column(text: &str, name: &str) -> Vec<f64> {
    let place = text.lines().next().unwrap().split(',').position(|head| head == name).expect(name);
    text.lines().skip(1).map(|line| line.split(',').nth(place).unwrap().parse().unwrap()).collect()
}

/// `simulate` flies from the files what was compared: the same error after the same disturbance, on the plant
/// that cost most.
#[test]
fn the_worst_plants_fly_again_from_their_files() {
    let folder = tempfile::tempdir().unwrap();
    let gains = gains();
    let compare = ["compare", "--preset", "aero-lab", "--gains", &gains, "--plants", "12"];
    let more = ["--controllers", "cancelling", "--worst", "worst", "--export", "all.csv", "--json"];
    let told = json(folder.path(), &[&compare[..], &more].concat());
    let all = fs::read_to_string(folder.path().join("all.csv")).unwrap();
    let costs = column(&all, "cost");
    for (k, name) in ["ours", "cancelling"].into_iter().enumerate() {
        assert_eq!(told["controllers"][k]["failures"], 0, "{name}");
        let own = 12 * k..12 * (k + 1);
        let worst = own.max_by(|a, b| costs[*a].total_cmp(&costs[*b])).unwrap();
        let file = |rest: &str| format!("worst/{name}{rest}.toml");
        let (own, rig, scenario) = (file(""), file("-1"), file("-1-scenario"));
        let simulate = ["simulate", "--preset", "aero-lab", "--fidelity", "rig", "--gains", &own];
        let more = ["--true-rig", &rig, "--scenario", &scenario, "--csv", "flight.csv", "--json"];
        let flown = json(folder.path(), &[&simulate[..], &more].concat());
        assert!(flown["board"]["condition"].is_null());
        let flight = fs::read_to_string(folder.path().join("flight.csv")).unwrap();
        let (time, t_d) = (column(&flight, "t"), 5.0);
        for (axis, state, goal) in [("pitch", "theta", 15.0_f64), ("yaw", "psi", 40.0)] {
            let angle = column(&flight, state);
            let after = time.iter().zip(&angle).filter(|(t, _)| **t >= t_d - 1e-9);
            let squares: Vec<f64> = after.map(|(_, angle)| (angle.to_degrees() - goal).powi(2)).collect();
            let rms = (squares.iter().sum::<f64>() / squares.len() as f64).sqrt();
            let told = column(&all, &format!("disturbance_rms_deg_{axis}"))[worst];
            assert!((rms / told - 1.0).abs() < 1e-4, "{name} {axis}: {rms} here, {told} compared");
        }
    }
}

/// None of twelve: 1 - 5 %^(1/12).
#[test]
fn a_count_of_failures_comes_with_the_probability_that_it_excludes() {
    let folder = tempfile::tempdir().unwrap();
    let gains = gains();
    let args = ["compare", "--preset", "aero2", "--gains", &gains, "--plants", "12", "--controllers", "ours"];
    let told = json(folder.path(), &[&args[..], &["--json"]].concat());
    let bound = told["controllers"][0]["failure_bound"].as_f64().unwrap();
    assert!((bound - (1.0 - 0.05_f64.powf(1.0 / 12.0))).abs() < 1e-9, "{bound}");
    let shown = String::from_utf8(host_sim(folder.path(), &args).stdout).unwrap();
    assert!(shown.contains("2.2e-1") && shown.contains("95 % sure"), "{shown}");
    // A folder that cannot be is told before anything is flown.
    fs::write(folder.path().join("file"), "").unwrap();
    let ended = host_sim(folder.path(), &[&args[..], &["--worst", "file/in"]].concat());
    assert_eq!(ended.status.code(), Some(2), "{}", String::from_utf8_lossy(&ended.stderr));
}
