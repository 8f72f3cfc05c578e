//! Out of CSV.

use super::{Flight, NAMES, unusable, without};
use std::str::FromStr;
use twinrotor_sim::Outcome;

/// All rows of a file.
pub(super) fn read(file: &[u8]) -> Outcome<Flight> {
    let text =
        std::str::from_utf8(file).map_err(|_| unusable("it is no text; CSV and MCAP files are read"))?;
    let mut lines = text.lines().zip(1_u32..).filter(|(line, _)| !line.trim().is_empty());
    let (head, _) = lines.next().ok_or_else(|| unusable("the file is empty"))?;
    let head: Vec<&str> = head.split(',').map(str::trim).collect();
    let places = NAMES.map(|names| head.iter().position(|name| !name.is_empty() && names.contains(name)));
    if let Some(missing) = places.iter().take(3).position(Option::is_none) {
        return Err(without(missing));
    }
    let mut flight = Flight::new(head.contains(&"v0"));
    for (line, number) in lines {
        let fields: Vec<&str> = line.split(',').collect();
        let wrong = |why: &str| unusable(&format!("line {number}: {why}"));
        if fields.len() != head.len() {
            return Err(wrong(&format!("{} values for {} columns", fields.len(), head.len())));
        }
        let mut values = [f64::NAN; NAMES.len()];
        for (place, value) in places.iter().zip(&mut values) {
            let Some(field) = place.map(|place| fields[place].trim()) else { continue };
            *value = f64::from_str(field).map_err(|_| wrong(&format!("'{field}' is no number")))?;
        }
        flight.take(&values).map_err(wrong)?;
    }
    Ok(flight)
}
