//! Motors off, whatever was said on a line before.

use super::Line;
use std::io::Write;
use twinrotor::link::{Decoder, ToBoard, ToHost};
use twinrotor_station::Client;
use twinrotor_station::switch_off::SwitchOff;

/// What there is to say where nobody knows whether a motor turns.
pub const NOT_SEEN: &str = "Disarm was sent again and again, and the board was NOT seen to switch its \
                            motors off: switch off the amplifiers' supply now";

/// Says `Disarm` until the board is seen to have its motors off. Whether it was; if not, that is told on
/// standard error.
pub fn switch_off(line: &mut dyn Line) -> bool {
    let (mut client, mut decoder) = (Client::new(), Decoder::new());
    let mut off = SwitchOff::new(line.now());
    while !off.is_over(line.now()) {
        if off.say(line.now()) {
            client.send(&ToBoard::Disarm);
        }
        let heard = line.exchange(&client.take_outgoing()).unwrap_or_default();
        for frame in heard.iter().filter_map(|&byte| decoder.push::<ToHost>(byte)) {
            if let Ok(ToHost::Frame(frame)) = frame {
                off.hear(&frame);
            }
        }
    }
    if !off.is_seen() {
        let _ = writeln!(std::io::stderr(), "{NOT_SEEN}");
    }
    off.is_seen()
}
