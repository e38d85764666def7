"""Systems of FMUs: the same packages in other masters, and FMUs that are not ours in our master.

STICKSLIP names the program.
"""

import csv
import json
import os
import re
import shutil
import signal
import subprocess
import sys
import sysconfig
import time
import zipfile
from pathlib import Path

import numpy as np
import pytest
from fmpy import read_model_description
from fmpy.ssp.simulation import simulate_ssp
from fmpy.ssp.ssd import read_ssd, read_ssv

EXAMPLE = Path(__file__).parents[2] / "examples/external-structure"
STEP, STOP, EXCITATION = 1e-4, 0.02, 20.0
# Step, contacts and start values of each system.
SYSTEMS = {
    "BeamWithValanis": (STEP, ["contact"], {"beam.excitation": EXCITATION}),
    "BeamWithJenkins": (STEP, ["contact"], {"beam.excitation": EXCITATION}),
    "BeamWithSlipSlap": (1e-5, ["contact"], {"beam.excitation": 60.0}),
    "BeamWithTwoContacts": (1e-5, ["contact", "damper"], {"beam.excitation": EXCITATION, "damper.normal_load": 15.0}),
}


def program() -> str:
    path = os.environ.get("STICKSLIP")
    if not path:
        pytest.exit("STICKSLIP must name the program", returncode=4)
    return str(Path(path).resolve())


def stickslip(folder: Path, *arguments, preload: str | None = None, code: int = 0) -> subprocess.CompletedProcess:
    environment = dict(os.environ)
    if preload:
        environment["LD_PRELOAD"] = preload
    done = subprocess.run(
        [program(), *map(str, arguments)], cwd=folder, env=environment, capture_output=True, text=True
    )
    assert done.returncode == code, f"{done.returncode}\n{done.stdout}\n{done.stderr}"
    return done


def table(file: Path) -> dict[str, np.ndarray]:
    with open(file, newline="") as lines:
        rows = list(csv.reader(lines))
    values = np.array([[float(cell) for cell in row] for row in rows[1:]])
    return {name: values[:, column] for column, name in enumerate(rows[0])}


@pytest.fixture(scope="session")
def systems(tmp_path_factory) -> Path:
    folder = tmp_path_factory.mktemp("systems")
    stickslip(folder, "fmu", "--out", folder)
    return folder


def ours(systems: Path, name: str, tmp_path: Path, *more) -> dict[str, np.ndarray]:
    """As other masters couple: all at once, inputs held."""
    out = tmp_path / "ours.csv"
    stickslip(
        tmp_path, "simulate", systems / f"{name}.ssp", "--stop", STOP, "--step", SYSTEMS[name][0],
        "--algorithm", "jacobi", "--extrapolation", 0, "--out", out, *more,
    )
    return table(out)


def agree(found: np.ndarray, expected: np.ndarray, tolerance: float) -> None:
    scale = np.abs(expected).max()
    assert scale > 0.0, "a column of zeros compares nothing"
    count = min(len(found), len(expected))
    assert count > 100
    assert np.abs(found[:count] - expected[:count]).max() <= tolerance * scale


@pytest.mark.parametrize("name", SYSTEMS)
def test_fmpy_runs_the_same_package_to_the_same_trajectories(systems, name, tmp_path):
    file = systems / f"{name}.ssp"
    read_ssd(str(file), validate=True)
    step, contacts, values = SYSTEMS[name]
    start = read_ssv(str(file), "resources/parameters.ssv")
    assert {one.name: float(one.value) for one in start.parameters} == values
    theirs = simulate_ssp(str(file), stop_time=STOP, step_size=step, parameter_set=start)
    own = ours(systems, name, tmp_path)
    # FMPy labels the end of a step with its beginning.
    agree(theirs["beam.displacement"], own["beam.displacement [m]"][1:], 1e-9)
    for contact in contacts:
        agree(theirs[f"{contact}.force"], own[f"{contact}.force [N]"][1:], 1e-9)


ECOS = """
import json, os, sys
from ecospy import EcosSimulation
file, step, count, values, names = sys.argv[1], float(sys.argv[2]), int(sys.argv[3]), json.loads(sys.argv[4]), json.loads(sys.argv[5])
with EcosSimulation(ssp_path=file, step_size=step) as simulation:
    simulation.init()
    for name, value in values.items():
        simulation.set_real(name.replace(".", "::"), value)
    for _ in range(count):
        simulation.step()
        print("ROW", *[repr(simulation.get_real(name.replace(".", "::"))) for name in names])
    simulation.terminate()
# Its library may crash while the interpreter ends, when everything is freed already.
sys.stdout.flush()
os._exit(0)
"""


def ecos(script: str, *arguments) -> list[list[float]]:
    environment = dict(os.environ)
    # Its library needs that of TBB, which is beside the interpreter.
    environment["LD_LIBRARY_PATH"] = str(Path(sys.prefix) / "lib")
    done = subprocess.run(
        [sys.executable, "-c", script, *map(str, arguments)], env=environment, capture_output=True, text=True
    )
    assert done.returncode == 0, done.stdout + done.stderr
    rows = [line.split()[1:] for line in done.stdout.splitlines() if line.startswith("ROW")]
    return [[float(cell) for cell in row] for row in rows]


# It sets the excitation after the initialization: to a beam with a pin, whose inputs run to their values, that is another force.
@pytest.mark.parametrize("name", [name for name in SYSTEMS if name != "BeamWithSlipSlap"])
def test_ecos_runs_the_same_package_to_the_same_trajectories(systems, name, tmp_path):
    step, contacts, values = SYSTEMS[name]
    count = round(STOP / step)
    names = ["beam.displacement"] + [f"{contact}.force" for contact in contacts]
    rows = np.array(ecos(ECOS, systems / f"{name}.ssp", step, count, json.dumps(values), json.dumps(names)))
    own = ours(systems, name, tmp_path)
    for column, unit in enumerate(["m"] + ["N"] * len(contacts)):
        agree(rows[:, column], own[f"{names[column]} [{unit}]"][1:], 1e-9)


def test_cofmupy_runs_our_beams(systems, tmp_path, monkeypatch):
    import cofmupy.wrappers
    from cofmupy.coordinator import Coordinator

    def read(path):
        """It wants an FMPy that is older than ours, whose step size is a number."""
        description = read_model_description(path)
        description.defaultExperiment.stepSize = float(description.defaultExperiment.stepSize)
        return description

    monkeypatch.setattr(cofmupy.wrappers, "read_model_description", read)

    # It reads every output as a Real, which the contacts' slip state is not: beams it is, one pushed by the other.
    end = lambda beam, variable: {"id": beam, "variable": variable, "type": "fmu", "unit": ""}
    path = str(systems / "ModalBeam.fmu")
    configuration = {
        "fmus": [
            {"id": "beam", "path": path, "initialization": {"excitation": EXCITATION}},
            {"id": "other", "path": path, "initialization": {}},
        ],
        "connections": [{"source": end("beam", "displacement:x=0.55"), "target": end("other", "excitation")}],
        "cosim_method": "jacobi",
        "iterative": False,
        "root": "",
        "data_storages": [],
    }
    file = tmp_path / "configuration.json"
    file.write_text(json.dumps(configuration))
    coordinator = Coordinator()
    coordinator.start(conf_path=str(file))
    coordinator.run_simulation(step_size=STEP, end_time=STOP)
    results = coordinator.get_results()
    displacement = np.array(results[("beam", "displacement:x=0.55")])
    out = tmp_path / "ours.csv"
    stickslip(
        tmp_path, "simulate", systems / "ModalBeam.fmu", "--stop", STOP, "--step", STEP, "--set",
        f"excitation={EXCITATION}", "--out", out,
    )
    # Its row is that of the end of the step.
    agree(displacement, table(out)["ModalBeam.displacement:x=0.55 [m]"][1:], 1e-9)
    assert np.abs(results[("other", "displacement:x=0.55")]).max() > 0.0


def test_a_process_for_each_fmu_changes_no_bit(systems, tmp_path):
    here = ours(systems, "BeamWithValanis", tmp_path)
    there = ours(systems, "BeamWithValanis", tmp_path, "--isolate")
    assert here.keys() == there.keys()
    assert all((here[name] == there[name]).all() for name in here)


def python_library() -> str:
    """What an FMU by PythonFMU needs outside of Python."""
    folder, name = sysconfig.get_config_var("LIBDIR"), sysconfig.get_config_var("LDLIBRARY")
    file = Path(folder or "", name or "")
    if file.suffix == ".a" or not file.is_file():
        pytest.skip(f"this Python has no shared library ({file}): FMUs by PythonFMU run in Python only")
    return str(file)


@pytest.fixture(scope="session")
def external(tmp_path_factory) -> Path:
    """The example, built as its README says."""
    folder = tmp_path_factory.mktemp("external")
    environment = dict(os.environ, PYTHON=sys.executable, STICKSLIP=program())
    subprocess.run([str(EXAMPLE / "build.sh"), str(folder)], env=environment, check=True, capture_output=True)
    return folder


def run_external(external: Path, tmp_path: Path, *arguments) -> tuple[dict, dict[str, np.ndarray]]:
    json_file, csv_file = tmp_path / "r.json", tmp_path / "r.csv"
    for out in (json_file, csv_file):
        stickslip(
            tmp_path, "simulate", external / "system.ssd", "--stop", 0.02, *arguments, "--out", out,
            preload=python_library(),
        )
    return json.loads(json_file.read_text()), table(csv_file)


def test_a_structure_by_another_exporter_is_coupled_to_our_contact(external, tmp_path):
    strong, own = run_external(external, tmp_path, "--algorithm", "strong", "--step", 1e-4)
    assert strong["energy"][0]["exchanged"] > 0.0
    _, fine = run_external(external, tmp_path, "--algorithm", "jacobi", "--step", 2e-6, "--every", 50)
    _, coarse = run_external(
        external, tmp_path, "--algorithm", "jacobi", "--extrapolation", 0, "--step", 1e-4
    )
    name = "structure.displacement [m]"
    scale = np.abs(fine[name]).max()
    error = np.abs(own[name] - fine[name][: len(own[name])]).max() / scale
    plain = np.abs(coarse[name] - fine[name][: len(coarse[name])]).max() / scale
    assert error < 0.02 and error < 0.3 * plain, (error, plain)


def test_an_exception_in_a_foreign_fmu_is_told_and_the_results_so_far_are_kept(external, tmp_path):
    source = (EXAMPLE / "mass_spring.py").read_text()
    broken = tmp_path / "mass_spring.py"
    broken.write_text(
        source.replace(
            "        count = max(",
            "        if current_time > 0.0049:\n            raise RuntimeError('the spring broke')\n        count = max(",
        )
    )
    subprocess.run(
        [sys.executable, "-m", "pythonfmu", "build", "-f", str(broken), "-d", str(tmp_path), "--no-external-tool"],
        check=True, capture_output=True,
    )
    shutil.copy(external / "ValanisContact.fmu", tmp_path)
    shutil.copy(external / "system.ssd", tmp_path)
    done = stickslip(
        tmp_path, "simulate", "system.ssd", "--stop", 0.02, "--step", 1e-4, "--out", "r.csv", "--isolate",
        preload=python_library(), code=1,
    )
    said = " ".join(done.stdout.split())
    assert "structure: the step from 0.005 s" in said and "(MassSpring.fmu)" in said, said
    assert "the spring broke" in said, said
    rows = table(tmp_path / "r.csv")
    assert 45 <= len(rows["time [s]"]) <= 52


def test_an_interrupt_leaves_a_whole_file(systems, tmp_path):
    out = tmp_path / "r.csv"
    process = subprocess.Popen(
        [program(), "simulate", str(systems / "BeamWithValanis.ssp"), "--stop", "1000", "--step", "1e-4", "--out", str(out)],
        stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True,
    )
    time.sleep(2.0)
    process.send_signal(signal.SIGINT)
    output, errors = process.communicate(timeout=60)
    assert process.returncode == 130, output + errors
    rows = table(out)
    assert len(rows["time [s]"]) > 10
    assert "nterrupted" in output


def test_parquet_holds_what_csv_holds(systems, tmp_path):
    parquet = pytest.importorskip("pyarrow.parquet")
    own = ours(systems, "BeamWithJenkins", tmp_path)
    out = tmp_path / "r.parquet"
    stickslip(
        tmp_path, "simulate", systems / "BeamWithJenkins.ssp", "--stop", STOP, "--step", STEP,
        "--algorithm", "jacobi", "--extrapolation", 0, "--out", out,
    )
    read = parquet.read_table(out)
    assert read.column_names == list(own)
    assert all((read[name].to_numpy() == own[name]).all() for name in own)


def test_every_fmu_of_ours_runs_alone_in_our_master(systems, tmp_path):
    for file in sorted(systems.glob("*.fmu")):
        out = tmp_path / f"{file.stem}.csv"
        stickslip(tmp_path, "simulate", file, "--stop", 0.01, "--out", out)
        assert all(np.isfinite(values).all() for values in table(out).values())


TWO_DIRECTIONS = {
    "structure": ["xi", "xi_rate", "eta", "eta_rate"],
    "contact": ["force", "opening_force", "normal_force", "separation", "dissipated_energy", "impact_energy"],
}
SPACES = {"ssv": "SystemStructureParameterValues", "ssc": "SystemStructureCommon"}
PAIRS = ["--power", "structure.force=contact.displacement", "--power", "structure.opening_force=contact.opening"]


def run_two_directions(external: Path, tmp_path: Path, *arguments) -> tuple[dict, dict[str, np.ndarray]]:
    out = tmp_path / "r.json"
    stickslip(
        tmp_path, "simulate", external / "two_directions.ssd", *PAIRS, *arguments, "--out", out,
        preload=python_library(),
    )
    report = json.loads(out.read_text())
    return report, {column["name"]: np.array(column["values"]) for column in report["columns"]}


def two_directions_error(external, tmp_path, fine, algorithm, per_step) -> tuple[dict, list[float]]:
    """The root mean square error of every signal over its own, and the residual energy of both pairs."""
    step = 1e-4 / per_step
    report, found = run_two_directions(
        external, tmp_path, *algorithm, "--step", step, "--every", per_step, "--stop", 0.01
    )
    rows = range(1, 100)
    error = {
        name: np.sqrt(np.mean((found[name][rows] - fine[name][rows]) ** 2) / np.mean(fine[name][rows] ** 2))
        for name in fine
    }
    return error, [pair["magnitude"] / pair["exchanged"] for pair in report["energy"]]


def test_slip_and_slap_drive_a_structure_of_two_directions_with_order_two(external, tmp_path):
    strong = ["--algorithm", "strong", "--tolerance", 1e-10]
    _, fine = run_two_directions(external, tmp_path, *strong, "--step", 1e-4 / 32, "--every", 32, "--stop", 0.01)
    fine = {f"{part}.{name}": fine[f"{part}.{name}"] for part, names in TWO_DIRECTIONS.items() for name in names}
    assert fine["contact.separation"].max() > 1e-6, "it leaves the contact"
    coarse = [two_directions_error(external, tmp_path, fine, strong, count) for count in (1, 2)]
    finer = [two_directions_error(external, tmp_path, fine, strong, count) for count in (4, 8)]
    for name in fine:
        # Where in a step it sticks or parts is a matter of chance: the larger error of two steps each.
        first, last = (max(error[name] for error, _ in level) for level in (coarse, finer))
        assert np.log2(first / last) / 2 > 1.7, (name, first, last)
    # Forces held at the middle of a step do in the mean exactly the work that the contact takes.
    assert all(part < 1e-7 for _, residual in coarse + finer for part in residual), (coarse, finer)
    # Without iteration the residual shows the order of the coupling.
    plain = [
        two_directions_error(external, tmp_path, fine, ["--algorithm", "jacobi", "--extrapolation", 0], count)
        for count in (4, 16)
    ]
    for first, last in zip(*(residual for _, residual in plain)):
        assert first > 3.0 * last, plain


def test_slip_and_slap_drive_a_structure_of_two_directions_in_fmpy(external, tmp_path):
    package = tmp_path / "two_directions.ssp"
    with zipfile.ZipFile(package, "w") as archive:
        description = (external / "two_directions.ssd").read_text()
        for name in ("TwoDirections", "SlipSlapContact"):
            archive.write(external / f"{name}.fmu", f"resources/{name}.fmu")
            description = description.replace(f'source="{name}.fmu"', f'source="resources/{name}.fmu"')
        archive.writestr("SystemStructure.ssd", description)
        # FMPy takes start values from a file of their own alone.
        values = re.search(r"<ssv:ParameterSet .*</ssv:ParameterSet>", description, re.DOTALL)[0]
        spaces = " ".join(f'xmlns:{name}="http://ssp-standard.org/SSP1/{full}"' for name, full in SPACES.items())
        archive.writestr("resources/parameters.ssv", values.replace("<ssv:ParameterSet", f"<ssv:ParameterSet {spaces}"))
    read_ssd(str(package), validate=True)
    start = read_ssv(str(package), "resources/parameters.ssv")
    stop, step = 0.005, 1e-5
    theirs = simulate_ssp(str(package), stop_time=stop, step_size=step, parameter_set=start)
    _, own = run_two_directions(
        external, tmp_path, "--algorithm", "jacobi", "--extrapolation", 0, "--step", step, "--stop", stop
    )
    for part, names in TWO_DIRECTIONS.items():
        for name in names:
            # FMPy labels the end of a step with its beginning.
            agree(theirs[f"{part}.{name}"], own[f"{part}.{name}"][1:], 1e-9)
