#!/usr/bin/env python3
"""Writes the tables of boards and pins, and a diagram of each wiring, into docs/wiring.md, from the boards'
files in firmware/src/boards/ and their table in core/src/board.rs.

With --check it writes nothing and fails if the document is not what it would write.
"""

import pathlib
import re
import sys

ROOT = pathlib.Path(__file__).resolve().parent.parent
TARGET = ROOT / "docs/wiring.md"
BEGIN = "<!-- from here on by scripts/generate-wiring.py -->\n"
END = "<!-- to here -->\n"
PWM_HZ = 20_000

# What a signal is called, its names in a board's file, and what to watch.
SIGNALS = [
    (
        "pitch encoder A, B",
        ["pitch_a", "pitch_b"],
        "encoder mode 3: 3.3 V, pull-up inside, filtered for 256 counts of the timer, 3 µs at 84 MHz",
    ),
    ("its timer", ["pitch_timer"], ""),
    ("yaw encoder A, B", ["yaw_a", "yaw_b"], "the same"),
    ("its timer", ["yaw_timer"], ""),
    ("timer of the PWM", ["pwm_timer"], "20 kHz, dead time .5 µs"),
    ("main motor PWM", ["main"], ""),
    ("its output of the timer", ["main_output"], "CH3N does what CH1 does elsewhere"),
    ("its complement", ["main_complement"], "CH1N"),
    ("its other direction, with `sign-magnitude`", ["main_reverse"], "CH3"),
    ("tail motor PWM", ["tail"], "CH2"),
    ("its complement", ["tail_complement"], "CH2N"),
    ("its other direction, with `sign-magnitude`", ["tail_reverse"], "CH4"),
    (
        "amplifier enable",
        ["enable"],
        "output, high is on. **A resistor of 10 kΩ to ground**: off while the chip is in reset or has no "
        "supply",
    ),
    (
        "emergency stop",
        ["emergency_stop"],
        "break input of the PWM's timer, and EXTI: a normally **closed** contact to ground; pull-up inside. "
        "Pressed or cut: high, stop. **1 kΩ to 3.3 V and 100 nF to ground** at the pin",
    ),
    (
        "amplifier fault, current limit",
        ["current_limit"],
        "input, open drain, low is a fault; pull-down inside. **10 kΩ to 3.3 V at the amplifiers**, not at "
        "the board: a cut wire is a fault. Both may share it",
    ),
    (
        "supply of the amplifiers",
        ["supply"],
        "ADC1, through 100 kΩ and 10 kΩ to ground: 36.3 V full scale, 33 V where the chip runs at 3.0 V",
    ),
    (
        "serial out, in",
        ["serial_out", "serial_in"],
        "1,000,000 baud, 8N1, 3.3 V. On a Nucleo board this is the ST-LINK's port",
    ),
    ("its port", ["serial"], ""),
    ("status LED", ["led"], "output, high is on; the Black Pill's is lit by a low level"),
]
DIAGRAM = """\
            +5V   GND                                     12..30 V
             |     |                                         |
  pitch  ----+-----+                                  +------+------+
  encoder A -----------[pitch_a] +---------------+[main]--> IN1         |
          B -----------[pitch_b] |               |[main_complement]--> IN2  main   +--- main motor
                             |               |        | amplifier   |
  yaw     A -----------[yaw_a] |               |        +-- EN  FAULT-+--+
  encoder B -----------[yaw_b] |               |            |            |
                             |[chip]|[enable]--+----+            |
  emergency                  |[source]|       |    |            |
  stop (NC) --/ -------[emergency_stop] |               |     10k    |            |
     GND                     |               |       |    |            |
                             |               |      GND   |            |
  USB-serial RX -------[serial_out] |               |[tail]--> IN1            |
             TX -------[serial_in] |               |[tail_complement]--> IN2  tail   ---+--- tail motor
                             |               |        +-- EN  FAULT-+--+
  probe -----------PA13 PA14 |               |                         |
                             +---------------+[current_limit]<-------------------+
  supply --100k--+-----[supply]    [led]--> LED
                10k
                GND
"""


class Board:
    """A board's file, as far as its wiring goes."""

    def __init__(self, path, known):
        text = path.read_text()
        name = re.search(r"known: &board::(\w+)", text).group(1)
        self.path = path.relative_to(ROOT).as_posix()
        self.name, self.chip, self.pwm_hz = known[name]
        self.about = re.match(r"//! (.*?)[:,.] ", text.replace("\n//! ", " ") + " ").group(1)
        number = lambda field: int(re.search(rf"\b{field}: ([\d_]+)", text).group(1).replace("_", ""))
        self.source_hz = number("source_hz")
        self.core_hz = self.source_hz // number("divide") * number("multiply") // number("post_divide")
        self.fed = "Source::External" in text
        button = re.search(r'pin: "(\w+)", pressed_high: (\w+)', text)
        self.button = "none" if button is None else f"{button[1]}, {'high' if button[2] == 'true' else 'low'}"
        wiring = re.search(r"wiring! \{(.*)\}", text, re.DOTALL).group(1)
        self.wires = dict(re.findall(r"(\w+): (\w+)", wiring))


def boards():
    text = (ROOT / "core/src/board.rs").read_text()
    pattern = r'const (\w+): Board =\s+Board \{ name: "(.*?)", chip: "(.*?)", pwm_timer_hz: ([\d_]+)'
    found = re.findall(pattern, text)
    known = {constant: (name, chip, int(hz.replace("_", ""))) for constant, name, chip, hz in found}
    paths = sorted((ROOT / "firmware/src/boards").glob("*.rs"))
    return [Board(path, known) for path in paths if path.name != "mod.rs"]


def table(head, rows):
    lines = [head, ["---"] * len(head), *rows]
    return "".join("| " + " | ".join(cells) + " |\n" for cells in lines)


def diagram(board):
    """Each name in brackets takes the place of as many characters as its column has."""
    cells = dict(board.wires)
    cells["chip"] = f"   {board.chip[:7].upper()}"
    cells["source"] = f"   {board.source_hz // 1_000_000} MHz"
    lines = []
    for line in DIAGRAM.splitlines():
        line = re.sub(r"-\[(\w+)\] ", lambda m: f"- {cells[m[1]]:<4} ", line)
        line = re.sub(r"\|\[(chip|source)\]", lambda m: f"|{cells[m[1]]:<15}", line)
        line = re.sub(r"\|\[(\w+)\]", lambda m: f"| {cells[m[1]]:<4} ", line)
        line = re.sub(r"\+\[(\w+)\]", lambda m: f"+ {cells[m[1]]:<4} ", line)
        line = re.sub(r"\[(\w+)\]", lambda m: f"{cells[m[1]]} ", line)
        lines.append(line.rstrip())
    return "```\n" + "\n".join(lines) + "\n```\n"


def document():
    all_boards = boards()
    facts = table(
        ["board", "what it is", "file", "core", "its clock", "steps of the PWM", "user button, pressed"],
        [
            [
                f"`{b.name}`", b.about, f"`{b.path}`", f"{b.core_hz // 1_000_000} MHz",
                f"{b.source_hz // 1_000_000} MHz {'fed in' if b.fed else 'crystal'}",
                f"{b.pwm_hz // PWM_HZ // 4:,}", b.button,
            ]
            for b in all_boards
        ],
    )
    rows = []
    for signal, names, watch in SIGNALS:
        pins = [", ".join(b.wires.get(name, "none") for name in names) for b in all_boards]
        rows.append([signal, *pins, watch])
    rows.append(["debug probe", *["PA13, PA14"] * len(all_boards), "SWD"])
    names = [f"`{b.name}`" for b in all_boards]
    text = facts + "\n" + table(["signal", *names, "what it is, and what to watch"], rows)
    wirings = {}
    for board in all_boards:
        drawn = (board.chip[:7], board.source_hz, *sorted(board.wires.items()))
        wirings.setdefault(drawn, []).append(board)
    for same in wirings.values():
        names = ", ".join(f"`{b.name}`" for b in same)
        text += f"\n{names}:\n\n{diagram(same[0])}"
    return text


def main():
    before = TARGET.read_text()
    head, rest = before.split(BEGIN)
    _, tail = rest.split(END)
    after = head + BEGIN + "\n" + document() + "\n" + END + tail
    if "--check" in sys.argv[1:]:
        if after != before:
            sys.exit("docs/wiring.md is not what the boards' files say: run scripts/generate-wiring.py")
    else:
        TARGET.write_text(after)


if __name__ == "__main__":
    main()
