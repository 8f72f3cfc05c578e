//! The fingerprints of long flights as this machine computes them, one a line: preset, scenario, hash. The
//! tests of the page compare them with a browser's. The argument is how many ticks.

use twinrotor::plant::presets;
use twinrotor_web::same_bits::fingerprint;

fn main() {
    let ticks = std::env::args().nth(1).and_then(|ticks| ticks.parse().ok()).unwrap_or(1_000_000);
    for (preset, _) in presets::ALL {
        for scenario in ["step", "3"] {
            let hash = fingerprint(preset, scenario, ticks).expect("both are there");
            println!("{preset} {scenario} {hash:016x}");
        }
    }
}
