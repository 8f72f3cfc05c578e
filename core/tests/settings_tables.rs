//! docs/settings.md is the core's table of settings.
//! `TWINROTOR_RENEW=1 cargo test -p core --test settings_tables` writes it anew.

use std::fmt::Write;
use std::fs;
use std::path::Path;
use twinrotor::controller::{CHOICES, PARTS};
use twinrotor::settings::Field;

const HEAD: &str = "# Settings\n
Every number of a controller that a person may choose, as the core declares it (`settings!` in
`core/src/settings/declare.rs`). A gains file holds these names; where a name belongs to a choice
(`estimator`, `allocation`), the file has the kind between: `estimator.bandwidth.yaw` is `yaw` in
`[estimator.luenberger.bandwidth]`. \"Typical\" is what a slider offers, the default a start and no tuned
value. The presets' own are in `gains/`. Where both axes have the same row, `*` stands for `pitch` and \
`yaw`.\n
This file is written by `TWINROTOR_RENEW=1 cargo test -p core --test settings_tables`.\n";

/// The fields of both axes are one row.
fn table(text: &mut String, fields: &[Field]) {
    if fields.is_empty() {
        text.push_str("\nNo numbers.\n");
        return;
    }
    text.push_str(
        "\n| name | unit | allowed | typical | default | what it is |\n|---|---|---|---|---|---|\n",
    );
    for field in fields {
        let starred = |part| if part == "pitch" || part == "yaw" { "*" } else { part };
        let parts: Vec<&str> = field.name.split('.').map(starred).collect();
        let has_twin = field.name.split('.').any(|part| part == "pitch");
        if field.name.split('.').any(|part| part == "yaw") {
            continue;
        }
        let name = if has_twin { parts.join(".") } else { field.name.to_owned() };
        let Field { unit, range, typical: [low, high], default, doc, .. } = field;
        let default = if default.is_finite() { default.to_string() } else { "none".to_owned() };
        let allowed = range.allowed();
        writeln!(text, "| `{name}` | {unit} | {allowed} | {low} to {high} | {default} | {doc} |").unwrap();
    }
}

fn document() -> String {
    let mut text = HEAD.to_owned();
    for (choice, kinds) in CHOICES {
        writeln!(text, "\n## {choice}").unwrap();
        for kind in kinds {
            // A link of the API's documentation is no link here.
            let doc =
                kind.doc.replace("; see [`luenberger()`]", "").replace("; see [`extended_state()`]", "");
            writeln!(text, "\n### {}\n\n{doc}", kind.name).unwrap();
            table(&mut text, kind.fields);
        }
    }
    for (part, fields) in PARTS {
        writeln!(text, "\n## {part}").unwrap();
        table(&mut text, fields);
    }
    text
}

#[test]
fn the_documentations_tables_are_the_cores() {
    let path = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs/settings.md");
    let text = document();
    if std::env::var_os("TWINROTOR_RENEW").is_some() {
        fs::write(&path, &text).unwrap();
    }
    let written = fs::read_to_string(&path).unwrap_or_default();
    assert!(written == text, "docs/settings.md is out of date: run this test with TWINROTOR_RENEW=1");
}

/// Both axes have the same row, or the table above would hide one.
#[test]
fn what_holds_for_pitch_holds_for_yaw() {
    let kinds = CHOICES.into_iter().flat_map(|(_, kinds)| kinds).map(|kind| kind.fields);
    for fields in kinds.chain(PARTS.into_iter().map(|(_, fields)| fields)) {
        for field in fields.iter().filter(|field| field.name.contains("pitch") && field.name.contains('.')) {
            let name = field.name.replace("pitch", "yaw");
            let twin = fields.iter().find(|other| other.name == name);
            let as_pitch = twin.map(|twin| Field { name: field.name, ..*twin });
            let alone = field.name == "allocation.pitch_weight";
            assert!(alone || as_pitch == Some(*field), "{}", field.name);
        }
    }
}
