//! Bytes as text that a script element can hold, seven bits a character: the characters of ASCII, which are
//! one byte each in UTF-8, but for the three that a browser does not give back as they are. Eight characters
//! hold seven bytes; `web/page/septets.js` reads them back.

/// What would become another character (U+0000), a line's end (U+000D) or a tag.
const FORBIDDEN: [char; 3] = ['\0', '\r', '<'];
/// What stands for each of them, in the same order, from here on: two bytes in UTF-8.
const INSTEAD: u32 = 0x100;

/// `bytes` as text; what is missing of the last character's bits is zeros.
pub(super) fn encode(bytes: &[u8]) -> String {
    let mut text = String::with_capacity(bytes.len() / 6 * 7 + 2);
    let (mut bits, mut count) = (0_u32, 0_u32);
    for byte in bytes {
        bits = bits << 8 | u32::from(*byte);
        count += 8;
        while count >= 7 {
            count -= 7;
            text.push(character(bits >> count & 0x7f));
        }
        bits &= (1 << count) - 1;
    }
    if count > 0 {
        text.push(character(bits << (7 - count)));
    }
    text
}

fn character(septet: u32) -> char {
    let character = char::from_u32(septet).expect("one of ASCII's");
    match (0..).zip(FORBIDDEN).find(|(_, forbidden)| *forbidden == character) {
        Some((place, _)) => char::from_u32(INSTEAD + place).expect("a letter"),
        None => character,
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    /// As the page does it.
    fn decode(text: &str) -> Vec<u8> {
        let (mut bits, mut count, mut bytes) = (0_u32, 0, Vec::new());
        for character in text.chars() {
            let code = u32::from(character);
            let septet = if code < 128 { code } else { u32::from(FORBIDDEN[(code - INSTEAD) as usize]) };
            bits = bits << 7 & 0x7fff | septet;
            count += 7;
            if count >= 8 {
                count -= 8;
                bytes.push((bits >> count & 0xff) as u8);
            }
        }
        bytes
    }

    #[test]
    fn what_was_written_is_read_and_ends_no_script() {
        let mut bytes = vec![0xff; 8];
        bytes.extend([0; 9]);
        bytes.extend((0..5_000_u32).map(|k| (k.wrapping_mul(2_654_435_761) >> 13) as u8));
        for length in 0..bytes.len() {
            let text = encode(&bytes[..length]);
            assert_eq!(decode(&text), bytes[..length]);
            assert!(!text.contains(FORBIDDEN));
        }
        // Four characters for three bytes would be the usual way.
        assert!(encode(&bytes).len() < bytes.len() * 6 / 5);
        assert_eq!(encode(&[0, 0x1b, 0xc0]), "\u{100}\u{6}x\u{100}");
    }
}
