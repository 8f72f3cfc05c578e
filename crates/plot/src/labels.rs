//! Numbers at an axis.

/// A power of ten, in numbers.
pub(super) fn power(exponent: f64) -> String {
    let value = 10_f64.powf(exponent);
    if (1e-3..1e4).contains(&value) { number(value, 10.0 * value) } else { format!("{value:.0e}") }
}

/// With as many decimals as the range needs.
pub(super) fn number(value: f64, range: f64) -> String {
    let decimals = if range >= 20.0 {
        0
    } else if range >= 2.0 {
        1
    } else if range >= 0.2 {
        2
    } else {
        3
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
        assert_eq!((power(-4.0), power(2.0)), ("1e-4".to_owned(), "100".to_owned()));
    }
}
