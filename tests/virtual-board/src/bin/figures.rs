use std::collections::BTreeMap;
use twinrotor::axes::PerAxis;
use twinrotor::control_loop::Wish;
use twinrotor::defaults;
use twinrotor::gains::PAPER;
use twinrotor::link::ToBoard;
use twinrotor::parameters::ram_flash::RamFlash;
use twinrotor::parameters::store::{MAX_PAYLOAD, SLOT_SIZE, Store};
use twinrotor::parameters::{Parameters, SAMPLE_TIME};
use twinrotor::pipeline::Settings;
use twinrotor::plant::presets::{self};
use twinrotor::supervisor::{Request, State};
use virtual_board::figures::Figures;
use virtual_board::firmware::Firmware;
use virtual_board::helicopter::Helicopter;
use virtual_board::machine::{Machine, Setup};
use virtual_board::profile::{Profile, STEPS, Source};
use virtual_board::station::Station;

fn main() {
    for options in virtual_board::in_c::OPTIONS {
        println!("{:?}", virtual_board::in_c::measure(options));
    }
    let firmware = Firmware::released().unwrap();
    for (name, rig, settings) in [
        ("paper", presets::PAPER, Settings::paper(&presets::PAPER, PAPER, SAMPLE_TIME)),
        ("rig", presets::AERO2, Settings::new(&presets::AERO2, defaults::AERO2, SAMPLE_TIME)),
    ] {
        let record = Parameters { checked: true, ..Parameters::new(&rig, &settings) };
        let mut store = Store::new(RamFlash::default(), 0);
        let mut buffer = [0; MAX_PAYLOAD];
        store.save(record.encode(&mut buffer).unwrap(), &mut [0; SLOT_SIZE]).unwrap();
        let setup = Setup::new(firmware.clone()).with_image(0x0800_4000, store.into_flash().bytes().to_vec());
        let supply = rig.volts_limit.main.max(rig.volts_limit.tail);
        let mut station = Station::new(Machine::start(setup, Helicopter::new(&rig, supply)));
        station.run(1700);
        station.send(&ToBoard::Control(Wish::Zero));
        station.await_state(200, State::Ready);
        station.aim(PerAxis::new(0.1, 0.2));
        station.run(20);
        station.request(Request::Arm);
        let from = station.machine.with(|b| b.ticks().len());
        station.await_state(100, State::Armed);
        let arming: Vec<u64> =
            station.machine.with(move |b| b.ticks()[from..].iter().map(|t| t.instructions).collect());
        println!("{name}: arming {:?}", arming.iter().max());
        station.run(1500);
        station.send(&ToBoard::Telemetry { every: 1 });
        station.run(100);
        println!("{}", Figures::measure(&firmware, &mut station));
        let profile = Profile::of(&firmware, &mut station, "TIM1_UP_TIM10", 40).unwrap();
        let median = profile.median();
        for ((step, _), n) in STEPS.iter().zip(median) {
            println!("{n:6} {step}");
        }
        println!("{:6}", median.iter().sum::<u64>());
        if let Some(to) = std::env::var_os("PLACES") {
            let source = Source::new(&firmware).unwrap();
            let mut text = String::new();
            for (&a, &(step, n)) in &profile.places {
                let names: Vec<String> = source.frames(a).iter().map(|(n, l)| format!("{n}:{l}")).collect();
                text += &format!(
                    "{a:x} {} {} {}\n",
                    STEPS[step].0.replace(' ', "_"),
                    n as f64 / profile.ticks.len() as f64,
                    names.join(" < ")
                );
            }
            std::fs::write(format!("{}-{name}", to.display()), text).unwrap();
        }
        if std::env::var_os("HOT").is_some() {
            let source = Source::new(&firmware).unwrap();
            let mut by: BTreeMap<(usize, String), u64> = BTreeMap::new();
            let depth: usize = std::env::var("HOT").unwrap().parse().unwrap();
            for (&a, &(step, n)) in &profile.places {
                let f = source.frames(a);
                let names: Vec<String> = f.iter().rev().map(|(n, l)| format!("{n}:{l}")).collect();
                let at = firmware.function(a).unwrap().1.to_owned();
                let key = format!("{at} | {}", names[names.len().saturating_sub(depth)..].join(" > "));
                *by.entry((step, key)).or_default() += n;
            }
            let mut v: Vec<_> = by.into_iter().collect();
            v.sort_by_key(|(_, n)| std::cmp::Reverse(*n));
            for ((step, k), n) in v.iter().take(150) {
                println!("{:8.1} {:12} {k}", *n as f64 / profile.ticks.len() as f64, STEPS[*step].0);
            }
        }
    }
}
