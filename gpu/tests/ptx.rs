//! The text that the driver gets, read as it gets it: `scripts/build-ptx.sh` has made it.
//!
//! A card computes what this text says. An operation that rounds otherwise than IEEE 754, or two in one,
//! would be other bits than the board's; state in memory would be slow.

use std::path::Path;

/// Kernels, in the order of their names.
const KERNELS: [&str; 5] = ["integral_ideal", "integral_rig", "robust_any", "robust_trace", "robust_usual"];

fn text() -> String {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../target/ptx/twinrotor.ptx");
    std::fs::read_to_string(&path)
        .unwrap_or_else(|e| panic!("{}: {e}: scripts/build-ptx.sh makes it", path.display()))
}

/// Every instruction without its guard, such as `add.rn.f32`.
fn instructions(text: &str) -> impl Iterator<Item = &str> {
    text.lines()
        .map(|line| line.split("//").next().unwrap_or_default().trim())
        .filter(|line| line.ends_with(';') && !line.starts_with('.'))
        .map(
            |line| {
                if line.starts_with('@') { line.split_once(' ').map_or("", |(_, rest)| rest) } else { line }
            },
        )
        .filter_map(|line| line.trim().split([' ', ';']).next())
}

#[test]
fn every_kernel_is_there_under_its_name() {
    let text = text();
    let mut entries: Vec<&str> = text
        .lines()
        .filter_map(|line| line.split_once(".entry ").map(|(_, name)| name.trim_end_matches('(')))
        .collect();
    entries.sort_unstable();
    assert_eq!(entries, KERNELS);
}

/// IEEE 754 alone: no operation is fused, approximated or flushed to zero, and each that rounds says how.
#[test]
fn every_float_operation_rounds_as_the_boards_do() {
    let text = text();
    let all: Vec<&str> = instructions(&text).collect();
    assert!(all.len() > 1000, "the kernels are not empty");
    for instruction in &all {
        let parts: Vec<&str> = instruction.split('.').collect();
        for other in ["fma", "mad", "approx", "ftz", "sat"] {
            let integer = parts[0] == "mad" && !parts.iter().any(|p| p.starts_with('f'));
            assert!(!parts.contains(&other) || (other == "mad" && integer), "{instruction}");
        }
        let rounds = ["add", "sub", "mul", "div", "sqrt", "rcp"].contains(&parts[0]);
        if rounds && parts.iter().any(|p| *p == "f32" || *p == "f64") {
            assert!(parts.contains(&"rn"), "{instruction}");
        }
    }
    for needed in ["div.rn.f32", "mul.rn.f32", "sqrt.rn.f32"] {
        assert!(all.contains(&needed), "{needed}: rigs have friction, laws divide");
    }
    for never in ["sin", "cos", "ex2", "lg2", "tanh", "rsqrt"] {
        assert!(!all.iter().any(|i| i.split('.').next() == Some(never)), "{never} has other bits");
    }
}

/// A function or kernel of the text: its name and its body.
fn functions(text: &str) -> Vec<(&str, &str)> {
    let bodies = text.split("// -- Begin function ").skip(1);
    bodies.filter_map(|part| part.split_once('\n')).map(|(name, body)| (name.trim(), body)).collect()
}

/// What is called is there, and kernels call nothing.
#[test]
fn nothing_is_left_to_be_linked() {
    let text = text();
    let functions = functions(&text);
    assert!(!text.contains(".extern"));
    for (name, body) in &functions {
        // The name called stands before the parameters, behind what comes back.
        let called: Vec<&str> = body
            .lines()
            .filter(|line| line.trim_start().starts_with("call"))
            .filter_map(|line| line.split([' ', ',', ';', '\t']).find(|part| part.starts_with("_R")))
            .collect();
        let calls = instructions(body).filter(|i| i.split('.').next() == Some("call")).count();
        assert_eq!(called.len(), calls, "{name}");
        assert!(calls == 0 || !KERNELS.contains(name), "{name}: {called:?}");
        for other in called {
            assert!(functions.iter().any(|(known, _)| *known == other), "{name} calls {other}");
        }
    }
}

/// \[bytes\] Memory that is a thread's own: none, state is in registers.
#[test]
fn a_thread_has_no_memory_of_its_own() {
    let text = text();
    let own = |body: &str| -> usize {
        let sizes = body.lines().filter(|line| line.contains("__local_depot") && line.contains(".b8"));
        sizes.map(|line| line.split(['[', ']']).nth(1).map_or(0, |n| n.parse().unwrap_or(usize::MAX))).sum()
    };
    for (name, body) in functions(&text) {
        assert_eq!(own(body), 0, "{name}");
    }
    assert!(text.contains(".target sm_75"));
}
