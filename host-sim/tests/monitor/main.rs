//! `host-sim monitor` over real sockets: who comes in, who controls, and that motors go off, whatever ends
//! it.

mod program;
mod records;
#[path = "../fly/served.rs"]
#[allow(dead_code, reason = "what may go wrong with a board is shared with the tests of fly")]
mod served;

use program::{Operator, Program, get};
use serde_json::json;
use served::{Mishap, Served};
use std::time::{Duration, Instant};

/// By when a page that has gone must have been missed.
const MISSED: Duration = Duration::from_millis(1_500);

#[test]
fn nobody_comes_in_by_another_name_from_another_page_or_without_the_token() {
    let program = Program::start(&[]);
    let (host, path) = (program.host(), program.path());
    let page = get(&host, &path, &host, &[]);
    assert!(page.starts_with("HTTP/1.1 200 OK"), "{page}");
    assert!(page.contains("default-src 'none'; script-src 'self'") && page.contains("</html>"));
    for name in ["app.js", "style.css", "uplot.js"] {
        assert!(get(&host, &format!("{path}{name}"), &host, &[]).starts_with("HTTP/1.1 200 OK"), "{name}");
    }
    assert!(get(&host, &format!("{path}none.js"), &host, &[]).starts_with("HTTP/1.1 404"));
    let socket = format!("{path}socket");
    let upgrade = ("Upgrade", "websocket");
    let port = host.rsplit(':').next().unwrap();
    let rebound = format!("evil.example:{port}");
    let rebound_page = format!("http://{rebound}");
    for (path, named, lines) in [
        ("/", host.as_str(), vec![]),
        ("/app.js", &host, vec![]),
        ("/0123456789abcdef0123456789abcdef/", &host, vec![]),
        (path.as_str(), &rebound, vec![]),
        (&socket, &rebound, vec![upgrade, ("Origin", &rebound_page)]),
        (&socket, &host, vec![upgrade, ("Origin", "http://evil.example")]),
        (&socket, &host, vec![upgrade, ("Origin", "null")]),
        (&socket, &host, vec![upgrade]),
        (&path, &host, vec![("Origin", "http://evil.example")]),
        (&path, &host, vec![("Host", "evil.example")]),
    ] {
        let answer = get(&host, path, named, &lines);
        assert!(answer.starts_with("HTTP/1.1 403 Forbidden"), "{path} {named} {lines:?}: {answer}");
        assert!(!answer.contains("<script"), "{answer}");
    }
}

#[test]
fn alone_a_simulated_rig_flies_within_three_seconds_and_a_word_stops_it_within_a_tenth() {
    let begun = Instant::now();
    let program = Program::start(&[]);
    let mut page = Operator::enter(&program);
    let status = page.status();
    assert!(begun.elapsed() < Duration::from_secs(3), "{:?}", begun.elapsed());
    assert_eq!((&status["state"], &status["simulated"]), (&json!("armed"), &json!(true)), "{status}");
    page.until("it pushes", |page| page.last("main_volts").is_some_and(|volts| volts.abs() > 1.0));
    let said = Instant::now();
    page.ask(&json!({ "supervisor": "disarm" })).unwrap();
    page.until("no volts", |page| {
        page.last("main_volts") == Some(0.0) && page.last("tail_volts") == Some(0.0)
    });
    assert!(said.elapsed() < Duration::from_millis(100), "{:?}", said.elapsed());
    // Two hundred rows a second, none left out.
    let times = page.column("time");
    assert!(times.windows(2).all(|two| (two[1] - two[0] - 0.005).abs() < 2e-3), "{times:?}");
}

#[test]
fn one_page_controls_and_others_look_on_until_they_take_over() {
    let program = Program::start(&[]);
    let mut first = Operator::enter(&program);
    let mut second = Operator::enter(&program);
    first.status();
    second.status();
    assert!(first.controls && !second.controls);
    let refused = second.ask(&json!({ "aim": { "pitch_deg": 5.0, "yaw_deg": 0.0 } })).unwrap_err();
    assert!(refused.contains("another page controls: take over first"), "{refused}");
    second.take();
    first.status();
    assert!(!first.controls && second.controls);
    assert!(first.ask(&json!({ "supervisor": "arm" })).is_err());
    second.ask(&json!({ "aim": { "pitch_deg": 5.0, "yaw_deg": 0.0 } })).unwrap();
    // Anybody may stop it.
    first.ask(&json!({ "supervisor": "disarm" })).unwrap();
    first.reach("ready");
}

#[test]
fn a_page_that_is_closed_or_says_nothing_any_more_is_missed_in_time() {
    let program = Program::start(&[]);
    let mut looker = Operator::enter(&program);
    let mut pilot = Operator::enter(&program);
    pilot.take();
    assert_eq!(looker.status()["state"], "armed");
    // It is there, and says nothing: as a page whose browser was stopped.
    let silent = Instant::now();
    looker.reach("ready");
    assert!(
        silent.elapsed() > Duration::from_millis(700) && silent.elapsed() < MISSED,
        "{:?}",
        silent.elapsed()
    );
    pilot.ask(&json!({ "supervisor": "arm" })).unwrap();
    pilot.reach("armed");
    assert!(looker.controlled && !looker.controls);
    drop(pilot);
    let closed = Instant::now();
    looker.reach("ready");
    // It may take over, and is told that nobody is in its way.
    looker.until("nobody controls", |looker| !looker.controlled && !looker.controls);
    assert!(closed.elapsed() < Duration::from_millis(500), "{:?}", closed.elapsed());
    let told = looker.status()["journal"].to_string();
    assert!(told.contains("not heard for more than a second") && told.contains("was closed"), "{told}");
}

#[cfg(unix)]
#[test]
fn a_signal_ends_it_with_the_motors_seen_off() {
    for signal in ["TERM", "HUP", "INT"] {
        let served = Served::over_tcp(true, Mishap::None);
        let mut program = Program::start(&["--port", &served.port]);
        let mut page = Operator::enter(&program);
        page.fly();
        let (status, told) = program.signal(signal);
        let seen = "error: interrupted; the motors were seen to be off";
        assert_eq!((status, told.trim()), (Some(130), seen), "{signal}");
        assert!(!served.turns(), "{signal}");
    }
    let mut idle = Program::start(&["--port", "sim"]);
    let (status, _) = idle.signal("INT");
    assert_eq!(status, Some(130));
}

/// Every tick from the first answer to the end, in the columns of `fly`; and a format that is none is told
/// before anything turns.
#[cfg(unix)]
#[test]
fn a_record_has_every_tick_until_the_program_ends() {
    let folder = tempfile::tempdir().unwrap();
    let file = folder.path().join("flight.csv");
    let mut program = Program::start(&["--record", file.to_str().unwrap()]);
    let mut page = Operator::enter(&program);
    page.reach("armed");
    let refusal = page.ask(&json!({ "record": true })).unwrap_err();
    assert!(refusal.contains("host-sim monitor --record"), "{refusal}");
    std::thread::sleep(std::time::Duration::from_secs(1));
    let (status, _) = program.signal("INT");
    assert_eq!(status, Some(130));
    let text = std::fs::read_to_string(&file).unwrap();
    let mut lines = text.lines();
    let head: Vec<&str> = lines.next().unwrap().split(',').collect();
    assert_eq!(head[..8], ["t", "pitch", "yaw", "v0", "v1", "ref_pitch", "ref_yaw", "gap"]);
    let gaps: Vec<&str> = lines.map(|line| line.split(',').nth(7).unwrap()).collect();
    assert!(gaps.len() > 900 && gaps.iter().all(|gap| *gap == "0"), "{} rows", gaps.len());
    let last = text.lines().last().unwrap();
    assert!(last.contains(",ready,none,stored"), "motors off at its end: {last}");

    let refused = std::process::Command::new(env!("CARGO_BIN_EXE_host-sim"))
        .args(["monitor", "--record", "flight.xlsx"])
        .output()
        .unwrap();
    let told = String::from_utf8(refused.stderr).unwrap();
    assert!(refused.status.code() == Some(2) && told.contains("--record is 'flight.xlsx'"), "{told}");
}

#[test]
fn a_board_at_a_line_is_zeroed_armed_and_stopped_and_its_settings_are_its_own() {
    let served = Served::over_tcp(true, Mishap::None);
    let program = Program::start(&["--port", &served.port]);
    let mut page = Operator::enter(&program);
    page.fly();
    let refused = page.ask(&json!({ "push": { "main": 1.0, "tail": 0.0 } })).unwrap_err();
    assert!(refused.contains("simulated here"), "{refused}");
    let rows = page.ask(&json!("settings")).unwrap();
    assert_eq!((&rows["name"], &rows["changed"]), (&json!("the board's"), &json!(0)));
    page.ask(&json!({ "supervisor": "disarm" })).unwrap();
    page.reach("ready");
    drop(program);
    assert!(!served.turns());
}

#[test]
fn what_is_wrong_with_a_board_is_told_with_what_to_do() {
    for (mishap, told) in [
        (Mishap::Old, "update the board's firmware"),
        (Mishap::Silent, "is it powered, is this its port, does it run this firmware?"),
    ] {
        let served = Served::over_tcp(true, mishap);
        let program = Program::start(&["--port", &served.port]);
        let mut page = Operator::enter(&program);
        let status = page.wait("it is told", |status| status["trouble"].is_string());
        let trouble = status["trouble"].as_str().unwrap();
        assert!(trouble.ends_with(told), "{mishap:?}: {trouble}");
        drop(program);
        served.turns();
    }
    for (mishap, told) in [
        (Mishap::Reset, "look at the rig, then zero and arm again"),
        (Mishap::Mute, "look at its supply and its cable"),
        (Mishap::HangUp, "plug it in: it is opened again by itself"),
    ] {
        let served = Served::over_tcp(true, mishap);
        let program = Program::start(&["--port", &served.port]);
        let mut page = Operator::enter(&program);
        page.fly();
        let status = page.wait("it is told", |status| status["trouble"].is_string());
        let trouble = status["trouble"].as_str().unwrap();
        assert!(trouble.ends_with(told), "{mishap:?}: {trouble}");
        drop(program);
        assert!(!served.turns(), "{mishap:?}");
    }
}

/// A cable that is pulled and plugged in again: the line is opened by itself, and the board flies once more.
#[test]
fn a_line_that_broke_is_opened_again_and_the_board_flies() {
    let served = Served::over_tcp(true, Mishap::HangUp);
    let (port, at) = (served.port.clone(), served.port.replace("tcp://", ""));
    let program = Program::start(&["--port", &port]);
    let mut page = Operator::enter(&program);
    page.fly();
    page.wait("the break is told", |status| status["trouble"].is_string());
    assert!(!served.turns());
    let again = Served::listening(&at, true, Mishap::None);
    page.fly();
    page.ask(&json!({ "supervisor": "disarm" })).unwrap();
    page.reach("ready");
    drop(program);
    assert!(!again.turns());
}
