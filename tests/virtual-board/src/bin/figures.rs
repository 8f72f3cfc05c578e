//! Prints the firmware's figures: sizes, instructions of the tick, step by step, and the paper's law in C
//! beside it.

use std::collections::BTreeMap;
use std::process::ExitCode;

use twinrotor::axes::PerAxis;
use twinrotor::link::ToBoard;
use twinrotor::parameters::Parameters;
use twinrotor::plant::presets::{self, Rig};
use virtual_board::figures::{Figures, InFlight};
use virtual_board::firmware::Firmware;
use virtual_board::helicopter::Helicopter;
use virtual_board::machine::{Machine, Setup};
use virtual_board::profile::{self, Profile, STEPS};
use virtual_board::station::Station;
use virtual_board::wiring::TICK;
use virtual_board::{flight, in_c, record};

fn main() -> ExitCode {
    match run() {
        Ok(()) => ExitCode::SUCCESS,
        Err(why) => {
            eprintln!("error: {why}");
            ExitCode::FAILURE
        }
    }
}

fn run() -> Result<(), String> {
    let firmware = Firmware::released().map_err(|why| why.to_string())?;
    let (rig, built_in) = record::tuned(record::BUILT_IN);
    let mut papers = flying(&firmware, &presets::PAPER, record::paper_parameters(&presets::PAPER))?;
    let mut rigs = flying(&firmware, &rig, built_in)?;
    let profiles = [
        Profile::of(&firmware, &mut papers, TICK, 40)?.median(),
        Profile::of(&firmware, &mut rigs, TICK, 40)?.median(),
    ];
    let ours = Profile::of(&firmware, &mut papers, TICK, 40)?.from_reference_to_volts();
    let figures = Figures::new(&firmware, InFlight::measure(&mut papers), InFlight::measure(&mut rigs));
    println!("{figures}\n\n  paper   rig  instructions of the median tick");
    if let Err(why) = profile::compare(firmware.compiler(), &profiles) {
        println!("{why}");
    }
    for (nth, (step, _)) in STEPS.iter().enumerate() {
        println!("{:7} {:5}  {step}", profiles[0][nth], profiles[1][nth]);
    }
    let [paper, rig] = profiles.map(|profile| profile.iter().sum::<u64>());
    println!("{paper:7} {rig:5}  in all\n");
    println!("the paper's law, reference to volts:\n{ours:7}  firmware (model, law, allocation)");
    match in_c::compiler() {
        Some(compiler) => {
            for options in in_c::SAME_BITS.into_iter().chain(in_c::FUSED) {
                println!("{:7}  C, {compiler}, {options}", in_c::measure(options)?.instructions);
            }
        }
        None => println!("{:7}  C, as kept: no arm-none-eabi-gcc here", in_c::KEPT),
    }
    println!("\n  flash   RAM  bytes by module");
    let mut modules: Vec<(String, [u64; 2])> = modules(&firmware).into_iter().collect();
    modules.sort_by_key(|(_, bytes)| std::cmp::Reverse(*bytes));
    for (module, [flash, ram]) in modules {
        println!("{flash:7} {ram:5}  {module}");
    }
    Ok(())
}

/// A board that holds a pose.
fn flying(firmware: &Firmware, rig: &Rig, parameters: Parameters) -> Result<Station, String> {
    let setup = Setup::new(firmware.clone()).with_image(record::ADDRESS, record::image(&[parameters]));
    let supply = rig.volts_limit.main.max(rig.volts_limit.tail);
    let mut station = Station::new(Machine::start(setup, Helicopter::new(rig, supply)));
    flight::take_off(&mut station, &mut |_| {}).map_err(|why| why.to_string())?;
    station.send(&ToBoard::Telemetry { every: 1 });
    station.aim(PerAxis::new(0.1, 0.2));
    station.run(500);
    Ok(station)
}

/// \[bytes\] What each crate takes of flash and RAM, the core and the firmware by module.
fn modules(firmware: &Firmware) -> BTreeMap<String, [u64; 2]> {
    let mut sizes = BTreeMap::<String, [u64; 2]>::new();
    for (name, size, in_ram) in firmware.sizes() {
        let path = name.trim_start_matches(['<', '&']);
        let mut parts = path.split("::");
        let own = parts.next().unwrap_or_default();
        let module = match own {
            "twinrotor" | "firmware" => format!("{own}::{}", parts.next().unwrap_or_default()),
            _ if path.contains("::") => own.to_owned(),
            _ => "the rest (linker and runtime names)".to_owned(),
        };
        sizes.entry(module).or_default()[usize::from(in_ram)] += size;
    }
    sizes
}
