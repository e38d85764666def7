"""The libraries of all platforms in an FMU of `cargo xtask dist`, loaded and stepped by one program in C.

STICKSLIP names that program `stickslip`. It exports the standard models; `step.c`, compiled for each platform, loads the
library of that platform: here, in wine and in qemu-user, where these are installed.
"""

import os
import platform
import re
import shutil
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from fmpy import extract, read_model_description
from fmpy.validation import validate_fmu

ROOT = Path(__file__).resolve().parents[2]
MODELS = sorted(file.stem for file in (ROOT / "modelDescription").glob("*.toml"))
STEPS = 400
# Platform: target of the C compiler, how its programs run here.
PLATFORMS = {
    "linux64": ("x86_64-linux-gnu.2.17", []),
    "win64": ("x86_64-windows-gnu", ["wine64"]),
    "aarch64-linux": ("aarch64-linux-gnu.2.17", ["qemu-aarch64", "-L", "/usr/aarch64-linux-gnu"]),
}
# How far a signal moves by the unit of its input; loads stay.
AMPLITUDES = {"m": 4e-5, "m/s": 1e-2, "N": 30.0}


def program(name):
    """The path of an emulator, which Debian does not always put on PATH."""
    return shutil.which(name) or shutil.which(name, path="/usr/lib/wine")


def stepper(name, folder):
    """The command of `step.c` for a platform."""
    target, runner = PLATFORMS[name]
    if runner and program(runner[0]) is None:
        pytest.skip(f"{runner[0]} is not installed: {name} was not run")
    if not runner and platform.machine() != "x86_64":
        pytest.skip(f"this machine does not run {name}")
    file = folder / ("step.exe" if name == "win64" else f"step-{name}")
    if not file.exists():
        flags = ["-O1", "-Wall", "-Wextra", "-Werror", "-o", file] + ([] if name == "win64" else ["-ldl"])
        subprocess.run(
            [sys.executable, "-m", "ziglang", "cc", "-target", target, Path(__file__).with_name("step.c"), *flags],
            check=True,
        )
    return [program(word) or word for word in runner[:1]] + runner[1:] + [file]


@pytest.fixture(scope="session")
def build(tmp_path_factory):
    return tmp_path_factory.mktemp("build")


@pytest.fixture(scope="session", params=MODELS)
def fmu(request, tmp_path_factory):
    file = tmp_path_factory.mktemp("fmu") / f"{request.param}.fmu"
    model = ROOT / "modelDescription" / f"{request.param}.toml"
    subprocess.run([os.environ["STICKSLIP"], "export", model, "-o", file], check=True, capture_output=True)
    return file


def triangle(steps, period):
    """A triangular wave: the same numbers on every machine."""
    return np.array([abs((k + period // 4) % period - period // 2) for k in range(1, steps + 1)]) * 4.0 / period - 1.0


def protocol(description):
    """What `step.c` reads."""
    inputs = [v for v in description.modelVariables if v.causality == "input"]
    outputs = [v for v in description.modelVariables if v.causality == "output" and v.type == "Real"]
    columns = []
    for number, variable in enumerate(inputs):
        wave = triangle(STEPS, [80, 52, 36][number % 3])
        start = float(variable.start)
        moves = 0.0 if variable.name.startswith("normal_load") else AMPLITUDES[variable.unit]
        columns.append(start + moves * wave)
    step = description.defaultExperiment.stepSize
    lines = [f"{len(inputs)} {len(outputs)} {STEPS} {float(step)!r}"]
    lines += [" ".join(str(v.valueReference) for v in group) for group in (inputs, outputs)]
    lines += [" ".join(repr(float(value)) for value in row) for row in zip(*columns)]
    return "\n".join(lines) + "\n", [v.name for v in outputs]


def stepped(name, fmu, build, folder):
    """The outputs of the FMU as the library of a platform computes them."""
    description = read_model_description(str(fmu))
    unpacked = extract(str(fmu), unzipdir=folder)
    extension = "dll" if name == "win64" else "so"
    library = Path(unpacked) / "binaries" / name / f"{fmu.stem}.{extension}"
    resources = Path(unpacked, "resources").as_posix()
    if name == "win64":  # wine calls the root of this machine Z:
        uri, library = f"file:///Z:{resources}", "Z:" + str(library).replace("/", "\\")
    else:
        uri = f"file://{resources}"
    text, names = protocol(description)
    environment = {**os.environ, "WINEPREFIX": str(build / "wine"), "WINEDEBUG": "-all"}
    command = stepper(name, build) + [library, description.guid, uri]
    done = subprocess.run(command, input=text, capture_output=True, text=True, env=environment, timeout=300)
    assert done.returncode == 0, done.stderr
    rows = np.array([[float(word) for word in line.split()] for line in done.stdout.splitlines()])
    assert rows.shape == (STEPS, len(names)) and np.isfinite(rows).all()
    return rows, names


@pytest.mark.parametrize("name", PLATFORMS)
def test_every_library_steps_the_same_motion(name, fmu, build, tmp_path):
    here, names = stepped("linux64", fmu, build, tmp_path / "here")
    there, _ = stepped(name, fmu, build, tmp_path / "there")
    for column, signal in enumerate(names):
        reference, other = here[:, column], there[:, column]
        scale = np.abs(reference).max()
        # Exponentials and cosines are those of the platform's own library: they differ in their last digits.
        assert np.abs(other - reference).max() <= 1e-9 * scale, signal


def test_the_file_has_all_platforms_and_no_remark_of_the_validator(fmu, tmp_path):
    unpacked = Path(extract(str(fmu), unzipdir=tmp_path))
    assert sorted(folder.name for folder in (unpacked / "binaries").iterdir()) == sorted(PLATFORMS)
    assert validate_fmu(str(fmu)) == []


def test_linux_libraries_need_no_c_library_after_2_17(fmu, tmp_path):
    unpacked = Path(extract(str(fmu), unzipdir=tmp_path))
    for library in (unpacked / "binaries").glob("*/*.so"):
        versions = re.findall(rb"GLIBC_2\.(\d+)", library.read_bytes())
        assert versions and max(map(int, versions)) <= 17, library


def test_no_folder_of_this_machine_is_in_the_file(fmu, tmp_path):
    unpacked = Path(extract(str(fmu), unzipdir=tmp_path))
    for file in (found for found in unpacked.rglob("*") if found.is_file()):
        content = file.read_bytes()
        for folder in (str(ROOT), str(Path.home()), "registry/src", "index.crates"):
            assert folder == "/" or folder.encode() not in content, (file, folder)
