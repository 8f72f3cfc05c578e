//! The way of an operator, by what a page asks and is told.

use crate::page::Page;
use crate::request::answer;
use serde_json::{Value, json};

/// Asks, and gives what is well or what is wrong.
fn ask(page: &mut Page, request: &Value) -> Result<Value, String> {
    let told: Value = serde_json::from_slice(&answer(page, request.to_string().as_bytes())).unwrap();
    match told.get("error") {
        Some(error) => Err(error.as_str().unwrap().to_owned()),
        None => Ok(told["ok"].clone()),
    }
}

fn status(page: &mut Page) -> Value {
    ask(page, &json!({ "status": { "since": 0 } })).unwrap()
}

fn wait(page: &mut Page, ticks: u32, what: &str, done: impl Fn(&Value) -> bool) -> Value {
    for _ in 0..ticks.div_ceil(50) {
        page.desk.advance(50);
        let status = status(page);
        if done(&status) {
            return status;
        }
    }
    panic!("{what}: {}", status(page));
}

fn state(page: &mut Page, ticks: u32, state: &str) -> Value {
    wait(page, ticks, state, |status| status["state"] == state)
}

/// A page whose board flies level.
fn armed() -> Page {
    let mut page = Page::new();
    let lying = wait(&mut page, 2_000, "connected", |status| status["next"] == "check");
    assert!(lying["steps"]["arm"].as_str().unwrap().contains("the encoders have no zero yet"));
    ask(&mut page, &json!({ "supervisor": "check" })).unwrap();
    wait(&mut page, 120_000, "checked", |status| status["next"] == "zero");
    ask(&mut page, &json!("zero")).unwrap();
    let ready = state(&mut page, 61_000, "ready");
    assert_eq!((&ready["next"], &ready["steps"]["arm"]), (&json!("arm"), &Value::Null));
    ask(&mut page, &json!({ "supervisor": "arm" })).unwrap();
    state(&mut page, 500, "armed");
    page
}

fn fly_step(page: &mut Page, flights: u64) -> Value {
    ask(page, &json!({ "fly": { "scenario": "step" } })).unwrap();
    wait(page, 40_000, "flown", |status| status["flights"] == flights);
    ask(page, &json!("flights")).unwrap()
}

#[test]
fn a_board_is_checked_zeroed_armed_flown_and_stopped() {
    let mut page = armed();
    let flights = fly_step(&mut page, 1);
    let report = &flights[0]["report"];
    assert!(report["pitch"]["settling_time_2"].as_f64().unwrap() < 4.0, "{report}");
    assert!(report["main"]["peak_volts"].as_f64().unwrap() <= 18.0, "an Aero 2's limit: {report}");
    let curves = &flights[0]["curves"];
    let last = curves["pitch"].as_array().unwrap().last().unwrap().as_f64().unwrap();
    let wanted = curves["pitch_reference"].as_array().unwrap().last().unwrap().as_f64().unwrap();
    assert!((last - wanted).abs() < 1.0 && wanted.abs() > 1.0, "{last} of {wanted}");
    // The next tick but one after the word, on the board itself.
    ask(&mut page, &json!({ "supervisor": "disarm" })).unwrap();
    page.desk.advance(2);
    assert_eq!(page.desk.bench().unwrap().board.frame().volts, twinrotor::axes::PerMotor::zero());
    state(&mut page, 300, "ready");
}

#[test]
fn a_setting_is_tried_taken_back_tried_and_accepted_and_saved() {
    let mut page = armed();
    let rows = ask(&mut page, &json!("settings")).unwrap();
    let row = rows["rows"][0].clone();
    let (name, value) = (row["name"].as_str().unwrap(), row["draft"].as_f64().unwrap());
    let refused = ask(&mut page, &json!({ "set": { "name": name, "value": -1.0 } })).unwrap_err();
    assert!(refused.contains(name) && refused.contains("allowed: a finite number above 0"), "{refused}");
    ask(&mut page, &json!({ "set": { "name": name, "value": 0.9 * value } })).unwrap();
    // Up to level first: a trial's bound is twice the worst error of late.
    page.desk.advance(4_000);
    ask(&mut page, &json!("try")).unwrap();
    let flying = wait(&mut page, 5_000, "tried", |status| status["trial"] == "flying");
    assert!(flying["steps"]["accept"].is_null() && flying["steps"]["try"].is_string());
    ask(&mut page, &json!("revert")).unwrap();
    wait(&mut page, 2_000, "taken back", |status| status["trial"] == "none");
    let rows = ask(&mut page, &json!("settings")).unwrap();
    assert_eq!((rows["rows"][0]["accepted"].as_f64(), rows["changed"].as_u64()), (Some(value), Some(1)));
    ask(&mut page, &json!("try")).unwrap();
    wait(&mut page, 5_000, "tried", |status| status["trial"] == "flying");
    ask(&mut page, &json!("accept")).unwrap();
    wait(&mut page, 1_000, "accepted", |status| status["trial"] == "none" && status["unsaved"] == true);
    ask(&mut page, &json!({ "supervisor": "disarm" })).unwrap();
    wait(&mut page, 1_000, "to be saved", |status| status["steps"]["save"].is_null());
    ask(&mut page, &json!("save")).unwrap();
    wait(&mut page, 2_000, "saved", |status| status["unsaved"] == false);
    let rows = ask(&mut page, &json!("settings")).unwrap();
    assert_eq!((rows["rows"][0]["saved"].as_f64(), rows["changed"].as_u64()), (Some(0.9 * value), Some(0)));
}

#[test]
fn every_fault_is_answered_by_the_boards_own_supervisor() {
    for (name, _) in super::faults::ALL {
        let mut page = armed();
        page.desk.advance(5_000);
        ask(&mut page, &json!({ "fault": { "name": name, "present": true } })).unwrap();
        if !["supply-dip", "emergency-stop", "link-lost"].contains(&name) {
            // A rig that is still shows no fault of its encoders or cables.
            let _ = ask(&mut page, &json!({ "aim": { "pitch_deg": 10.0, "yaw_deg": 40.0 } }));
        }
        let lost = name == "link-lost";
        if lost {
            wait(&mut page, 1_000, name, |status| status["silent"] == true);
            page.desk.advance(1_000);
            assert_eq!(page.desk.bench().unwrap().board.frame().volts, twinrotor::axes::PerMotor::zero());
        } else {
            let stopped = wait(&mut page, 10_000, name, |status| status["state"] == "fault");
            let cause = stopped["cause"].as_str().unwrap();
            let causes: &[&str] = match name {
                "supply-dip" => &["supply"],
                "emergency-stop" => &["emergency stop"],
                "yaw-stuck" | "yaw-reversed" => &["the yaw encoder does not show"],
                "pitch-stuck" | "pitch-reversed" => &["the pitch encoder does not show"],
                _ => &["encoder does not show", "left its envelope", "jumped further"],
            };
            assert!(causes.iter().any(|words| cause.contains(words)), "{name}: {cause}");
        }
        ask(&mut page, &json!({ "fault": { "name": name, "present": false } })).unwrap();
        wait(&mut page, 8_000, "to be cleared", |status| status["steps"]["clear"].is_null());
        ask(&mut page, &json!({ "supervisor": "clear-fault" })).unwrap();
        wait(&mut page, 2_000, "cleared", |status| status["state"] != "fault");
    }
}

#[test]
fn what_cannot_be_is_told_and_changes_nothing() {
    let mut page = Page::new();
    for (request, told) in [
        (json!({ "begin": { "preset": "aero3", "controller": "own" } }), "did you mean"),
        (json!({ "begin": { "preset": "aero", "controller": "bang" } }), "unknown controller"),
        (json!({ "fly": { "scenario": "step" } }), "arm first"),
        (json!({ "set": { "name": "pitch.speed", "value": 1.0 } }), "pitch.speed"),
        (json!({ "recall": { "number": 3 } }), "trial is 3"),
        (json!({ "load": { "gains_toml": "controller = 1" } }), "gains"),
        (json!("tune-on"), "no search"),
        (json!("launch"), "unknown variant"),
        (json!({ "fault": { "name": "rain", "present": true } }), "unknown fault"),
    ] {
        let error = ask(&mut page, &request).unwrap_err();
        assert!(error.contains(told), "{request}: {error}");
    }
    assert!(answer(&mut page, b"{").starts_with(b"{\"error\""));
    wait(&mut page, 2_000, "connected", |status| status["next"] == "check");
}

#[test]
fn every_preset_can_be_begun_and_its_draft_survives_a_gains_file() {
    for (preset, _) in twinrotor::plant::presets::ALL {
        let mut page = Page::new();
        ask(&mut page, &json!({ "begin": { "preset": preset, "controller": "own" } })).unwrap();
        let status = wait(&mut page, 2_000, preset, |status| status["next"] == "check");
        assert_eq!(status["preset"], preset);
        let toml = ask(&mut page, &json!("export")).unwrap();
        let before = page.desk.tuning().draft;
        ask(&mut page, &json!({ "draw": { "controller": "pid" } })).unwrap();
        assert_ne!(page.desk.tuning().draft, before);
        ask(&mut page, &json!({ "load": { "gains_toml": toml } })).unwrap();
        assert_eq!(page.desk.tuning().draft, before);
    }
}

#[test]
fn rows_come_two_hundred_times_a_second_and_tell_the_time() {
    let mut page = Page::new();
    page.desk.advance(1_000);
    let rows = page.desk.advance(1_000);
    let width = super::samples::COLUMNS;
    assert_eq!((rows, page.desk.samples().len()), (200, 200 * width));
    let times: Vec<f32> = page.desk.samples().iter().step_by(width).copied().collect();
    assert!(times.windows(2).all(|two| (two[1] - two[0] - 0.005).abs() < 1e-5), "{times:?}");
}

/// An operator at a line, at whose other end a desk serves its simulated board, `step` ticks at a time.
struct AtALine {
    page: Page,
    board: Page,
    now: u64,
    said: Vec<u8>,
}

impl AtALine {
    fn new(preset: &str) -> Self {
        let (mut page, mut board) = (Page::new(), Page::new());
        ask(&mut board, &json!({ "begin": { "preset": preset, "controller": "own" } })).unwrap();
        ask(&mut page, &json!({ "line": "opened" })).unwrap();
        Self { page, board, now: 0, said: Vec::new() }
    }

    /// Until it is so; where it is.
    fn until(&mut self, most: u64, what: &str, done: impl Fn(&Value) -> bool) -> Value {
        for _ in 0..most.div_ceil(10) {
            let came = self.board.desk.serve(&self.said, 10).unwrap();
            self.now += 10;
            self.said = self.page.desk.exchange(&came, std::time::Duration::from_millis(self.now));
            let status = status(&mut self.page);
            if done(&status) {
                return status;
            }
        }
        panic!("{what}: {}", status(&mut self.page));
    }

    fn state(&mut self, most: u64, state: &str) -> Value {
        self.until(most, state, |status| status["state"] == state)
    }

    fn ask(&mut self, request: &Value) -> Value {
        ask(&mut self.page, request).unwrap()
    }
}

#[test]
fn a_board_at_a_line_of_the_page_is_flown_stopped_and_missed() {
    let mut line = AtALine::new("aero");
    line.until(2_000, "connected", |status| status["next"] == "check" && status["simulated"] == false);
    line.ask(&json!({ "supervisor": "check" }));
    line.until(120_000, "checked", |status| status["next"] == "zero");
    line.ask(&json!("zero"));
    line.state(61_000, "ready");
    line.ask(&json!({ "supervisor": "arm" }));
    line.state(500, "armed");
    line.ask(&json!({ "fly": { "scenario": "step" } }));
    line.until(40_000, "flown", |status| status["flights"] == 1);
    let ise = line.ask(&json!("flights"))[0]["report"]["pitch"]["ise"].as_f64().unwrap();
    assert!(ise > 0.0 && ise < 1.0, "{ise}");
    // What the line loses of the word to stop is said again.
    line.ask(&json!({ "supervisor": "disarm" }));
    line.page.desk.exchange(&[], std::time::Duration::from_millis(line.now));
    line.state(100, "ready");
    line.ask(&json!({ "supervisor": "arm" }));
    line.state(500, "armed");
    line.ask(&json!({ "line": { "lost": "The device has been lost" } }));
    line.page.desk.exchange(&[], std::time::Duration::from_millis(line.now + 300));
    let lost = status(&mut line.page);
    let told = lost["trouble"].as_str().unwrap();
    assert!(lost["silent"] == true && told.contains("lost; that its motors are off was not seen"), "{told}");
    line.ask(&json!({ "line": "closed" }));
    wait(&mut line.page, 2_000, "simulated", |status| {
        status["simulated"] == true && status["trouble"].is_null() && status["next"] == "check"
    });
}

/// A scenario file says what befalls the rig, and when; with the flight's end the rig is sound again.
#[test]
fn a_scenario_file_is_flown_with_what_it_lets_befall_the_rig() {
    let calm = "duration = 4.0\n[pitch.steps]\njumps = [[1.0, 5]]\n[yaw.steps]\njumps = []\n";
    let fly = |page: &mut Page, more: &str| {
        let toml = format!("{more}\n{calm}");
        ask(page, &json!({ "fly": { "scenario": "mine.toml", "toml": toml } }))
    };
    let mut page = armed();
    fly(&mut page, "").unwrap();
    wait(&mut page, 60_000, "the calm flight", |status| status["flights"] == 1);
    fly(&mut page, "disturbance = { amplitude = [2.0, 0.0], time = [1.0, 4.0] }").unwrap_err();
    let push = "events = { step = [{ volts = [3.0, 0.0], window = [2.0, 4.0] }] }";
    fly(&mut page, push).unwrap();
    let pushes = |page: &mut Page| page.desk.bench().unwrap().board.rig.bench.disturbance.main;
    wait(&mut page, 60_000, "its step", |status| status["flying"]["time"].as_f64() > Some(2.1));
    assert_eq!(pushes(&mut page), 3.0);
    wait(&mut page, 60_000, "the pushed flight", |status| status["flights"] == 2);
    assert_eq!(pushes(&mut page), 0.0);

    fly(&mut page, "inject = [\"supply=5@2\"]").unwrap();
    let cut = state(&mut page, 60_000, "fault");
    assert!(cut["cause"].as_str().unwrap().contains("supply"), "{cut}");
    page.desk.advance(2_000);
    ask(&mut page, &json!({ "supervisor": "clear-fault" })).unwrap();
    assert_ne!(state(&mut page, 5_000, "ready")["state"], "fault");
}
