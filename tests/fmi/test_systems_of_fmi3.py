"""FMUs of FMI 3.0 in our master: ours as those of FMI 2.0, and one with variables of every type as FMPy runs it.

STICKSLIP names the program.
"""

import csv
import os
import subprocess
import zipfile
from pathlib import Path

import numpy as np
import pytest
from fmpy import simulate_fmu
from test_systems import STOP, SYSTEMS, stickslip, table

KINDS = Path(__file__).parents[2] / "tools/fmi-host/tests/kinds"


@pytest.fixture(scope="session")
def both(tmp_path_factory) -> list[Path]:
    folders = [tmp_path_factory.mktemp(f"systems of FMI {version}") for version in (2, 3)]
    for version, folder in zip((2, 3), folders):
        stickslip(folder, "fmu", "--out", folder, "--fmi", version)
    return folders


@pytest.mark.parametrize("algorithm", ["jacobi", "gauss-seidel", "strong"])
@pytest.mark.parametrize("name", SYSTEMS)
def test_our_fmus_of_fmi_3_run_as_those_of_fmi_2(both, name, algorithm, tmp_path):
    step = SYSTEMS[name][0]
    stop = STOP if step >= 1e-4 else STOP / 10
    results = []
    for number, folder in enumerate(both):
        out = tmp_path / f"{number}.csv"
        stickslip(
            tmp_path, "simulate", folder / f"{name}.ssp", "--stop", stop, "--step", step, "--algorithm", algorithm,
            "--out", out,
        )  # fmt: skip
        results.append(table(out))
    older, found = results
    assert set(older) < set(found), "arrays come on top"
    for column, values in older.items():
        assert np.abs(found[column] - values).max() <= 1e-9 * np.abs(values).max(), column
    displacements = [column for column in found if column.startswith("beam.displacements[")]
    singles = [column for column in found if column.startswith("beam.displacement:")]
    assert len(displacements) == len(singles) > 0
    for array, single in zip(displacements, singles):
        assert np.array_equal(found[array], found[single])


def test_an_fmu_of_fmi_3_runs_in_a_process_of_its_own_alike(both, tmp_path):
    for number, flag in enumerate(["--isolate", "--no-isolate"]):
        stickslip(
            tmp_path, "simulate", both[1] / "BeamWithValanis.ssp", "--stop", 0.005, "--step", 1e-4, flag,
            "--out", tmp_path / f"{number}.csv",
        )  # fmt: skip
    apart, here = (table(tmp_path / f"{number}.csv") for number in (0, 1))
    assert all(np.array_equal(apart[column], here[column]) for column in here)


@pytest.fixture(scope="session")
def kinds(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("kinds")
    compiler = os.environ.get("CC", "cc")
    subprocess.run([compiler, "-shared", "-fPIC", "-O1", "-o", folder / "Kinds.so", KINDS / "kinds.c"], check=True)
    with zipfile.ZipFile(folder / "Kinds.fmu", "w") as archive:
        archive.write(KINDS / "modelDescription.xml", "modelDescription.xml")
        archive.write(folder / "Kinds.so", "binaries/x86_64-linux/Kinds.so")
    return folder / "Kinds.fmu"


VALUES = {
    "in_f64": 2.5, "in_f32": -0.75, "in_i8": -5, "in_u8": 200, "in_i16": -300, "in_u16": 60000, "in_i32": -70000,
    "in_u32": 4000000000, "in_i64": -(2**40), "in_u64": 2**50, "in_boolean": True, "in_mode": 4, "rate": 3.0,
}  # fmt: skip


def test_variables_of_every_type_and_arrays_are_those_that_fmpy_finds(kinds, tmp_path):
    theirs = simulate_fmu(
        str(kinds), stop_time=0.1, output_interval=0.01, start_values={**VALUES, "in_list": [4.0, 5.0, 6.0]}
    )
    sets = [f"{name}={str(value).lower()}" for name, value in VALUES.items()]
    # An item of an enumeration by its name, elements of an array one by one.
    sets = [text.replace("in_mode=4", "in_mode=on") for text in sets] + [f"in_list[{k}]={k + 3}" for k in (1, 2, 3)]
    arguments = [word for text in sets for word in ("--set", text)]
    out = tmp_path / "kinds.csv"
    stickslip(tmp_path, "simulate", kinds, "--stop", 0.1, "--step", 0.01, *arguments, "--out", out)
    with open(out, newline="") as file:
        header = next(csv.reader(file))
    ours = {column.split(" ")[0].removeprefix("Kinds."): values for column, values in table(out).items()}
    assert "Kinds.out_f64 [N]" in header
    for name in theirs.dtype.names:
        if name in ("time", "same_f64"):
            continue
        if theirs[name].ndim == 2:
            for place in range(theirs[name].shape[1]):
                assert np.array_equal(ours[f"{name}[{place + 1}]"], theirs[name][:, place]), name
        else:
            assert np.allclose(ours[name], np.asarray(theirs[name], float), rtol=1e-12, atol=0), name
    assert ours["out_mode"][-1] == 4 and ours["level"][-1] == pytest.approx(0.3)
    # What a type does not hold is refused, with its name.
    refused = stickslip(tmp_path, "simulate", kinds, "--set", "in_u8=256", "--out", "no.csv", code=2)
    assert "in_u8" in refused.stderr and not (tmp_path / "no.csv").exists()
