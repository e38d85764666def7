"""From the records of a rig to an FMU that predicts a level which was not fitted.

STICKSLIP names the program.
"""

import re
import shutil
import subprocess
import sys
from pathlib import Path

import pytest
from test_systems import program, stickslip

ROOT = Path(__file__).parents[2]
EXAMPLE = ROOT / "examples/frictional-support"
sys.path.insert(0, str(EXAMPLE))
from predict import error, predict  # noqa: E402

LEVELS = [20.0, 30.0, 50.0, 60.0, 70.0]
UNSEEN = 40.0
PLAN = """schema = "stickslip.rig/1"
model = "published.toml"

[sensors]
positions = [0.55, 0.3, 0.1]
{chain}

[[stepped_sine]]
name = "level"
amplitude = {levels}
frequency = "resonance"
"""
NOISY = "noise = 0.01\nnoise_told = true\ngain_scatter = 0.01\nseed = 1"


# Two limits, the first reached in stick, and all between them gradual: no law of the library.
UNKNOWN = """[contact]
law = "measured"
tangential_stiffness = 7.0e6
friction_coefficient = 0.7
normal_load = 147.15
""" + "".join(f"slope_kept_{k} = {kept}\n" for k, kept in enumerate([1, 1, 1, 0.3, 1, 1, 0.9, 0.9, 0.9, 0.1, 0.9], 1))


def rig(folder: Path, name: str, chain: str, levels: list[float]) -> None:
    (folder / f"{name}.toml").write_text(PLAN.format(chain=chain, levels=levels))
    stickslip(folder, "rig", f"{name}.toml", "-o", name)


@pytest.mark.parametrize("chain, bound", [("", 0.02), (NOISY, 0.05)], ids=["clean", "noise and gains"])
def test_an_identified_contact_predicts_an_unseen_level_as_an_fmu(tmp_path, chain, bound):
    shutil.copy(EXAMPLE / "published.toml", tmp_path)
    rig(tmp_path, "measured", chain, LEVELS)
    rig(tmp_path, "unseen", "", [UNSEEN])
    stickslip(tmp_path, "identify", "published.toml", "measured", "-o", "identified.toml")
    stickslip(tmp_path, "export", "identified.toml", "-o", "Support.fmu")
    channels = predict(tmp_path / "Support.fmu", tmp_path / "unseen/level.csv", 8)
    assert len(channels) == 3, channels
    for name, pair in channels.items():
        assert error(*pair) < bound, name


def test_a_contact_of_no_law_predicts_an_unseen_level_as_an_fmu(tmp_path):
    beam, _ = (EXAMPLE / "published.toml").read_text().split("[contact]")
    (tmp_path / "published.toml").write_text(beam + UNKNOWN)
    rig(tmp_path, "measured", NOISY, [30.0, 50.0, 70.0])
    rig(tmp_path, "unseen", "", [UNSEEN])
    stickslip(tmp_path, "identify", "published.toml", "measured", "-o", "identified.toml")
    assert 'law = "measured"' in (tmp_path / "identified.toml").read_text()
    stickslip(tmp_path, "export", "identified.toml", "-o", "Support.fmu")
    for name, pair in predict(tmp_path / "Support.fmu", tmp_path / "unseen/level.csv", 8).items():
        assert error(*pair) < 0.05, name


def test_the_guide_leads_from_raw_records_to_the_fmu(tmp_path):
    """Every command of the page up to its part on two directions, as it stands there."""
    page, _ = (ROOT / "docs/identification.md").read_text().split("## Both directions at once")
    commands = [line for block in re.findall(r"```sh\n(.*?)```", page, re.DOTALL) for line in block.splitlines()]
    folder = shutil.copytree(EXAMPLE, tmp_path / "frictional-support")
    said = ""
    for command in commands:
        words = command.split("#")[0].split()
        if words[0] in ("cd", "pip"):
            continue
        words[0] = {"stickslip": program(), "python": sys.executable}[words[0]]
        done = subprocess.run(words, cwd=folder, capture_output=True, text=True)
        assert done.returncode == 0, f"{command}\n{done.stdout}\n{done.stderr}"
        said += done.stdout
    errors = [float(number) for number in re.findall(r"([\d.]+) % off", said)]
    assert len(errors) == 3 and max(errors) < 5.0, errors
