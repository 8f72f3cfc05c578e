//! Bytes as text that a script element can hold, five characters for four bytes: base 85 with the characters
//! from `#` to `w`, and `x` for `<`. `web/page/app.js` reads it back.

/// `bytes` as text. Of a last group of n bytes, n + 1 characters are written.
pub(super) fn encode(bytes: &[u8]) -> String {
    let mut text = String::with_capacity(bytes.len() / 4 * 5 + 5);
    for four in bytes.chunks(4) {
        let mut group = [0; 4];
        group[..four.len()].copy_from_slice(four);
        let mut rest = u32::from_be_bytes(group);
        let digits = [52_200_625, 614_125, 7_225, 85, 1].map(|unit| {
            let digit = rest / unit;
            rest %= unit;
            digit
        });
        text.extend(digits.into_iter().take(four.len() + 1).map(character));
    }
    text
}

fn character(digit: u32) -> char {
    match char::from_u32(u32::from('#') + digit) {
        Some('<') | None => 'x',
        Some(character) => character,
    }
}

#[cfg(test)]
mod tests {
    use super::encode;

    /// As the page does it: what is missing of the last group counts as the highest digit.
    fn decode(text: &str) -> Vec<u8> {
        let digit = |c: u8| u64::from(if c == b'x' { b'<' } else { c } - b'#');
        let groups = text.as_bytes().chunks(5).flat_map(|group| {
            let at = |k: usize| group.get(k).map_or(84, |c| digit(*c));
            let value = (0..5).fold(0, |sum, k| 85 * sum + at(k));
            u32::try_from(value).unwrap().to_be_bytes().into_iter().take(group.len() - 1)
        });
        groups.collect()
    }

    #[test]
    fn what_was_written_is_read_and_ends_no_script() {
        let mut bytes = vec![0xff; 8];
        bytes.extend((0..5_000_u32).map(|k| (k.wrapping_mul(2_654_435_761) >> 13) as u8));
        for length in 0..bytes.len() {
            let text = encode(&bytes[..length]);
            assert_eq!(decode(&text), bytes[..length]);
            assert!(!text.contains('<') && text.len() <= length * 5 / 4 + 2);
        }
        assert_eq!(encode(&[0, 0, 0, 0]), "#####");
    }
}
