//! What a board has otherwise than is asked for: how much of it first, then some of it.

use twinrotor_station::differences::Difference;
use twinrotor_station::session::Write;

/// As many values are told without `--verbose`.
pub(super) const FEW: usize = 5;

/// In lines: how many of `all` settings differ and where, at most so many of them, and what can be done.
pub(super) fn lines(differences: &[Difference], all: usize, most: usize, writing: Write) -> Vec<String> {
    let mut lines = Vec::new();
    match differences.len() {
        0 => lines.push("no setting, but the board has nothing stored: it has them built in".to_owned()),
        count => {
            let groups = groups(differences);
            let told = groups.iter().map(|(group, count)| format!("{count} of {group}"));
            lines.push(format!("{count} of {all} settings: {}", told.collect::<Vec<_>>().join(", ")));
        }
    }
    lines.extend(differences.iter().take(most).map(ToString::to_string));
    let left = differences.len().saturating_sub(most);
    if left > 0 {
        lines.push(format!("and {left} more, which --verbose and --json tell"));
    }
    if writing == Write::Never {
        lines.push("--write puts what is asked for on the board; --preset and --gains ask for it".to_owned());
    }
    lines
}

/// How many differ in each part of a record, in the order of the names.
fn groups(differences: &[Difference]) -> Vec<(&str, usize)> {
    let mut groups: Vec<(&str, usize)> = Vec::new();
    for difference in differences {
        // Controller and model are settings both.
        let depth = if difference.name.starts_with("settings.") { 2 } else { 1 };
        let end = difference.name.match_indices('.').nth(depth - 1).map(|(at, _)| at);
        let group = &difference.name[..end.unwrap_or(difference.name.len())];
        match groups.last_mut() {
            Some((last, count)) if *last == group => *count += 1,
            _ => groups.push((group, 1)),
        }
    }
    groups
}

#[cfg(test)]
mod tests {
    use super::*;

    fn different(names: &[&str]) -> Vec<Difference> {
        let one = |name: &&str| Difference {
            name: (*name).to_owned(),
            here: "1".to_owned(),
            there: "2".to_owned(),
        };
        names.iter().map(one).collect()
    }

    #[test]
    fn how_many_comes_first_then_some_then_what_to_do() {
        let different = different(&[
            "encoders.yaw.rest_counts",
            "limits.command_timeout",
            "settings.controller.allocation",
            "settings.controller.law.pitch.rate",
            "settings.model.mass",
        ]);
        let told = lines(&different, 120, 2, Write::Never);
        let parts = "1 of encoders, 1 of limits, 2 of settings.controller, 1 of settings.model";
        assert_eq!(told[0], format!("5 of 120 settings: {parts}"));
        assert_eq!(told[1], "encoders.yaw.rest_counts: 1 here, 2 on the board");
        assert_eq!(told[3], "and 3 more, which --verbose and --json tell");
        assert!(told[4].starts_with("--write puts what is asked for on the board"));
        assert_eq!(told.len(), 5);
        assert_eq!(lines(&different, 120, usize::MAX, Write::Always).len(), 6);
        assert_eq!(lines(&different, 120, 5, Write::Ask).len(), 6);
    }

    #[test]
    fn a_board_from_the_bag_may_have_built_in_what_is_asked_for() {
        let told = lines(&[], 120, FEW, Write::Ask);
        assert_eq!(told, ["no setting, but the board has nothing stored: it has them built in"]);
    }
}
