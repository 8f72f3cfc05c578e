//! What help shows below the flags of each command: how it is used, and where more is written.

/// Of one command: lines to type, and its page.
macro_rules! examples {
    ($($name:ident $page:literal: $lines:literal;)*) => {
        $(pub(super) const $name: &str =
            concat!("Examples:\n  ", $lines, "\n\nMore: docs/", $page);)*
    };
}

examples! {
    TUNE "tuning.md":
        "host-sim tune                                   # the paper's search, its step\n\
         \x20 host-sim tune --preset aero2 --objective robust  # gains for a rig, on drawn plants\n\
         \x20 host-sim tune --preset my.toml --objective robust --at-most voltage_variation=80";
    SIMULATE "scenarios.md":
        "host-sim simulate --gains gains.toml --plot step.svg\n\
         \x20 host-sim simulate --preset aero2 --fidelity rig --gains gains/aero2.toml --scenario 3\n\
         \x20 host-sim simulate --preset my.toml --true-rig aero-lab --fidelity rig --gains my-gains.toml";
    FLY "first-flight.md":
        "host-sim fly                                    # a simulated board with an Aero 2\n\
         \x20 host-sim fly --port auto --record run.csv       # a board at a serial port\n\
         \x20 host-sim fly --port auto --trial mine.toml --accept --save";
    MONITOR "page.md":
        "host-sim monitor                                # a simulated board\n\
         \x20 host-sim monitor --port auto                    # a board at a serial port";
    PAGE "page.md":
        "host-sim page --out heli.html                   # after scripts/build-page.sh";
    FLASH "firmware.md":
        "host-sim flash gains.toml --preset aero2        # by a debug probe\n\
         \x20 host-sim flash gains.toml --port /dev/ttyACM0   # over the link\n\
         \x20 host-sim flash gains.toml --image parameters.hex";
    IDENTIFY "identify.md":
        "host-sim identify run.csv --preset aero --out my.toml\n\
         \x20 host-sim identify run.csv --columns pitch=-theta:deg,v0=u_main:mV --validate other.csv";
    COVERAGE "identify.md":
        "host-sim coverage --preset aero2 --rigs 200\n\
         \x20 host-sim coverage --preset aero2 --rigs 200 --checkpoint rigs.bin --resume";
    REPLAY "identify.md":
        "host-sim replay run.csv --preset my.toml --gains my-gains.toml --plot replay.svg";
    COMPARE "own-controller.md":
        "host-sim compare --preset aero2\n\
         \x20 host-sim compare --preset aero2 --controllers ours,mine.toml --scenario gusts.toml --hot\n\
         \x20 host-sim compare --preset aero2 --plants 10000 --shard 3/16 --out part3.bin";
    MERGE "cluster.md":
        "host-sim merge part*.bin                        # after compare --shard";
    PARETO "tuning.md":
        "host-sim pareto --preset aero2 --out front";
    MAP "tuning.md":
        "host-sim map --gains paper --objective ise --parameters pitch.position,pitch.rate\n\
         \x20 host-sim map --preset aero2 --gains mine.toml --parameters pitch.rate,yaw.rate --plot map.png";
    MARGINS "rig-law.md":
        "host-sim margins --preset aero2 --gains gains/aero2.toml";
    REPRODUCE "paper.md":
        "host-sim reproduce                              # report/index.html\n\
         \x20 host-sim reproduce --quick";
    BENCH_TUNERS "tuning.md":
        "host-sim bench-tuners --algorithms fpa-paper,de,cmaes --seeds 20 --plot convergence.svg";
    BENCH "speed.md":
        "host-sim bench";
    MANUAL "commands.md":
        "host-sim manual --out manual";
}

#[cfg(test)]
mod tests {
    use crate::cli::Cli;
    use clap::CommandFactory;
    use std::path::Path;

    /// Every command has one, it is a command line of this program, and the page is there.
    #[test]
    fn examples_can_be_typed() {
        let docs = Path::new(env!("CARGO_MANIFEST_DIR")).join("../docs");
        for command in Cli::command().get_subcommands() {
            let help = command.get_after_help().map(ToString::to_string).unwrap_or_default();
            let lines: Vec<&str> = help.lines().filter(|line| line.starts_with("  host-sim ")).collect();
            assert!(!lines.is_empty(), "{} has no example", command.get_name());
            for line in lines {
                let words = line.split_whitespace().take_while(|word| *word != "#");
                let parsed = Cli::command().try_get_matches_from(words);
                assert!(parsed.is_ok_and(|m| m.subcommand_name() == Some(command.get_name())), "{line}");
            }
            let page = help.rsplit("docs/").next().unwrap();
            assert!(docs.join(page).is_file(), "{}: no docs/{page}", command.get_name());
        }
    }
}
