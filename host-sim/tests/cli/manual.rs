//! docs/commands.md is the program's own help.
//! `TWINROTOR_RENEW=1 cargo test -p host-sim --test cli manual` writes it anew.

use std::fmt::Write;
use std::fs;
use std::path::Path;
use std::process::Command;

const HEAD: &str = "# Commands\n
Every command with its flags, as `--help` prints them. `host-sim` stands for `cargo run --release -p host-sim
--`. What a build lacks (a feature of Cargo) names the line to type.
`cargo run -p host-sim --features manual -- manual --out FOLDER` writes manual pages and completions for bash,
zsh, fish, elvish and PowerShell.\n
This file is written by `TWINROTOR_RENEW=1 cargo test -p host-sim --test cli manual`.\n";

fn help(args: &[&str]) -> String {
    // As wide as the repository's lines at most, wherever the test runs.
    let told =
        Command::new(env!("CARGO_BIN_EXE_host-sim")).args(args).env("COLUMNS", "100").output().unwrap();
    assert!(told.status.success());
    String::from_utf8(told.stdout).unwrap()
}

/// What stands under `Commands:`.
fn commands(all: &str) -> Vec<&str> {
    let below = all.split("Commands:\n").nth(1).unwrap().lines().take_while(|line| !line.is_empty());
    let names = below.filter_map(|line| line.strip_prefix("  ")?.split(' ').next());
    names.filter(|name| !name.is_empty() && *name != "help").collect()
}

/// Of the build that a newcomer has: help does not depend on features.
#[test]
fn the_documents_commands_are_the_programs() {
    let all = help(&["--help"]);
    let mut text = HEAD.to_owned();
    write!(text, "\n```text\n{all}```\n").unwrap();
    for command in commands(&all) {
        write!(text, "\n## {command}\n\n```text\n{}```\n", help(&[command, "--help"])).unwrap();
    }
    let text: String = text.lines().map(|line| format!("{}\n", line.trim_end())).collect();
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/commands.md");
    if std::env::var_os("TWINROTOR_RENEW").is_some() {
        fs::write(&path, &text).unwrap();
    }
    let written = fs::read_to_string(&path).unwrap_or_default();
    assert!(written == text, "docs/commands.md is out of date: run this test with TWINROTOR_RENEW=1");
}

/// A page and a completion for each shell, of the program as it is; whoever lacks them is told how to get
/// them.
#[test]
fn manual_pages_and_completions_are_written() {
    let folder = tempfile::tempdir().unwrap();
    let out = super::host_sim(folder.path(), &["manual", "--out", "manual"]);
    if !cfg!(feature = "manual") {
        assert_eq!(out.status.code(), Some(2));
        assert!(String::from_utf8_lossy(&out.stderr).contains("--features manual"));
        return;
    }
    assert!(out.status.success(), "{}", String::from_utf8_lossy(&out.stderr));
    let read = |name: &str| fs::read_to_string(folder.path().join("manual").join(name)).unwrap();
    for command in commands(&help(&["--help"])) {
        let page = read(&format!("host-sim-{command}.1"));
        assert!(page.contains(".SH OPTIONS") && page.contains(command), "{command}");
        assert!(read("host-sim.bash").contains(command) && read("host-sim.fish").contains(command));
    }
    assert!(read("host-sim.1").contains("Exit status"));
    assert!(read("_host-sim").starts_with("#compdef host-sim") && read("_host-sim.ps1").len() > 1_000);
}
