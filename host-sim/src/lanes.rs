//! Getting many sets of numbers into lanes.

use twinrotor::lanes::Lanes;
use twinrotor::pipeline::Settings;
use twinrotor::plant::{LaggedRotors, PlantParameters};

/// How many closed loops run side by side: one vector of AVX2. Twice as many ran no faster there and took twice as long to compile.
pub const LANES: usize = 8;

/// A number in each of [`LANES`] closed loops.
pub type Group = Lanes<LANES>;

/// Numbers that belong together, in a fixed order, side by side: lane k is made of `rows[k]`, the last row fills what lanes are left.
/// Calling it once for each number in that order gives that number in every lane.
pub fn columns(rows: &[Vec<f32>]) -> impl FnMut() -> Group {
    let mut index = 0;
    move || {
        let number = Group::from_fn(|lane| rows[lane.min(rows.len() - 1)][index]);
        index += 1;
        number
    }
}

/// Controllers' settings side by side. They may differ in numbers, not in kind.
pub fn gather(settings: &[Settings<f32>]) -> Settings<Group> {
    let rows: Vec<Vec<f32>> = settings
        .iter()
        .map(|s| {
            numbers(|f| {
                s.map(f);
            })
        })
        .collect();
    let mut next = columns(&rows);
    settings[0].map(|_| next())
}

/// Plants' constants side by side.
pub fn gather_plants(plants: &[PlantParameters<f32>]) -> PlantParameters<Group> {
    let rows: Vec<Vec<f32>> = plants
        .iter()
        .map(|p| {
            numbers(|f| {
                p.map(f);
            })
        })
        .collect();
    let mut next = columns(&rows);
    plants[0].map(|_| next())
}

/// Rotors side by side.
pub fn gather_rotors(rotors: &[LaggedRotors<f32>]) -> LaggedRotors<Group> {
    let rows: Vec<Vec<f32>> = rotors
        .iter()
        .map(|r| {
            numbers(|f| {
                r.map(f);
            })
        })
        .collect();
    let mut next = columns(&rows);
    rotors[0].map(|_| next())
}

/// The numbers that `visit` shows its argument.
fn numbers(visit: impl FnOnce(&mut dyn FnMut(f32) -> f32)) -> Vec<f32> {
    let mut seen = Vec::new();
    visit(&mut |x| {
        seen.push(x);
        x
    });
    seen
}
