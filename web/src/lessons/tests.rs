//! Each lesson's task is met by doing it, and not before.

use crate::page::Page;
use crate::request::answer;
use serde_json::{Value, json};

/// Asks what must be answered.
fn ask(page: &mut Page, request: &Value) -> Value {
    let told: Value = serde_json::from_slice(&answer(page, request.to_string().as_bytes())).unwrap();
    assert!(told["error"].is_null(), "{request}: {told}");
    told["ok"].clone()
}

fn status(page: &mut Page) -> Value {
    ask(page, &json!({ "status": { "since": 0 } }))
}

/// What a pupil does.
enum Do {
    Draw(&'static str),
    Set(&'static str, f64),
    Fly(&'static str),
    Wind(f32),
}
use Do::{Draw, Fly, Set, Wind};

/// With a board of this rig in the air.
fn airborne(preset: &str) -> Page {
    let mut page = Page::new();
    ask(&mut page, &json!({ "begin": { "preset": preset, "controller": "own" } }));
    page.desk.take_off();
    page.desk.advance(4_000);
    page
}

/// The draft flies from the ground on, as if it had been saved: a lesson is about what it does, not about how
/// it came into force.
fn adopt(page: &mut Page) {
    if ask(page, &json!("settings"))["changed"] == json!(0) {
        return;
    }
    page.desk.advance(5_000);
    ask(page, &json!("try"));
    for _ in 0..200 {
        page.desk.advance(100);
        let told = status(page);
        if told["trial"] == "flying" {
            ask(page, &json!("accept"));
        } else if told["trial"] == "none" && told["unsaved"] == json!(true) {
            let left = ask(page, &json!("settings"))["changed"].clone();
            if left == json!(0) {
                return;
            }
        }
    }
    panic!("not accepted: {}", status(page));
}

fn act(page: &mut Page, action: &Do) {
    match action {
        Draw(controller) => drop(ask(page, &json!({ "draw": { "controller": controller } }))),
        Set(name, value) => drop(ask(page, &json!({ "set": { "name": name, "value": value } }))),
        Wind(main) => drop(ask(page, &json!({ "disturb": { "main": main, "tail": 0.0, "gusts": false } }))),
        Fly(scenario) => {
            adopt(page);
            let flown = status(page)["flights"].as_u64().unwrap();
            ask(page, &json!({ "fly": { "scenario": scenario } }));
            for _ in 0..1_000 {
                page.desk.advance(100);
                let told = status(page);
                if told["flights"].as_u64() > Some(flown) {
                    return;
                }
                assert!(told["state"] == "armed", "{told}");
            }
            panic!("not flown");
        }
    }
}

#[test]
fn each_task_is_met_by_doing_it_and_not_before() {
    let step = || Fly("step");
    let tasks: [(&str, Vec<Do>); 9] = [
        ("aero2", vec![step(), Set("lead.factor", 1.0), step()]),
        ("aero2", vec![step(), Set("estimator.bandwidth.pitch", 30.0), step()]),
        (
            "aero2",
            vec![
                Draw("pid"),
                step(),
                Set("estimator.bandwidth.pitch", 500.0),
                Set("estimator.bandwidth.yaw", 500.0),
                step(),
            ],
        ),
        ("aero2", vec![Draw("pid"), step(), Set("pitch.proportional", 12.0), step()]),
        (
            "aero2",
            vec![
                Draw("paper"),
                Set("pitch.rate", 5.0),
                Set("yaw.rate", 3.0),
                step(),
                Set("pitch.position", 2.1),
                step(),
            ],
        ),
        ("aero2", vec![step(), Draw("pid"), step()]),
        (
            "aero2",
            vec![
                Wind(2.0),
                Set("pitch.integral", 0.0),
                Set("cancellation.pitch", 0.0),
                step(),
                Draw("own"),
                step(),
            ],
        ),
        ("paper", vec![step(), Draw("paper"), Set("pitch.position", 25.0), Set("pitch.rate", 25.0), step()]),
        ("heli", vec![Fly("2"), step()]),
    ];
    let mut wrong = Vec::new();
    for (place, (preset, actions)) in tasks.iter().enumerate() {
        let mut page = airborne(preset);
        let before = ask(&mut page, &json!("lessons"))[place].clone();
        let checks = before["checks"].as_array().unwrap();
        assert!(!checks.is_empty() && checks.iter().all(|check| check["met"] == json!(false)), "{before}");
        let done = std::panic::catch_unwind(std::panic::AssertUnwindSafe(|| {
            actions.iter().for_each(|action| act(&mut page, action));
        }));
        let lesson = ask(&mut page, &json!("lessons"))[place].clone();
        if done.is_err()
            || lesson["checks"].as_array().unwrap().iter().any(|check| check["met"] == json!(false))
        {
            let settings = ask(&mut page, &json!("settings"));
            let rows: Vec<String> = settings["rows"]
                .as_array()
                .unwrap()
                .iter()
                .map(|row| format!("{} {}", row["name"], row["draft"]))
                .collect();
            let flights: Vec<String> = page
                .desk
                .flights()
                .kept()
                .iter()
                .map(|f| format!("{} {:?}", f.controller, f.report))
                .collect();
            wrong.push(format!("{place}: {lesson} {rows:?} {flights:#?}"));
        }
    }
    assert!(wrong.is_empty(), "{}", wrong.join("\n"));
}
