"""What the calls of our FMUs cost beside Modelica's Reference-FMUs and the least C that is an FMU, all in one run.

STICKSLIP names the program; `tests/fmi/test_fmus_of_others.py` has downloaded the FMUs of others. Writes `calls.md` beside it.
"""

import json
import os
import subprocess
import sys
import tempfile
import zlib
from pathlib import Path

from fmpy import extract, read_model_description

HERE = Path(__file__).parent
ROOT = HERE.parents[1]
FLAGS = ["-O2", "-Wall", "-Wextra", "-Werror"]
# Model, its step (s), an output, and an input with the amplitude it moves by.
CONTACTS = ["JenkinsContact", "ValanisContact", "SlipSlapContact"]
OURS = [(name, 1e-3, "force", ("displacement", 3e-5)) for name in CONTACTS]
OTHERS = [
    ("VanDerPol", 1e-2, "x0", None),
    ("Dahlquist", 1e-1, "x", None),
    ("Feedthrough", 1e-1, "Float64_continuous_output", ("Float64_continuous_input", 1.0)),
]


def measured(program, library, guid, resources, step, output, moved):
    words = [program, library, guid, resources, step, output, *(moved or ())]
    done = subprocess.run([str(word) for word in words], check=True, capture_output=True, text=True)
    return json.loads(done.stdout)


def of_fmu(program, file, folder, step, output, moved):
    unpacked = Path(extract(str(file), unzipdir=str(folder / file.stem)))
    description = read_model_description(str(unpacked), validate=False)
    references = {v.name: v.valueReference for v in description.modelVariables}
    library = unpacked / f"binaries/linux64/{description.coSimulation.modelIdentifier}.so"
    moved = moved and (references[moved[0]], moved[1])
    resources = (unpacked / "resources").as_uri()
    return measured(program, library, description.guid, resources, step, references[output], moved), library.read_bytes()


def goals(of):
    jenkins, library = of["JenkinsContact"]
    shortest = lambda found, key: found[key][0]
    step = lambda found: shortest(found, "moving") - shortest(found, "around")
    asked = [("held step of JenkinsContact (ns)", shortest(jenkins, "held"), 8)]
    asked += [(f"derivative of {name}, in moving steps of it", shortest(of[name][0], "derivative") / step(of[name][0]), 1.5) for name in CONTACTS]
    asked += [
        ("JenkinsContact made, initialized and freed (µs)", shortest(jenkins, "instance"), 3),
        ("heap of it (B)", jenkins["bytes"], 1024),
        ("library packed (kB)", len(zlib.compress(library, 9)) / 1e3, 400),
    ]
    yield from ["| goal | at most | found |", "|---|---|---|"]
    for what, found, most in asked:
        yield f"| {what} | {most} | {f'{found:.3g}' if found <= most else f'**{found:.3g}**'} |"


def main():
    others = next((ROOT / "target/fmus-of-others").glob("*/tests/data/reference/fmi2"), None)
    if others is None or "STICKSLIP" not in os.environ:
        sys.exit("STICKSLIP must name the program, and tests/fmi/test_fmus_of_others.py have downloaded the FMUs of others")
    with tempfile.TemporaryDirectory() as place:
        folder = Path(place)
        program, trivial = folder / "measure", folder / "trivial.so"
        subprocess.run(["cc", *FLAGS, HERE / "measure.c", "-o", program, "-ldl"], check=True)
        subprocess.run(["cc", *FLAGS, "-shared", "-fPIC", HERE / "trivial.c", "-o", trivial], check=True)
        rows = [("a spring, the least C", measured(program, trivial, "", "", 1e-3, 1, (0, 3e-5)), trivial.read_bytes())]
        for name, *how in OTHERS:
            rows.append((f"{name} (Reference-FMUs)", *of_fmu(program, others / f"{name}.fmu", folder, *how)))
        for name, *how in OURS:
            file = folder / f"{name}.fmu"
            model = ROOT / f"modelDescription/{name}.toml"
            subprocess.run([os.environ["STICKSLIP"], "export", model, "-o", file], check=True, capture_output=True)
            rows.append((name, *of_fmu(program, file, folder, *how)))
    lines = [
        "# What calls of FMUs cost",
        "",
        "Written by `STICKSLIP=target/release/stickslip target/python/bin/python benches/calls/measure.py`, all in one run: FMI 2.0,",
        "co-simulation, by a program in C. Times are the shortest and, in brackets, the median of 401 batches.",
        "",
        "| FMU | `fmi2DoStep`, inputs held (ns) | `fmi2SetReal`, `fmi2DoStep`, `fmi2GetReal` (ns) | `fmi2GetDirectionalDerivative` (ns) | made, initialized and freed (µs) | heap of an instance (B) | library (kB) | packed (kB) |",
        "|---|---|---|---|---|---|---|---|",
    ]
    for name, found, library in rows:
        pair = lambda key: "{:.3g} ({:.3g})".format(*found[key]) if key in found else "–"
        cells = [name, pair("held"), pair("moving"), pair("derivative"), pair("instance"), f"{found['bytes']:.0f}", f"{len(library) / 1e3:.0f}", f"{len(zlib.compress(library, 9)) / 1e3:.0f}"]
        lines.append("| " + " | ".join(cells) + " |")
    lines += ["", *goals({name: (found, library) for name, found, library in rows})]
    text = "\n".join(lines) + "\n"
    (HERE / "calls.md").write_text(text)
    print(text)


if __name__ == "__main__":
    sys.exit(main())
