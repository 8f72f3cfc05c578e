#!/usr/bin/env python3
"""How many instructions of a card a tick takes, without the card.

    scripts/check-ptx.sh && scripts/machine-code.py [TEXT]

NVIDIA's assembler translates the kernels' text with each line's number, its disassembler says which machine
instructions are of which line, and the text's test has left how often a tick executes each line
(target/ptx/tick.*). What a division does beside the usual case, in a subroutine, is not counted. Prints one
line for each generation of cards and preset: instructions a tick, and how many of them are of local memory.
Needs the packages nvidia-cuda-nvcc-cu12 and nvidia-cuda-nvdisasm, which it installs into target/ptx/venv.
"""

import pathlib
import re
import subprocess
import sys

FOLDER = pathlib.Path(__file__).parent.parent / "target/ptx"
KERNEL = "robust_usual"
CARDS = ["sm_75", "sm_80", "sm_90"]
PRESETS = ["paper", "aero2", "aero-lab"]


def tool(name: str, package: str) -> pathlib.Path:
    """The program of this name, of a package that is there or can be had."""
    pattern = f"venv/lib/python*/site-packages/nvidia/*/bin/{name}"
    if not any(FOLDER.glob(pattern)):
        pip = [FOLDER / "venv/bin/python", "-m", "pip", "install", "-q", "--disable-pip-version-check"]
        subprocess.run([*pip, "--no-deps", package], check=True)
    found = next(FOLDER.glob(pattern), None)
    if found is None:
        sys.exit(f"machine-code: {package} has no {name}")
    found.chmod(0o755)
    return found


def numbered(text: str) -> str:
    """The text with a `.loc` before each instruction."""
    lines = []
    for number, line in enumerate(text.splitlines(), 1):
        code = line.split("//")[0].strip()
        if code.endswith(";") and not code.startswith((".", "$")):
            lines.append(f".loc 1 {number} 0")
        lines.append(line)
        if code.startswith(".address_size"):
            lines.append('.file 1 "text"')
    return "\n".join(lines) + "\n"


def blocks(listing: str):
    """Of the kernel's listing each straight piece: lines of the text and names of instructions."""
    line, inside, block = None, False, []
    for text in listing.splitlines():
        if text.startswith(".text."):
            inside, line = KERNEL in text, None
        elif place := re.search(r'//## File "text", line (\d+)', text):
            line = int(place[1])
        elif code := re.match(r"\s+/\*[0-9a-f]{4,}\*/\s+(?:@!?U?P\w+\s+)?([A-Z0-9_]+)", text):
            if inside:
                block.append((line, code[1]))
        if text.rstrip().endswith(":") or (block and block[-1][1] in ("BRA", "CALL", "RET", "EXIT", "BRX")):
            yield block
            block = []
    yield block


def main() -> None:
    text = pathlib.Path(sys.argv[1]) if len(sys.argv) > 1 else FOLDER / "twinrotor.ptx"
    assembler = tool("ptxas", "nvidia-cuda-nvcc-cu12==12.9.86")
    disassembler = tool("nvdisasm", "nvidia-cuda-nvdisasm")
    source, code = FOLDER / "numbered.ptx", FOLDER / "numbered.cubin"
    source.write_text(numbered(text.read_text()))
    for card in CARDS:
        translate = [assembler, "-lineinfo", f"-arch={card}", "-e", KERNEL, source, "-o", code]
        subprocess.run(translate, check=True)
        shown = subprocess.run([disassembler, "-g", "-c", code], check=True, capture_output=True, text=True)
        # A call is of the subroutine that few divisions need.
        pieces = [b for b in blocks(shown.stdout) if all(name != "CALL" for _, name in b)]
        for preset in PRESETS:
            often: dict[int, float] = {}
            for line, _, times in map(str.split, (FOLDER / f"tick.{preset}").read_text().splitlines()):
                often[int(line)] = max(often.get(int(line), 0.0), float(times))
            executed = [(name, often.get(line, 0.0)) for piece in pieces for line, name in piece]
            own = sum(times for name, times in executed if name in ("LDL", "STL"))
            print(f"{card} {preset}: {sum(t for _, t in executed):.0f} a tick, {own:.0f} of local memory")


if __name__ == "__main__":
    main()
