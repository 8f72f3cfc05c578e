//! Recorded flights beside a board: read by the program for whoever comes by its door, shown by pages that
//! control no more.

use crate::program::{Operator, Program, get, send};
use serde_json::json;
use std::time::Duration;

const FLIGHT: &[u8] = b"t,pitch,yaw,v0,v1\n0,0.25,-1,1,2\n0.001,0.5,-2,3,4\n0.005,0.75,-3,5,6\n";

/// The bytes behind an answer's head, which begins so.
fn body(answer: &[u8], begins: &str) -> Vec<u8> {
    let head = answer.windows(4).position(|four| four == b"\r\n\r\n").unwrap() + 4;
    let text = String::from_utf8_lossy(&answer[..head]);
    assert!(text.starts_with(begins), "{text}");
    answer[head..].to_vec()
}

#[test]
fn a_flight_that_is_sent_comes_back_as_its_rows() {
    let program = Program::start(&[]);
    let (host, path) = (program.host(), format!("{}record", program.path()));
    let origin = format!("http://{host}");
    let post = |lines: &[(&str, &str)], file: &[u8]| send("POST", &host, &path, &host, lines, file);
    let length = FLIGHT.len().to_string();
    let ours = [("Origin", origin.as_str()), ("Content-Length", length.as_str())];

    let came = body(&post(&ours, FLIGHT), "HTTP/1.1 200 OK");
    let rows = twinrotor_web::recorded::read(FLIGHT).unwrap();
    assert_eq!(came, rows.iter().flat_map(|number| number.to_le_bytes()).collect::<Vec<u8>>());
    assert_eq!(rows[1].to_bits(), 0.25_f32.to_degrees().to_bits());

    let broken = b"t,pitch,yaw\n0,up,0\n";
    let length = broken.len().to_string();
    let told = post(&[("Origin", &origin), ("Content-Length", &length)], broken);
    let told = String::from_utf8(body(&told, "HTTP/1.1 422 ")).unwrap();
    assert_eq!(told, "the recorded flight: line 2: 'up' is no number\n");

    // Longer than is read, of no length, or less than was promised, which is given up with the line.
    let long = post(&[("Origin", &origin), ("Content-Length", "128000001")], b"");
    body(&long, "HTTP/1.1 413 ");
    body(&post(&[("Origin", &origin)], b""), "HTTP/1.1 411 ");
    assert!(post(&[("Origin", &origin), ("Content-Length", "99")], b"t,pitch").is_empty());

    // Any page of a browser can send; only this one is served.
    for lines in
        [vec![ours[1]], vec![("Origin", "null"), ours[1]], vec![("Origin", "http://evil.example"), ours[1]]]
    {
        body(&post(&lines, b""), "HTTP/1.1 403 ");
    }
    body(&send("POST", &host, "/0123/record", &host, &ours, b""), "HTTP/1.1 403 ");
    body(&send("POST", &host, &program.path(), &host, &ours, b""), "HTTP/1.1 405 ");
    assert!(get(&host, &path, &host, &[]).starts_with("HTTP/1.1 404"));
}

#[test]
fn a_page_that_shows_a_record_flies_no_board_and_stops_one() {
    let program = Program::start(&[]);
    let mut page = Operator::enter(&program);
    page.reach("armed");
    let refused = page.look().unwrap_err();
    assert_eq!(refused, "the motors may turn, and a record would hide the board: stop it first");
    page.ask(&json!({ "supervisor": "disarm" })).unwrap();
    page.reach("ready");
    page.look().unwrap();
    page.status();
    assert!(!page.controls && !page.controlled);
    assert!(page.ask(&json!({ "supervisor": "arm" })).unwrap_err().contains("take over first"));
    // Another flies it meanwhile; who looks on may look away, and stops it all the same.
    let mut pilot = Operator::enter(&program);
    pilot.ask(&json!({ "supervisor": "arm" })).unwrap();
    pilot.reach("armed");
    page.look().unwrap();
    page.ask(&json!({ "supervisor": "disarm" })).unwrap();
    pilot.reach("ready");
}

/// What a page said last may have been to arm: the board is armed when nobody controls it any more.
#[test]
fn a_page_that_arms_and_goes_or_looks_away_at_once_leaves_no_board_armed() {
    let program = Program::start(&[]);
    let mut looker = Operator::enter(&program);
    looker.reach("armed");
    looker.ask(&json!({ "supervisor": "disarm" })).unwrap();
    looker.reach("ready");
    for goes in [true, false] {
        let mut pilot = Operator::enter(&program);
        pilot.take();
        pilot.shout(&json!({ "supervisor": "arm" }));
        // A machine that is busy may have armed it before that.
        let stays = !goes && pilot.look().is_ok();
        let pilot = stays.then_some(pilot);
        looker.until("nobody controls", |looker| !looker.controlled);
        std::thread::sleep(Duration::from_millis(200));
        assert_eq!(looker.status()["state"], "ready", "{goes}");
        drop(pilot);
    }
}
