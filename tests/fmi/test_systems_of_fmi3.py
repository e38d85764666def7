"""FMUs of FMI 3.0 in our master: ours as those of FMI 2.0, one with variables of every type and one by another exporter
(`spring.py`) as FMPy runs them.

STICKSLIP names the program.
"""

import csv
import json
import os
import subprocess
import sys
import sysconfig
import zipfile
from pathlib import Path

import numpy as np
import pytest
from fmpy import extract, read_model_description, simulate_fmu
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave
from test_systems import ECOS, STOP, SYSTEMS, ecos, python_library, stickslip, table

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


@pytest.mark.parametrize("name", [name for name in SYSTEMS if name != "BeamWithSlipSlap"])
def test_ecos_runs_a_system_of_either_version_alike(both, name):
    step, contacts, values = SYSTEMS[name]
    names = ["beam.displacement"] + [f"{contact}.force" for contact in contacts]
    arguments = [step, 200, json.dumps(values), json.dumps(names)]
    older, found = (ecos(ECOS, folder / f"{name}.ssp", *arguments) for folder in both)
    assert len(found) == 200 and found == older
    assert all(value != 0.0 for value in found[-1])


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


@pytest.fixture(scope="session")
def spring(tmp_path_factory) -> Path:
    """A mass on a spring by PythonFMU3."""
    folder = tmp_path_factory.mktemp("spring")
    source = Path(__file__).with_name("spring.py")
    command = [sys.executable, "-m", "pythonfmu3", "build", "-f", source, "-d", folder]
    subprocess.run(command, check=True, capture_output=True)
    return folder / "Spring.fmu"


def test_an_fmu_by_another_exporter_runs_as_under_fmpy(spring, tmp_path, monkeypatch):
    monkeypatch.setenv("PYTHONPATH", sysconfig.get_path("purelib"))
    start = {"load": 2.0, "stiffness": 9.0}
    theirs = simulate_fmu(str(spring), stop_time=1.0, output_interval=0.1, start_values=start)
    stickslip(
        tmp_path, "simulate", spring, "--stop", 1, "--step", 0.1, "--set", "load=2", "--set", "stiffness=9",
        "--out", "r.csv", preload=python_library(),
    )  # fmt: skip
    ours = {column.split(" ")[0]: values for column, values in table(tmp_path / "r.csv").items()}
    for name in ("position", "count", "moving"):
        assert np.allclose(ours[f"Spring.{name}"], np.asarray(theirs[name], float), rtol=1e-12), name
    for place in range(3):
        assert np.allclose(ours[f"Spring.forces[{place + 1}]"], theirs["forces"][:, place], rtol=1e-12)
    assert ours["Spring.count"][-1] == 10 and set(ours["Spring.moving"]) == {0.0, 1.0}


SYSTEM = """<?xml version="1.0" encoding="UTF-8"?>
<ssd:SystemStructureDescription xmlns:ssd="http://ssp-standard.org/SSP1/SystemStructureDescription"
    xmlns:ssc="http://ssp-standard.org/SSP1/SystemStructureCommon" version="1.0" name="Mixed">
  <ssd:System name="Mixed">
    <ssd:Elements>
      <ssd:Component name="mass" type="application/x-fmu-sharedlibrary" source="Spring.fmu">
        <ssd:Connectors>
          <ssd:Connector name="load" kind="input"><ssc:Real/></ssd:Connector>
          <ssd:Connector name="position" kind="output"><ssc:Real/></ssd:Connector>
          <ssd:Connector name="forces[2]" kind="output"><ssc:Real/></ssd:Connector>
        </ssd:Connectors>
      </ssd:Component>
      <ssd:Component name="contact" type="application/x-fmu-sharedlibrary" source="JenkinsContact.fmu">
        <ssd:Connectors>
          <ssd:Connector name="displacement" kind="input"><ssc:Real/></ssd:Connector>
          <ssd:Connector name="normal_load" kind="input"><ssc:Real/></ssd:Connector>
          <ssd:Connector name="force" kind="output"><ssc:Real/></ssd:Connector>
        </ssd:Connectors>
      </ssd:Component>
    </ssd:Elements>
    <ssd:Connections>
      <ssd:Connection startElement="mass" startConnector="position" endElement="contact" endConnector="displacement"/>
      <ssd:Connection startElement="contact" startConnector="force" endElement="mass" endConnector="load">
        <ssc:LinearTransformation factor="-0.02" offset="1"/>
      </ssd:Connection>
      <ssd:Connection startElement="mass" startConnector="forces[2]" endElement="contact" endConnector="normal_load">
        <ssc:LinearTransformation factor="100" offset="150"/>
      </ssd:Connection>
    </ssd:Connections>
  </ssd:System>
</ssd:SystemStructureDescription>
"""


@pytest.mark.parametrize("version", [2, 3])
def test_an_element_of_a_foreign_array_is_coupled_to_our_contact_of_either_version(
    both, spring, version, tmp_path, monkeypatch
):
    """Against a loop over FMPy's slaves, all at once and with held inputs."""
    monkeypatch.setenv("PYTHONPATH", sysconfig.get_path("purelib"))
    folder = tmp_path / "system"
    folder.mkdir()
    for file in (spring, both[version - 2] / "JenkinsContact.fmu"):
        (folder / file.name).write_bytes(file.read_bytes())
    (folder / "system.ssd").write_text(SYSTEM)
    stickslip(
        folder, "simulate", "system.ssd", "--stop", 0.5, "--step", 0.01, "--algorithm", "jacobi", "--extrapolation", 0,
        "--set", "mass.stiffness=1", "--out", "r.csv", preload=python_library(),
    )  # fmt: skip
    ours = {column.split(" ")[0]: values for column, values in table(folder / "r.csv").items()}

    def slave(name):
        file = str(folder / f"{name}.fmu")
        description = read_model_description(file)
        older = description.fmiVersion == "2.0"
        made = (FMU2Slave if older else FMU3Slave)(
            instanceName=name, guid=description.guid if older else description.instantiationToken,
            unzipDirectory=extract(file), modelIdentifier=name,
        )  # fmt: skip
        made.instantiate()
        references = {v.name: v.valueReference for v in description.modelVariables}
        real = (made.getReal, made.setReal) if older else (made.getFloat64, made.setFloat64)
        if older:
            made.setupExperiment(startTime=0.0)
        return made, references, *real

    mass, of_mass, read_mass, set_mass = slave("Spring")
    contact, of_contact, read_contact, set_contact = slave("JenkinsContact")
    set_mass([of_mass["stiffness"]], [1.0])
    for one in (mass, contact):
        one.enterInitializationMode()
    position = force = share = 0.0
    # The system's own start: the mass is at zero and pushes nothing, so that its load is 1.
    set_mass([of_mass["load"]], [1.0])
    set_contact([of_contact["normal_load"]], [150.0])
    for one in (mass, contact):
        one.exitInitializationMode()
    for step in range(50):
        set_mass([of_mass["load"]], [-0.02 * force + 1.0])
        set_contact([of_contact["displacement"], of_contact["normal_load"]], [position, 100.0 * share + 150.0])
        for one in (mass, contact):
            one.doStep(0.01 * step, 0.01)
        position, force = read_mass([of_mass["position"]])[0], read_contact([of_contact["force"]])[0]
        share = mass.getFloat64([of_mass["forces"]], nValues=3)[1]
        found = ours["mass.position"][step + 1], ours["contact.force"][step + 1]
        assert found == pytest.approx((position, force), rel=1e-12, abs=0), step
    assert abs(force) > 50.0
    for one in (mass, contact):
        one.freeInstance()
