"""From the records of a rig to an FMU that predicts a level which was not fitted.

STICKSLIP names the program.
"""

import shutil
from pathlib import Path

import numpy as np
import pytest
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave
from test_systems import stickslip, table

EXAMPLE = Path(__file__).parents[2] / "examples/frictional-support"
LEVELS = [20.0, 30.0, 50.0, 60.0, 70.0]
UNSEEN = 40.0
# Periods from rest until the motion repeats, and steps of each.
PERIODS, STEPS = 150, 256
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


def rig(folder: Path, name: str, chain: str, levels: list[float]) -> None:
    (folder / f"{name}.toml").write_text(PLAN.format(chain=chain, levels=levels))
    stickslip(folder, "rig", f"{name}.toml", "-o", name)


def driven(fmu: Path, unpacked: Path, step: float, force: np.ndarray) -> dict[str, np.ndarray]:
    """The outputs under a force that runs straight from step to step."""
    description = read_model_description(str(fmu))
    slave = FMU2Slave(
        instanceName="one",
        guid=description.guid,
        unzipDirectory=extract(str(fmu), unzipdir=str(unpacked)),
        modelIdentifier=description.coSimulation.modelIdentifier,
    )
    outputs = [v for v in description.modelVariables if v.causality == "output" and v.type == "Real"]
    references = [v.valueReference for v in outputs]
    excitation = [v.valueReference for v in description.modelVariables if v.name == "excitation"]
    slave.instantiate()
    slave.setupExperiment(startTime=0.0)
    slave.enterInitializationMode()
    slave.setReal(excitation, [force[0]])
    slave.exitInitializationMode()
    rows = [slave.getReal(references)]
    for k, (now, then) in enumerate(zip(force[:-1], force[1:])):
        slave.setReal(excitation, [now])
        slave.setRealInputDerivatives(excitation, [1], [(then - now) / step])
        slave.doStep(k * step, step)
        rows.append(slave.getReal(references))
    slave.terminate()
    slave.freeInstance()
    return {v.name: column for v, column in zip(outputs, np.array(rows).T)}


def coefficients(phases, values, harmonics=9):
    """Of the harmonics by least squares, the mean left out."""
    orders = np.outer(phases, np.arange(1, harmonics + 1))
    columns = np.hstack([np.ones((len(phases), 1)), np.cos(orders), np.sin(orders)])
    return np.linalg.lstsq(columns, values, rcond=None)[0][1:]


def off(found, truth):
    """Root mean square of the difference over that of the truth."""
    return np.linalg.norm(found - truth) / np.linalg.norm(truth)


@pytest.mark.parametrize("chain, bound", [("", 0.02), (NOISY, 0.05)], ids=["clean", "noise and gains"])
def test_an_identified_contact_predicts_an_unseen_level_as_an_fmu(tmp_path, chain, bound):
    shutil.copy(EXAMPLE / "published.toml", tmp_path)
    rig(tmp_path, "measured", chain, LEVELS)
    rig(tmp_path, "unseen", "", [UNSEEN])
    stickslip(tmp_path, "identify", "published.toml", "measured", "-o", "identified.toml")
    stickslip(tmp_path, "export", "identified.toml", "-o", "Support.fmu")

    truth = table(tmp_path / "unseen/level.csv")
    times = truth["time [s]"]
    # Eight periods were recorded.
    recorded = 2 * np.pi * 8 * times / (times[-1] + times[1])
    cosine, sine = coefficients(recorded, truth["excitation [N]"], 1)
    phases = 2 * np.pi / STEPS * np.arange(PERIODS * STEPS + 1)
    force = cosine * np.cos(phases) + sine * np.sin(phases)
    step = times[-1] / recorded[-1] * phases[1]
    found = driven(tmp_path / "Support.fmu", tmp_path / "unpacked", step, force)
    end, before = slice(-8 * STEPS, None), slice(-16 * STEPS, -8 * STEPS)
    for position in (0.55, 0.3, 0.1):
        name = f"acceleration:x={position}"
        expected = coefficients(recorded, truth[f"{name} [m/s^2]"])
        steady = coefficients(phases[end], found[name][end])
        assert off(coefficients(phases[before], found[name][before]), steady) < 1e-3, name
        assert off(steady, expected) < bound, name
