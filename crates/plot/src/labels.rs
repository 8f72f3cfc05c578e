//! Numbers at an axis.

/// A power of ten, in numbers.
pub(super) fn power(exponent: f64) -> String {
    let value = 10_f64.powf(exponent);
    if (1e-3..1e4).contains(&value) { number(value, 10.0 * value) } else { format!("{value:.0e}") }
}

/// Ranges that three, four and more decimals tell apart, down to where an exponent is easier to read.
const MOST_DECIMALS: usize = 5;

/// With as many decimals as the range needs: its tenth shows a digit.
pub(super) fn number(value: f64, range: f64) -> String {
    let decimals = (0..=MOST_DECIMALS).find(|&d| range >= 20.0 * 0.1_f64.powi(i32::try_from(d).unwrap_or(0)));
    let Some(decimals) = decimals else {
        return if value == 0.0 { "0".to_owned() } else { format!("{value:.1e}") };
    };
    let text = format!("{value:.decimals$}");
    if text.trim_start_matches('-').chars().all(|c| c == '0' || c == '.') {
        format!("{:.decimals$}", 0.0)
    } else {
        text
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn as_many_decimals_as_the_range_needs_and_no_negative_zero() {
        assert_eq!(number(-0.001, 50.0), "0");
        assert_eq!(number(1.25, 1.0), "1.25");
        let small = [(0.015, 0.05), (2e-3, 4e-3), (-3e-4, 5e-4), (2.5e-6, 7e-6)];
        let told = small.map(|(value, range)| number(value, range));
        assert_eq!(told, ["0.015", "0.0020", "-0.00030", "2.5e-6"]);
        assert_eq!((power(-4.0), power(2.0)), ("1e-4".to_owned(), "100".to_owned()));
    }
}
