#!/usr/bin/env python3
"""Writes core/src/defaults.rs, the controllers that boards boot with, from the gains files in gains/.

With --check it writes nothing and fails if the file is not what it would write. Needs Python 3.11 alone.
"""

import pathlib
import re
import sys
import tomllib

ROOT = pathlib.Path(__file__).resolve().parent.parent
TARGET = ROOT / "core/src/defaults.rs"
# Every preset, in the order of their list.
LIST = re.search(r"pub const ALL: .*?];\n", (ROOT / "core/src/plant/presets.rs").read_text(), re.DOTALL)
PRESETS = re.findall(r'\("([\w-]+)", \w+\)', LIST.group())
WIDTH = 110
LABORATORY = "EstimatorSettings::laboratory(100.0)"

# Which structure holds the gains of one axis, by the law's name.
AXIS_GAINS = {
    "backstepping": "AxisGains",
    "integral-backstepping": "IntegralGains",
    "pid": "PidGains",
    "super-twisting": "SuperTwistingGains",
}
# The order of the fields, where a file sorts them.
ORDER = ["position", "rate", "weight", "surface", "proportional", "integral", "derivative", "width"]


def camel(name):
    return "".join(part.capitalize() for part in name.split("-"))


def pair(table):
    return f"PerAxis::new({table['pitch']!r}, {table['yaw']!r})"


def optional(table, show):
    return "None" if table is None else f"Some({show(table)})"


def braced(indent, head, fields, tail):
    """A structure on one line where that fits, as rustfmt has it."""
    line = f"{indent}{head} {{ {', '.join(fields)} }}{tail}"
    if len(line) <= WIDTH:
        return [line]
    return [f"{indent}{head} {{", *(f"{indent}    {field}," for field in fields), f"{indent}}}{tail}"]


def law(document):
    name = document["controller"]
    if name not in AXIS_GAINS:
        raise SystemExit(f"a board's default of the law '{name}' is not known to {sys.argv[0]}")
    lines = [f"    law: LawSettings::{camel(name)}(PerAxis::new("]
    for axis in ("pitch", "yaw"):
        gains = sorted(document[axis].items(), key=lambda item: ORDER.index(item[0]))
        lines += braced(" " * 8, AXIS_GAINS[name], [f"{field}: {value!r}" for field, value in gains], ",")
    return [*lines, "    )),"]


def choice(field, kind, table, default):
    """An enum with at most one number or pair of numbers."""
    if table is None:
        return [f"    {field}: {default},"]
    if isinstance(table, str):
        return [f"    {field}: {kind}::{camel(table)},"]
    ((name, inner),) = table.items()
    ((key, value),) = inner.items()
    shown = pair(value) if isinstance(value, dict) else repr(value)
    return braced(" " * 4, f"{field}: {kind}::{camel(name)}", [f"{key}: {shown}"], ",")


def controller(name):
    document = tomllib.loads((ROOT / f"gains/{name}.toml").read_text())
    constant = name.upper().replace("-", "_")
    path = f"crate::plant::presets::{constant}"
    lines = [
        f"/// For [`presets::{constant}`]({path}): `gains/{name}.toml`.",
        f"pub const {constant}: ControllerSettings<f64> = ControllerSettings {{",
        *law(document),
        *choice("estimator", "EstimatorSettings", document.get("estimator"), LABORATORY),
    ]
    if shaping := document.get("filter"):
        lines += ["    filter: Some(FilterSettings {", f"        bandwidth: {pair(shaping['bandwidth'])},"]
        for key in ("damping", "advance", "reach"):
            lines.append(f"        {key}: {optional(shaping.get(key), pair)},")
        lines.append("    }),")
    else:
        lines.append("    filter: None,")
    allocation = document.get("allocation")
    lines += choice("allocation", "AllocationSettings", allocation, "AllocationSettings::Clamp")
    lead = optional(document.get("lead"), lambda table: f"Lead {{ factor: {table['factor']!r} }}")
    cancellation = optional(document.get("cancellation"), pair)
    lines += [f"    lead: {lead},", f"    cancellation: {cancellation},", "};", ""]
    return lines, document["controller"]


def generated():
    parts, laws = zip(*(controller(name) for name in PRESETS))
    body = [line for lines in parts for line in lines]
    structures = sorted({AXIS_GAINS[name] for name in laws} - {"AxisGains"} | {"LawSettings"})
    laws_used = "{" + ", ".join(structures) + "}"
    imports = [
        "use crate::allocation::AllocationSettings;",
        "use crate::axes::PerAxis;",
        "use crate::command_filter::FilterSettings;",
        "use crate::controller::ControllerSettings;",
        "use crate::estimator::EstimatorSettings;",
        *(["use crate::gains::AxisGains;"] if "backstepping" in laws else []),
        f"use crate::law::{structures[0] if len(structures) == 1 else laws_used};",
        *(["use crate::lead::Lead;"] if any("Lead {" in line for line in body) else []),
    ]
    head = [
        "//! The controllers that boards boot with, one for each preset: the numbers of the committed gains",
        "//! files, which say how they were tuned. Written by `scripts/generate-defaults.py`; a test of the "
        "host",
        "//! holds the two equal.",
        "",
    ]
    table = [f'    ("{name}", {name.upper().replace("-", "_")}),' for name in PRESETS]
    tail = [
        "/// Every default by its preset's name.",
        f"pub const ALL: [(&str, ControllerSettings<f64>); {len(PRESETS)}] = [",
        *table,
        "];",
        "",
        "/// The default of the preset of this name.",
        "pub fn named(preset: &str) -> Option<ControllerSettings<f64>> {",
        "    ALL.into_iter().find(|(name, _)| *name == preset).map(|(_, controller)| controller)",
        "}",
        "",
    ]
    lines = [*head, *imports, "", *body, *tail]
    assert all(len(line) <= WIDTH for line in lines)
    return "\n".join(lines)


def main():
    text = generated()
    if "--check" not in sys.argv[1:]:
        TARGET.write_text(text)
    elif TARGET.read_text() != text:
        raise SystemExit("core/src/defaults.rs is not what gains/ says: run scripts/generate-defaults.py")


main()
