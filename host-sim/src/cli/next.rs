//! A command to type next: of this program as it was started, with what the user gave to the one before.

use std::fmt::{Display, Formatter};
use twinrotor::board::Board;

/// The command, word by word.
#[derive(Debug, Clone)]
pub(super) struct Next(Vec<String>);

/// One of this program's commands.
pub(super) fn next(command: &str) -> Next {
    let program = std::env::args().next().filter(|name| !name.is_empty());
    Next(vec![program.unwrap_or_else(|| "host-sim".to_owned()), command.to_owned()])
}

impl Next {
    /// With a value that stands by itself.
    pub(super) fn of(mut self, value: impl Display) -> Self {
        self.0.push(value.to_string());
        self
    }

    /// With a flag that has no value.
    pub(super) fn flag_if(self, flag: &str, given: bool) -> Self {
        if given { self.of(flag) } else { self }
    }

    /// With a flag and its value.
    pub(super) fn with(self, flag: &str, value: impl Display) -> Self {
        self.of(flag).of(value)
    }

    /// For this board.
    pub(super) fn board(self, board: Board) -> Self {
        self.unless(Board::default().name, "--board", board.name)
    }

    /// With a flag whose value is not what the command takes without it.
    pub(super) fn unless(self, usual: &str, flag: &str, value: impl Display) -> Self {
        let value = value.to_string();
        if value == usual { self } else { self.with(flag, value) }
    }
}

/// As a shell reads it.
impl Display for Next {
    fn fmt(&self, f: &mut Formatter<'_>) -> std::fmt::Result {
        let plain = |c: char| c.is_alphanumeric() || "_-+=:,./@%".contains(c);
        let quoted = self.0.iter().map(|word| match word.chars().all(plain) && !word.is_empty() {
            true => word.clone(),
            false => format!("'{}'", word.replace('\'', r"'\''")),
        });
        f.write_str(&quoted.collect::<Vec<_>>().join(" "))
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn it_can_be_typed_as_it_stands() {
        let told = next("fly").unless("sim", "--port", "tcp://[::1]:9").unless("f405", "--board", "f405");
        let told = told.with("--gains", "it's mine.toml").flag_if("--yes", true).flag_if("--json", false);
        let told = told.of("").to_string();
        assert!(told.ends_with(r"fly --port 'tcp://[::1]:9' --gains 'it'\''s mine.toml' --yes ''"), "{told}");
    }
}
