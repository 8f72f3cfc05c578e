//! Getting many sets of numbers into lanes.

use twinrotor::lanes::Lanes;
use twinrotor::pipeline::Settings;

/// How many closed loops run side by side: one vector of AVX2. Twice as many ran no faster there and took twice as long to compile.
pub const LANES: usize = 8;

/// A number in each of [`LANES`] closed loops.
pub type Group = Lanes<LANES>;

/// Controllers' settings side by side; the last one fills what lanes are left. They may differ in numbers, not in kind.
pub fn gather(settings: &[Settings<f32>]) -> Settings<Group> {
    let columns: Vec<Vec<f32>> = settings
        .iter()
        .map(|s| {
            let mut numbers = Vec::new();
            s.map(|x| {
                numbers.push(x);
                x
            });
            numbers
        })
        .collect();
    let mut index = 0;
    settings[0].map(|_| {
        let number = Group::from_fn(|lane| columns[lane.min(columns.len() - 1)][index]);
        index += 1;
        number
    })
}
