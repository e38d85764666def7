"""Models, measurements and commands for `measure.py`, each in a folder of its own."""

import math
import random
import subprocess
from pathlib import Path

EXAMPLES = Path(__file__).resolve().parents[2] / "examples"
SUPPORT = EXAMPLES / "frictional-support"

CONTACT = """schema = "stickslip.model/1"
kind = "contact"
[contact]
law = "jenkins"
tangential_stiffness = 2.2e6
friction_coefficient = 0.5
normal_load = 100.0
[fit]
free = ["contact.*"]
"""
VELOCITY_WEAKENING = """[[effect]]
id = "velocity_weakening"
weakening = 0.4
weakening_velocity = 0.05
"""


def chain(masses, contact=""):
    """A chain of masses, held at one end."""
    model = 'schema = "stickslip.model/1"\nkind = "oscillator"\nexcitation = { at = "m1" }\n'
    for mass in range(1, masses + 1):
        before = f"m{mass - 1}" if mass > 1 else "ground"
        model += (f'[[mass]]\nname = "m{mass}"\nmass = 1.0\n'
                  f'[[spring]]\nbetween = ["{before}", "m{mass}"]\nstiffness = 1e4\ndamping = 1.0\n')
    return model + contact


def law(at, stiffness, kind="jenkins", more=""):
    return (f'[contact]\nat = "{at}"\nlaw = "{kind}"\ntangential_stiffness = {stiffness}\nfriction_coefficient = 0.5\n'
            f"normal_load = 4.0\n{more}")


def loop(rows, seed):
    """A slider's loops with noise, as a table."""
    chance = random.Random(seed)
    lines, slider = ["time [s],displacement [m],force [N]"], 0.0
    for row in range(rows):
        moved = 5e-5 * math.sin(0.02 * row) * (1.0 + 0.3 * math.sin(0.0013 * row + seed))
        force = max(-50.0, min(50.0, 2e6 * (moved - slider)))
        slider = moved - force / 2e6
        lines.append(f"{row * 1e-4:.4f},{moved:.9e},{force + chance.gauss(0.0, 0.3):.6f}")
    return "\n".join(lines) + "\n"


def dataset(folder, rows, records):
    """A dataset of loops."""
    folder.mkdir()
    text = 'schema = "stickslip.dataset/1"\ntitle = "Loops"\n'
    for record in range(records):
        (folder / f"loop-{record}.csv").write_text(loop(rows, record))
        text += f'[[record]]\nfile = "loop-{record}.csv"\nregime = "unknown-initial-state"\n'
    (folder / "dataset.toml").write_text(text)


def frf(model, *range_and_force):
    def prepare(program, folder):
        (folder / "model.toml").write_text(model)
        names = ("--from", "--to", "--force")
        return ["frf", "model.toml", *(word for pair in zip(names, range_and_force) for word in pair), "--json", "frf.json", "--report", "frf.html"]
    return prepare


def loops(rows, records, *words):
    def prepare(program, folder):
        (folder / "model.toml").write_text(CONTACT)
        dataset(folder / "data", rows, records)
        return list(words)
    return prepare


def of_example(*words):
    def prepare(program, folder):
        return [word.replace("SUPPORT", str(SUPPORT)).replace("EXAMPLES", str(EXAMPLES)) for word in words]
    return prepare


def measured(*words):
    """On the records of the virtual rig."""
    def prepare(program, folder):
        subprocess.run([program, "rig", SUPPORT / "rig.toml", "-o", "measured"], cwd=folder, check=True, capture_output=True)
        return [word.replace("SUPPORT", str(SUPPORT)) for word in words]
    return prepare


def systems(*words):
    def prepare(program, folder):
        subprocess.run([program, "fmu", "--out", "fmus"], cwd=folder, check=True, capture_output=True)
        return list(words)
    return prepare


FILES = ["--json", "out.json", "--report", "out.html"]
CASES = {
    "frf, 10 000 masses": frf(chain(10_000, law("m5000", 1e4)), "1", "30", "8"),
    "frf, 10 000 masses, no contact": frf(chain(10_000), "1", "30", "8"),
    "frf, stiff Valanis contact": frf(chain(2, law("m2", 1e9, "valanis", "smoothness = 0.3\n")), "1", "60", "8"),
    "frf, velocity weakening": frf(chain(2, law("m2", 1e4) + VELOCITY_WEAKENING), "1", "60", "8"),
    "import": loops(1_000_000, 1, "import", "data/loop-0.csv", "-o", "imported", "--regime", "unknown-initial-state"),
    "check": loops(200_000, 5, "check", "model.toml", "data", "--json", "out.json"),
    "compare, 1e6 rows": loops(200_000, 5, "compare", "model.toml", "data", *FILES, "--csv", "out"),
    "add": loops(40_000, 4, "add", "model.toml", "micro_slip", "--fit", "data", "-o", "new.toml", *FILES),
    "diagnose": loops(4_000, 6, "diagnose", "model.toml", "data", "-o", "new.toml", *FILES),
    "diagnose, a beam": measured("diagnose", "SUPPORT/jenkins.toml", "measured", "-o", "new.toml", *FILES),
    "identify": measured("identify", "SUPPORT/published.toml", "measured", "-o", "new.toml", "--csv", "contact", *FILES),
    "rig": of_example("rig", "SUPPORT/rig.toml", "-o", "measured"),
    "rig, a pin": of_example("rig", "EXAMPLES/slip-slap/rig.toml", "-o", "measured"),
    "modes": of_example("modes", "SUPPORT/published.toml", "--from", "1e-7", "--to", "1e-3", "--points", "400", *FILES, "--csv", "out.csv"),
    "export": of_example("export", "SUPPORT/published.toml", "-o", "X.fmu"),
    "simulate": systems("simulate", "fmus/BeamWithValanis.ssp", "--stop", "4", "--step", "1e-4", "--out", "r.csv", "--report", "r.html"),
}


def made(program, name, folder):
    """The words of a command, whose files are then in `folder`."""
    return CASES[name](program, folder)
