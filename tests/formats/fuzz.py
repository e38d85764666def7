"""Mutated inputs for every command: no panic, no undocumented exit code, no run over 20 s.

    STICKSLIP=target/release/stickslip python tests/formats/fuzz.py RUNS [SEED] [COMMAND]

Each run takes a model, a dataset and files of `laboratory_files.py`, changes some bytes or words of one of them, and runs a command. What goes
wrong is printed with the seed that makes it again. The exit code is 1 where something went wrong.
"""

import os
import random
import re
import shutil
import subprocess
import sys
import tempfile
import time
from pathlib import Path

from laboratory_files import FILES

LONGEST = 20.0
EXIT_CODES = {
    "compare": {0, 1, 2}, "diagnose": {0, 1, 2, 10, 11, 12, 13, 14}, "add": {0, 1, 2}, "check": {0, 1, 2}, "import": {0, 1, 2},
    "export": {0, 1, 2}, "frf": {0, 1, 2}, "modes": {0, 1, 2}, "lone": {0, 1, 2},
}
CONTACT = """schema = "stickslip.model/1"
kind = "contact"
[contact]
law = "valanis"
tangential_stiffness = 2.0e6
friction_coefficient = 0.5
normal_load = 100.0
smoothness = 0.3
residual_stiffness = 1e4
[[effect]]
id = "backlash"
half_gap = 1e-6
[fit]
free = ["contact.*"]
"""
OSCILLATOR = """schema = "stickslip.model/1"
kind = "oscillator"
mass = [{ name = "m1", mass = 1.0 }, { name = "m2", mass = 0.5 }]
spring = [{ between = ["ground", "m1"], stiffness = 2e5, damping = 5.0 }, { between = ["m1", "m2"], stiffness = 1e5, damping = 3.0 }]
excitation = { at = "m1" }
[contact]
at = "m2"
law = "jenkins"
tangential_stiffness = 1e5
friction_coefficient = 0.5
normal_load = 20.0
"""
DATASET = """schema = "stickslip.dataset/1"
title = "Loops"
[columns]
"Kraft" = { name = "force", unit = "kN", sign = -1, delay = 1e-4 }
[[record]]
file = "loop.csv"
regime = "unknown-initial-state"
noise = { "force" = 0.001 }
[[record]]
file = "loop.csv.copy"
regime = "unknown-initial-state"
use = "confirm"
"""
NUMBERS = ["0", "-1", "1e308", "-1e-308", "nan", "inf", "1e400", "1e-9", "1e9", "", "0x10", "1_000", "99999999999999999999"]


def loop(shift):
    import math
    rows = ["time [s];displacement [mm];Kraft (kN)"]
    slider = 0.0
    for row in range(120):
        moved = 0.05 * math.sin(0.2 * row + shift)
        force = max(-60.0, min(60.0, 3000.0 * (moved - slider)))
        slider = moved - force / 3000.0
        rows.append(f"{row * 1e-3:.4f};{moved:.6f};{-force * 1e-3:.6f}")
    return "\n".join(rows) + "\n"


def mutated(data, chance):
    """Some bytes, words or numbers of `data` changed, moved, doubled or cut."""
    for _ in range(chance.choice([1, 1, 2, 4])):
        kind = chance.randrange(6)
        if not data:
            return b"\x00"
        at = chance.randrange(len(data))
        if kind == 0:
            data = data[:at] + bytes([chance.randrange(256)]) + data[at + 1:]
        elif kind == 1:
            data = data[:at]
        elif kind == 2:
            end = min(len(data), at + chance.randrange(1, 200))
            data = data[:end] + data[at:end] * chance.choice([1, 3]) + data[end:]
        elif kind == 3:
            end = min(len(data), at + chance.randrange(1, 60))
            data = data[:at] + data[end:]
        else:
            numbers = list(re.finditer(rb"-?\d[\d.eE+-]*", data[:20000]))
            if numbers:
                one = chance.choice(numbers)
                data = data[:one.start()] + chance.choice(NUMBERS).encode() + data[one.end():]
    return data


def arguments(command, chance):
    lone = chance.choice(os.listdir("files"))
    oscillator = ["oscillator.toml"]
    return {
        "compare": ["compare", "model.toml", "data", "--json", "out.json", "--report", "out.html", "--csv", "out"],
        "diagnose": ["diagnose", "model.toml", "data", "--effects", "backlash,wear", "--max-effects", "1", "--json", "out.json"],
        "add": ["add", "model.toml", chance.choice(["backlash", "wear", "contact_damping"]), "--fit", "data", "-o", "new.toml"],
        "check": ["check", *chance.choice([["model.toml", "data"], ["model.toml"], oscillator]), "--json", "out.json"],
        "import": ["import", f"files/{lone}", "-o", "imported"],
        "lone": ["compare", "model.toml", f"files/{lone}", "--no-fit"],
        "export": ["export", chance.choice(["model.toml", "oscillator.toml"]), "-o", "X.fmu"],
        "frf": ["frf", *oscillator, "--from", "20", "--to", "200", "--force", "5", "--json", "out.json"],
        "modes": ["modes", *oscillator, "--from", "1e-5", "--to", "1e-3", "--points", "5"],
    }[command]


def run(program, seeds, wanted):
    wrong, slowest = 0, {}
    with tempfile.TemporaryDirectory() as place:
        source = Path(place) / "source"
        source.mkdir()
        small = [one for one in FILES if not one["refused"]]
        for one in small:
            one["write"](source / one["name"])
        for seed in seeds:
            chance = random.Random(seed)
            command = wanted or list(EXIT_CODES)[seed % len(EXIT_CODES)]
            folder = Path(place) / "run"
            shutil.rmtree(folder, ignore_errors=True)
            (folder / "data").mkdir(parents=True)
            (folder / "files").mkdir()
            file = chance.choice(small)["name"]
            texts = {"model.toml": CONTACT.encode(), "oscillator.toml": OSCILLATOR.encode(), "data/dataset.toml": DATASET.encode(),
                     "data/loop.csv": loop(0.0).encode(), "data/loop.csv.copy": loop(0.7).encode(), f"files/{file}": (source / file).read_bytes()}
            changed = f"files/{file}" if command in ("import", "lone") else chance.choice([name for name in texts if "files" not in name])
            # The first run of each command shows that nothing is wrong with what is changed.
            whole = seed < seeds[0] + len(EXIT_CODES)
            if not whole:
                texts[changed] = mutated(texts[changed], chance)
            for name, data in texts.items():
                (folder / name).write_bytes(data)
            os.chdir(folder)
            words = arguments(command, chance)
            begin = time.monotonic()
            try:
                done = subprocess.run([program, *words], capture_output=True, timeout=LONGEST, check=False)
                code, told = done.returncode, done.stderr.decode("utf-8", "replace")
            except subprocess.TimeoutExpired:
                code, told = None, f"over {LONGEST} s"
            slowest[command] = max(slowest.get(command, 0.0), time.monotonic() - begin)
            bad = whole and code in (1, 2) or code not in EXIT_CODES[command] or "panicked" in told or (code == 2 and not told.strip())
            if bad:
                wrong += 1
                print(f"seed {seed}: {' '.join(words)} ({changed} changed): exit code {code}: {told.strip()[:300]}", flush=True)
            os.chdir(place)
    return wrong, slowest


if __name__ == "__main__":
    start = int(sys.argv[2]) if len(sys.argv) > 2 else 0
    which = sys.argv[3] if len(sys.argv) > 3 else None
    failures, times = run(os.path.abspath(os.environ["STICKSLIP"]), range(start, start + int(sys.argv[1])), which)
    print(f"{sys.argv[1]} runs, {failures} wrong; longest:", {name: f"{seconds:.1f} s" for name, seconds in sorted(times.items())})
    sys.exit(failures > 0)
