"""The FMUs of FMI 3.0 under FMPy: like those of FMI 2.0, and what is new."""

import math
import subprocess
import sys
import zipfile
from pathlib import Path

import fmpy
import numpy as np
import pytest
from conftest import MODELS, Model, fmu_folder
from fmpy import extract, simulate_fmu
from fmpy.fmi1 import FMICallException
from fmpy.fmi3 import FMU3Model
from fmpy.validation import validate_fmu
from lxml import etree

DISCARD, ERROR = 2, 3


def test_the_validator_reports_nothing(model3):
    assert validate_fmu(str(model3.fmu)) == []


def test_the_xml_obeys_the_schema_of_the_standard(model3):
    schema = Path(fmpy.__file__).parent / "schema/fmi3/fmi3ModelDescription.xsd"
    document = etree.parse(str(model3.unpacked / "modelDescription.xml"))
    checker = etree.XMLSchema(etree.parse(str(schema)))
    assert checker.validate(document), checker.error_log


def test_binaries_are_where_the_standard_wants_them(model3):
    names = set(zipfile.ZipFile(model3.fmu).namelist())
    assert any(name.startswith("binaries/x86_64-") and f"/{model3.name}." in name for name in names)
    older = zipfile.ZipFile(fmu_folder() / f"{model3.name}.fmu").namelist()
    assert len(names) == len(older)


def test_the_table_is_that_of_fmi_2_with_time_indicators_and_arrays_after_it(model3, tmp_path):
    older = Model(model3.name, tmp_path)
    for known, variable in zip(older.description.modelVariables, model3.description.modelVariables):
        assert (known.name, known.valueReference) == (variable.name, variable.valueReference)
        assert (known.causality, known.variability) == (variable.causality, variable.variability)
        assert (known.min, known.max, known.start) == (variable.min, variable.max, variable.start) or known.type == "Integer"
    more = model3.description.modelVariables[len(older.description.modelVariables):]
    kinds = [variable.causality for variable in more]
    assert kinds.count("independent") == 1
    assert kinds.count("local") == model3.description.numberOfEventIndicators == older.description.numberOfEventIndicators
    assert kinds.count("output") == (3 if "Beam" in model3.name else 0)


def test_capabilities_are_those_of_the_library(model3):
    root = etree.parse(str(model3.unpacked / "modelDescription.xml")).getroot()
    claimed = {
        interface: {name for name, value in root.find(interface).attrib.items() if value == "true"}
        for interface in ("CoSimulation", "ModelExchange")
    }
    states = {"canGetAndSetFMUState", "canSerializeFMUState"}
    derivatives = {"providesDirectionalDerivatives", "providesAdjointDerivatives"}
    steps = {"canHandleVariableCommunicationStepSize", "providesIntermediateUpdate"}
    # No event mode, no early return, no clocks.
    assert claimed["CoSimulation"] == states | derivatives | steps
    assert claimed["ModelExchange"] == states | {"needsCompletedIntegratorStep"}
    assert root.find("CoSimulation").get("maxOutputDerivativeOrder") == "1"
    assert root.find("ScheduledExecution") is None and not root.findall("ModelVariables/Clock")


def test_fmu_equals_native_and_the_fmu_of_fmi_2(model3, tmp_path):
    extract(str(fmu_folder() / f"{model3.name}.fmu"), unzipdir=str(tmp_path / "older"))
    older = Model(model3.name, tmp_path / "older")
    names = older.names("output")
    native = np.array([[row[older.columns.index(name)] for name in names] for row in older.rows])
    found = []
    for one in (older, model3):
        slave = one.slave()
        one.start(slave)
        values = [[one.get(slave, name) for name in names]]
        found.append(values + [one.step(slave, row) for row in range(1, len(one.rows))])
        slave.terminate()
        slave.freeInstance()
    assert found[0] == found[1]
    scale = np.abs(native).max(axis=0)
    worst = (np.abs(np.array(found[1]) - native) / scale).max(axis=0)
    assert (scale > 0).all() and (worst <= 1e-9).all(), dict(zip(names, worst))


def inputs(model, row_count=None):
    names = ["time", *model.names("input")]
    columns = [model.columns.index(name) for name in names]
    rows = model.rows[:row_count]
    return np.array([tuple(row[c] for c in columns) for row in rows], dtype=[(n, float) for n in names])


@pytest.mark.parametrize("kind", ["CoSimulation", "ModelExchange"])
def test_simulate_fmu_gives_what_it_gives_of_the_fmu_of_fmi_2(model3, kind):
    step = float(model3.description.defaultExperiment.stepSize)
    settings = {"fmi_type": kind, "input": inputs(model3), "stop_time": 40 * step, "output_interval": step}
    older, found = (
        simulate_fmu(str(fmu_folder() / folder / f"{model3.name}.fmu"), validate=True, **settings)
        for folder in ("", "fmi3")
    )
    assert len(found) >= 40
    for name in older.dtype.names:
        here, there = older[name], found[name]
        if kind == "CoSimulation":
            # FMPy sets a slave's inputs alike in both versions.
            assert np.array_equal(here, there), name
        else:
            assert np.abs(here - there).max() <= 1e-9 * max(np.abs(here).max(), 1e-300), name
    moved = [name for name in older.dtype.names[1:] if np.abs(older[name]).max() > 0]
    assert len(moved) >= 3


@pytest.mark.parametrize("name", ["JenkinsContact", "ValanisContact"])
def test_both_interfaces_carry_the_same_force(name, tmp_path):
    time = np.linspace(0.0, 0.04, 4001)
    omega = 2 * np.pi / 0.02
    columns = [time, 8e-5 * np.sin(omega * time), 8e-5 * omega * np.cos(omega * time), 140 + 60 * np.sin(170 * time)]
    names = [(name, float) for name in ("time", "displacement", "velocity", "normal_load")]
    motion = np.array(list(zip(*columns)), dtype=names)
    file = str(fmu_folder() / f"fmi3/{name}.fmu")
    stepped, integrated = (
        simulate_fmu(
            file, fmi_type=kind, input=motion, stop_time=0.04, output_interval=2e-5, step_size=2e-5,
            output=["force", "dissipated_energy"], record_events=kind == "ModelExchange",
        )
        for kind in ("CoSimulation", "ModelExchange")
    )  # fmt: skip
    for signal in ("force", "dissipated_energy"):
        # FMPy sets a slave's inputs at the beginning of a step.
        here = np.interp(stepped["time"] - 2e-5, integrated["time"], integrated[signal])
        assert np.abs(here - stepped[signal]).max() <= 2e-3 * np.abs(stepped[signal]).max()
    # Reversals are events.
    assert len(integrated) - len(stepped) >= 4


def test_an_importer_that_integrates_finds_states_and_indicators(model3):
    description = model3.description
    model = FMU3Model(
        instanceName="one", guid=description.instantiationToken, unzipDirectory=str(model3.unpacked),
        modelIdentifier=model3.name,
    )  # fmt: skip
    model.instantiate()
    model.enterInitializationMode()
    model.exitInitializationMode()
    assert model.updateDiscreteStates() == (False, False, False, False, False, 0.0)
    model.enterContinuousTimeMode()
    states, indicators = model.getNumberOfContinuousStates(), model.getNumberOfEventIndicators()
    assert (states, indicators) == (description.numberOfContinuousStates, description.numberOfEventIndicators)
    state = model.getFMUState()
    model.setTime(0.5)
    time = next(v for v in description.modelVariables if v.causality == "independent")
    assert model.getFloat64([time.valueReference]) == [0.5]
    assert model.completedIntegratorStep() == (False, False)
    model.enterEventMode()
    model.setFMUState(state)
    model.setTime(0.25)
    model.freeFMUState(state)
    with pytest.raises(FMICallException):
        model.getDirectionalDerivative([description.outputs[0].variable.valueReference], [0], [1.0])
    model.freeInstance()


def test_derivatives_are_the_limits_of_differences(model3):
    """Of a step repeated from a saved state; back from the outputs, the same numbers transposed."""
    slave = model3.slave()
    model3.start(slave)
    for row in range(1, 40):
        model3.step(slave, row)
    state = slave.getFMUState()
    names = [n for n in model3.names("output") if model3.variables[n].variability == "continuous"]
    unknowns = [model3.variables[n].valueReference for n in names]
    knowns = [model3.variables[n].valueReference for n in model3.names("input")]
    time, step = model3.rows[39][0], model3.rows[40][0] - model3.rows[39][0]
    values = [model3.rows[40][model3.columns.index(n)] for n in model3.names("input")]

    def after(values):
        slave.setFMUState(state)
        slave.setFloat64(knowns, values)
        slave.doStep(time, step)
        return np.array(slave.getFloat64(unknowns))

    forward, differences = [], []
    for place, value in enumerate(values):
        nominal = float(model3.variables[model3.names("input")[place]].nominal)
        small = 1e-5 * max(abs(value), 0.1 * nominal)
        ends = [after([*values[:place], value + way * small, *values[place + 1:]]) for way in (1, -1)]
        differences.append((ends[0] - ends[1]) / (2 * small))
        after(values)
        forward.append(slave.getDirectionalDerivative(unknowns, [knowns[place]], [1.0]))
    forward, differences = np.array(forward), np.array(differences)
    scale = np.abs(differences).max(axis=1, keepdims=True)
    smooth = np.abs(forward - differences) <= 2e-3 * np.maximum(np.abs(differences), 1e-3 * scale)
    assert smooth.all(), [(names[c], forward[r, c], differences[r, c]) for r, c in zip(*np.where(~smooth))]
    seed = np.linspace(-1.0, 2.0, len(unknowns)) / np.maximum(np.abs(forward).max(axis=0), 1e-300)
    back = slave.getAdjointDerivative(unknowns, knowns, list(seed), nSensitivity=len(knowns))
    assert np.allclose(back, forward @ seed, rtol=1e-9, atol=0)
    rates = slave.getOutputDerivatives(unknowns, [1] * len(unknowns))
    assert np.isfinite(rates).all() and np.any(rates)
    slave.freeFMUState(state)
    slave.freeInstance()


def test_save_step_restore_step_is_bit_identical_in_another_process_too(model3, tmp_path):
    slave = model3.slave()
    model3.start(slave)
    for row in range(1, 60):
        model3.step(slave, row)
    state = slave.getFMUState()
    saved = slave.serializeFMUState(state)
    first = [model3.step(slave, row) for row in range(60, 120)]
    slave.setFMUState(state)
    assert [model3.step(slave, row) for row in range(60, 120)] == first
    slave.freeFMUState(state)
    slave.freeInstance()
    (tmp_path / "state.bin").write_bytes(saved)
    script = f"""
import sys
sys.path.insert(0, {str(Path(__file__).parent)!r})
from conftest import Model3
from pathlib import Path
model = Model3({model3.name!r}, Path({str(model3.unpacked)!r}))
slave = model.slave()
slave.instantiate()
state = slave.deserializeFMUState(Path({str(tmp_path / "state.bin")!r}).read_bytes())
slave.setFMUState(state)
slave.freeFMUState(state)
print([[value.hex() for value in map(float, model.step(slave, row))] for row in range(60, 120)])
"""
    other = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert other.returncode == 0, other.stderr
    assert other.stdout.strip() == str([[value.hex() for value in map(float, row)] for row in first])


def test_a_wrong_token_and_an_edited_model_are_refused(model3):
    with pytest.raises(Exception, match="instantiate"):
        model3.slave(guid="{00000000-0000-0000-0000-000000000000}").instantiate()
    file = model3.unpacked / "resources/model.toml"
    text = file.read_text()
    first = next(line for line in text.splitlines() if line.startswith(("length", "friction_coefficient")))
    name, value = first.split("#")[0].split("=")
    file.write_text(text.replace(first, f"{name.strip()} = {float(value) * 1.01}"))
    with pytest.raises(Exception, match="instantiate"):
        model3.slave().instantiate()


def test_impossible_values_are_discarded_and_other_faults_are_errors(model3):
    slave = model3.slave()
    model3.start(slave)
    model3.step(slave, 1)
    reference = model3.variables[model3.names("input")[0]].valueReference
    state = slave.getFMUState()
    for value in (math.nan, math.inf):
        with pytest.raises(FMICallException) as refused:
            slave.setFloat64([reference], [value])
        assert refused.value.status == DISCARD
    expected = model3.step(slave, 2)
    for fault in (
        lambda: slave.setFloat64([987654], [1.0]),
        lambda: slave.getInt32([reference]),
        lambda: slave.doStep(model3.rows[1][0], 0.0),
        lambda: slave.enterEventMode(),
        lambda: slave.setClock([reference], [True]),
    ):
        slave.setFMUState(state)
        with pytest.raises(FMICallException) as refused:
            fault()
        assert refused.value.status == ERROR
        # The instance is terminated, from where a saved state leads back.
        with pytest.raises(FMICallException):
            model3.step(slave, 2)
    slave.setFMUState(state)
    assert model3.step(slave, 2) == expected
    slave.freeFMUState(state)
    slave.freeInstance()


@pytest.mark.parametrize("model3", [name for name in MODELS if "Beam" in name], indirect=True)
def test_an_array_holds_the_sensors_in_their_order(model3):
    slave = model3.slave()
    model3.start(slave)
    for row in range(1, 20):
        model3.step(slave, row)
    for array, quantity in [("displacements", "displacement"), ("accelerations", "acceleration")]:
        names = [n for n in model3.variables if n.startswith(f"{quantity}:")]
        variable = model3.variables[array]
        assert [int(dimension.start) for dimension in variable.dimensions] == [len(names)]
        values = slave.getFloat64([variable.valueReference], nValues=len(names))
        assert values == [model3.get(slave, name) for name in names]
        assert any(values)
    slave.freeInstance()


def end_under_a_running_force(file, steps, told):
    """The displacement of a beam's end at 4 ms, under a contact force that is told within steps or held."""
    force = lambda time: 5.0 * math.sin(1500.0 * time)  # noqa: E731
    course = np.array(
        [(t, force(t)) for t in np.linspace(0.0, 4e-3, 4 * 4096 + 1)], dtype=[("time", float), ("contact_force", float)]
    )
    step = 4e-3 / steps
    if not told:
        result = simulate_fmu(
            file, fmi_type="CoSimulation", input=course[:: 4 * 4096 // steps], stop_time=4e-3, output_interval=step,
            output=["displacement"],
        )  # fmt: skip
        return result["displacement"][-1]
    calls = []

    def update(environment, time, requested, allowed, finished, can_return, wants_return, return_time):
        calls.append(time)
        if requested:
            slave.setFloat64([1], [force(time)])

    description = fmpy.read_model_description(file)
    unpacked = extract(file)
    slave = fmpy.fmi3.FMU3Slave(
        instanceName="one", guid=description.instantiationToken, unzipDirectory=unpacked, modelIdentifier="ModalBeam"
    )
    slave.instantiate(intermediateUpdate=update, requiredIntermediateVariables=[1])
    slave.enterInitializationMode()
    slave.exitInitializationMode()
    for k in range(steps):
        slave.doStep(k * step, step)
    assert len(calls) == 4 * steps
    end = slave.getFloat64([2])[0]
    slave.freeInstance()
    return end


def test_inputs_told_within_steps_make_them_more_accurate():
    file = str(fmu_folder() / "fmi3/ModalBeam.fmu")
    exact = end_under_a_running_force(file, 512, True)
    errors = [abs(end_under_a_running_force(file, steps, True) - exact) for steps in (8, 16, 32)]
    assert errors[0] / errors[1] > 7 and errors[1] / errors[2] > 7, errors
    assert errors[2] < 0.01 * abs(end_under_a_running_force(file, 32, False) - exact)


def test_messages_reach_the_logger_where_logging_is_on(model3):
    heard = []
    slave = model3.slave()
    log = lambda environment, status, category, message: heard.append((status, category, message))  # noqa: E731
    model3.start(slave, loggingOn=True, logMessage=log)
    with pytest.raises(FMICallException):
        slave.doStep(0.0, -1.0)
    slave.freeInstance()
    assert any(category == b"logEvents" for _, category, _ in heard)
    status, category, message = next(entry for entry in heard if entry[0] == ERROR)
    assert category == b"logStatusError" and b"communicationStepSize = -1.0" in message


def test_nothing_is_written_to_the_console(model3, capfd):
    slave = model3.slave()
    model3.start(slave)
    model3.step(slave, 1)
    slave.terminate()
    slave.freeInstance()
    captured = capfd.readouterr()
    assert captured.out == "" and captured.err == ""
