#!/usr/bin/env python3
"""The bytes on the wire and in the parameter record, from their description, with nothing of the core's.

Writes frames.txt, which core/tests/wire/main.rs compares with what the core makes; `--check` compares only.
Numbers of a message are 1, 2, 3 and so on in the order of the fields, so that each field shows its place.
What is changed here on purpose comes with another VERSION of the messages or of the record.
"""

import itertools
import pathlib
import struct
import sys
import zlib

MESSAGES_VERSION, RECORD_VERSION = 6, 7
# Of the boot that messages are meant for.
NONCE = 0x89AB_CDEF


def numbers(count, first=1):
    """f32, little endian."""
    return b"".join(struct.pack("<f", first + k) for k in range(count))


def whole(value):
    """An unsigned integer, a variant's number or a length: seven bits a byte, the lowest first."""
    low, rest = value & 0x7F, value >> 7
    return bytes([low | 0x80]) + whole(rest) if rest else bytes([low])


def signed(value):
    """A signed one: 0, -1, 1, -2 and so on as 0, 1, 2, 3."""
    return whole(2 * value if value >= 0 else -2 * value - 1)


def text(value):
    return whole(len(value)) + value.encode()


def counting():
    """A function that gives the next so many numbers, from 1 on."""
    number = itertools.count(1)
    return lambda count: b"".join(numbers(1, next(number)) for _ in range(count))


def controller(f):
    """`ControllerSettings` with everything that may be there."""
    some = b"\x01"
    settings = whole(0) + f(4)  # law: backstepping
    settings += whole(0) + f(2)  # estimator: filtered derivative
    settings += some + f(2) + some + f(2) + some + f(2) + some + f(2)  # filter
    settings += whole(2) + f(1)  # allocation: weighted
    return settings + some + f(1) + some + f(2)  # lead, cancellation


def numbered_record():
    """`Parameters` with everything that may be there: see record.rs."""
    some, f = b"\x01", counting()
    settings = f(1) + f(25) + f(4) + f(2)  # sample time, model, effectiveness, volts limit
    settings += some + f(4)  # current limit
    settings += controller(f)
    encoders = f(1) + signed(-1) + f(1) + signed(300)
    limits = f(5) + whole(500) + whole(1) + whole(2_000) + f(1) + f(14)  # lost link: hold, 2,000 ticks
    return settings + encoders + limits + some + whole(1)  # checked, at a simulated rig


def to_board():
    nonce = whole(NONCE)
    yield "alive", whole(0)
    yield "identify", whole(1)
    yield "disarm", whole(2)
    yield "setpoint", whole(3) + numbers(6)
    yield "zero", whole(4)
    yield "arm", whole(5) + nonce
    yield "clear-fault", whole(6) + nonce
    yield "check", whole(7) + nonce
    yield "telemetry", whole(8) + whole(1000)
    yield "read-parameters", whole(9)
    yield "write-parameters", whole(10) + nonce + numbered_record()
    sample = whole(70_000) + signed(-3) + signed(1_000_000) + numbers(2)
    yield "replay", whole(11) + sample + b"\x00"
    yield "replay-wanted", whole(11) + sample + b"\x01" + numbers(6, 3)
    yield "trial", whole(12) + nonce + controller(counting()) + whole(100) + whole(30_000)
    yield "accept", whole(13) + nonce
    yield "revert", whole(14)
    yield "save", whole(15) + nonce
    yield "inject-rest", whole(16) + nonce + whole(0)
    # Swapped, reversed, open motors; swapped, reversed, stuck encoders; slip; drift.
    faults = b"\x01" + b"\x00\x01" + b"\x01\x00" + b"\x00" + b"\x01\x00" + b"\x00\x01"
    faults += signed(40) + signed(-40) + signed(0) + signed(1)
    yield "inject-wiring", whole(16) + nonce + whole(1) + faults
    yield "inject-supply", whole(16) + nonce + whole(2) + numbers(1)
    yield "inject-disturbance", whole(16) + nonce + whole(3) + numbers(2)
    yield "inject-current-limit", whole(16) + nonce + whole(4) + b"\x01"
    yield "inject-emergency-stop", whole(16) + nonce + whole(5) + b"\x01"
    yield "inject-weight", whole(16) + nonce + whole(6) + numbers(2)
    yield "inject-stall", whole(16) + nonce + whole(7) + b"\x03"


def to_host():
    tail = numbers(15) + whole(40_000) + b"\x07" + whole(1) + whole(2) + b"\x32"
    conditions = whole(1 << 23 | 1 << 4 | 1)
    for number, state in enumerate(["disarmed", "ready", "checking", "armed"]):
        yield f"frame-{state}", whole(0) + whole(86_400_000) + whole(number) + conditions + tail
    for number in range(27):
        yield f"frame-fault-{number}", whole(0) + whole(1) + whole(4) + whole(number) + whole(0) + tail
    yield "health", whole(1) + whole(1) + whole(2) + whole(3) + whole(150_000) + whole(4) + whole(16_384)
    serial = bytes(range(1, 13))
    identity = whole(2) + text("0.1.0") + text("stm32f405rg") + serial + whole(1) + whole(RECORD_VERSION)
    boot = whole(NONCE) + whole(300)
    yield "identity", identity + whole(0) + boot + b"\x00"
    yield "identity-reset", identity + whole(1) + boot + b"\x01" + whole(20) + whole(0x0801_2345) + whole(7)
    yield "identity-other-version", identity + whole(2) + whole(4) + boot + b"\x00"
    yield "identity-damaged", identity + whole(3) + boot + b"\x00"
    yield "parameters", whole(3) + numbered_record()
    yield "saved", whole(4)
    yield "verdict-passed", whole(5) + whole(0)
    for number, motor in enumerate(["main", "tail"]):
        yield f"verdict-no-motion-{motor}", whole(5) + whole(1) + whole(number)
    for number in range(7):
        yield f"verdict-wrong-{number}", whole(5) + whole(2) + whole(number)
    yield "verdict-restless", whole(5) + whole(3)
    yield "replayed", whole(6) + whole(9) + numbers(6) + b"\x00"
    yield "replayed-wanted", whole(6) + whole(9) + numbers(6) + b"\x01" + numbers(2, 7)
    for number, refusal in enumerate(["motors-may-turn", "no-replay", "busy", "nonce", "no-parameters"]):
        yield f"refused-{refusal}", whole(7) + whole(number)
    yield "refused-setpoint", whole(7) + whole(5) + text("setpoint.angle.pitch") + numbers(2)
    yield "refused-flash", whole(7) + whole(6)
    yield "refused-range", whole(7) + whole(7) + text("limits.pitch") + text("above 0")
    for number, refusal in enumerate(["not-armed", "trial-under-way", "nothing-to-accept"], start=8):
        yield f"refused-{refusal}", whole(7) + whole(number)
    yield "refused-too-often", whole(7) + whole(11) + whole(300)
    yield "refused-not-simulated", whole(7) + whole(12)


def choices():
    yield "law-backstepping", whole(0) + numbers(4)
    yield "law-integral-backstepping", whole(1) + numbers(8)
    yield "law-pid", whole(2) + numbers(6)
    yield "law-state-feedback", whole(3) + numbers(13) + b"\x01"
    yield "law-super-twisting", whole(4) + numbers(8)
    signals = whole(4) + whole(5) + whole(10) + whole(11)
    yield "law-state-space", whole(5) + whole(8) + whole(4) + signals + b"\x01\x01" + numbers(138)
    yield "estimator-filtered-derivative", whole(0) + numbers(2)
    yield "estimator-luenberger", whole(1) + numbers(2)
    yield "estimator-extended-state", whole(2) + numbers(2)
    yield "estimator-observer", whole(3) + numbers(6)
    yield "allocation-clamp", whole(0)
    yield "allocation-scale", whole(1)
    yield "allocation-weighted", whole(2) + numbers(1)


def cobs(plain):
    """Cheshire and Baker, 1999: a code n before n - 1 bytes and a zero; 255 stands for no zero."""
    coded = b""
    runs = plain.split(b"\x00")
    for run in runs:
        while len(run) >= 254:
            coded, run = coded + b"\xff" + run[:254], run[254:]
        coded += bytes([len(run) + 1]) + run
    return coded


def framed(message):
    plain = bytes([MESSAGES_VERSION]) + message
    return cobs(plain + struct.pack("<I", zlib.crc32(plain))) + b"\x00"


def slot(payload):
    """What the first save writes to flash: sequence 0, length, payload padded to words, CRC-32."""
    plain = struct.pack("<II", 0, len(payload)) + payload + b"\xff" * (-len(payload) % 4)
    return plain + struct.pack("<I", zlib.crc32(plain))


def lines():
    for number, (name, message) in enumerate(to_board()):
        yield f"to-board/{name}", framed(whole(40_000 + number) + message)
    for name, message in to_host():
        yield f"to-host/{name}", framed(message)
    for name, payload in choices():
        yield f"choice/{name}", payload
    record = whole(RECORD_VERSION) + numbered_record()
    yield "record/payload", record
    yield "record/slot", slot(record)


def main(arguments):
    path = pathlib.Path(__file__).with_name("frames.txt")
    new = "".join(f"{name} {value.hex()}\n" for name, value in lines())
    if arguments != ["--check"]:
        path.write_text(new, encoding="ascii")
    elif path.read_text(encoding="ascii") != new:
        sys.exit(f"{path} is not what {__file__} writes")


if __name__ == "__main__":
    main(sys.argv[1:])
