//! `gains/choices/NAME-pid-same.toml` is PID with all that stands around the law that boards boot with, and
//! with the gains that the law amounts to.

use std::path::Path;
use twinrotor::controller::ControllerSettings;
use twinrotor::defaults;
use twinrotor::law::{IntegralGains, LawSettings, PidGains};
use twinrotor_sim::gains_file::GainsFile;

#[test]
fn the_choices_are_the_defaults_with_another_law() {
    for (name, ours) in defaults::ALL {
        let path =
            Path::new(env!("CARGO_MANIFEST_DIR")).join(format!("../gains/choices/{name}-pid-same.toml"));
        let text = std::fs::read_to_string(path).unwrap();
        let file = GainsFile::load("pid-same.toml", &|_| Ok(text.clone())).unwrap();
        let LawSettings::IntegralBackstepping(law) = ours.law else { panic!("{name} flies another law") };
        let mapped = law.map(|IntegralGains { position, rate, weight, integral }| PidGains {
            proportional: weight + integral + position * rate,
            integral: integral * rate,
            derivative: position + rate,
        });
        let LawSettings::Pid(pid) = file.controller.law else { panic!("{name}: no PID") };
        for (pid, mapped) in [(pid.pitch, mapped.pitch), (pid.yaw, mapped.yaw)] {
            for (pid, mapped) in [
                (pid.proportional, mapped.proportional),
                (pid.integral, mapped.integral),
                (pid.derivative, mapped.derivative),
            ] {
                assert!((pid / mapped - 1.0).abs() < 1e-12, "{name}: {pid} {mapped}");
            }
        }
        assert_eq!(ControllerSettings { law: ours.law, ..file.controller }, ours, "{name}");
    }
}
