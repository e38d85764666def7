"""The FMUs under FMPy."""

import math
import subprocess
import sys
from pathlib import Path

import numpy as np
import pytest
from fmpy import simulate_fmu
from fmpy.fmi1 import FMICallException


def test_fmu_equals_native(model):
    names = model.names("output")
    native = np.array([[row[model.columns.index(name)] for name in names] for row in model.rows])
    slave = model.slave()
    model.start(slave)
    found = [[model.get(slave, name) for name in names]]
    found += [model.step(slave, row) for row in range(1, len(model.rows))]
    slave.terminate()
    slave.freeInstance()
    scale = np.abs(native).max(axis=0)
    assert (scale > 0).all(), "a column of zeros compares nothing"
    worst = (np.abs(np.array(found) - native) / scale).max(axis=0)
    assert (worst <= 1e-9).all(), dict(zip(names, worst))


def test_simulate_fmu_runs_the_default_experiment(model):
    result = simulate_fmu(str(model.fmu), validate=True)
    assert len(result) > 100
    assert all(np.isfinite(result[name]).all() for name in result.dtype.names)


def test_save_step_restore_step_is_bit_identical(model):
    slave = model.slave()
    model.start(slave)
    for row in range(1, 60):
        model.step(slave, row)
    state = slave.getFMUstate()
    first = [model.step(slave, row) for row in range(60, 160)]
    slave.setFMUstate(state)
    assert [model.step(slave, row) for row in range(60, 160)] == first
    slave.freeFMUstate(state)
    slave.freeInstance()


OTHER_PROCESS = """
import sys
sys.path.insert(0, {here!r})
from conftest import Model
from pathlib import Path
model = Model({name!r}, Path({unpacked!r}))
slave = model.slave()
slave.instantiate()
state = slave.deSerializeFMUstate(Path({file!r}).read_bytes())
slave.setFMUstate(state)
slave.freeFMUstate(state)
print([[value.hex() for value in map(float, model.step(slave, row))] for row in range(60, 160)])
"""


def test_bytes_continue_bit_identically_in_another_process(model, tmp_path):
    slave = model.slave()
    model.start(slave)
    for row in range(1, 60):
        model.step(slave, row)
    state = slave.getFMUstate()
    file = tmp_path / "state.bin"
    file.write_bytes(slave.serializeFMUstate(state))
    slave.freeFMUstate(state)
    expected = [[value.hex() for value in map(float, model.step(slave, row))] for row in range(60, 160)]
    slave.freeInstance()
    here = str(Path(__file__).parent)
    script = OTHER_PROCESS.format(here=here, name=model.name, unpacked=str(model.unpacked), file=str(file))
    other = subprocess.run([sys.executable, "-c", script], capture_output=True, text=True)
    assert other.returncode == 0, other.stderr
    assert other.stdout.strip() == str(expected)


def test_changed_bytes_are_refused(model):
    slave = model.slave()
    model.start(slave)
    state = slave.getFMUstate()
    bytes_ = bytearray(slave.serializeFMUstate(state))
    bytes_[len(bytes_) // 2] ^= 1
    with pytest.raises(FMICallException):
        slave.deSerializeFMUstate(bytes(bytes_))
    slave.freeFMUstate(state)
    slave.freeInstance()


def test_another_guid_is_refused(model):
    with pytest.raises(Exception):
        model.slave(guid="{00000000-0000-0000-0000-000000000000}").instantiate()


def test_an_edited_model_file_is_refused(model):
    file = model.unpacked / "resources/model.toml"
    text = file.read_text()
    first = next(line for line in text.splitlines() if line.startswith(("length", "friction_coefficient")))
    name, value = first.split("#")[0].split("=")
    file.write_text(text.replace(first, f"{name.strip()} = {float(value) * 1.01}"))
    with pytest.raises(Exception):
        model.slave().instantiate()


def test_a_reset_slave_repeats_its_run(model):
    slave = model.slave()
    model.start(slave)
    first = [model.step(slave, row) for row in range(1, 50)]
    slave.reset()
    slave.setupExperiment(startTime=0.0)
    slave.enterInitializationMode()
    model.set_row(slave, 0)
    slave.exitInitializationMode()
    assert [model.step(slave, row) for row in range(1, 50)] == first
    slave.freeInstance()


def test_impossible_values_are_errors_and_the_slave_goes_on(model):
    slave = model.slave()
    model.start(slave)
    model.step(slave, 1)
    reference = model.variables[model.names("input")[0]].valueReference
    for value in (math.nan, math.inf):
        with pytest.raises(FMICallException):
            slave.setReal([reference], [value])
    with pytest.raises(FMICallException):
        slave.setReal([987654], [1.0])
    with pytest.raises(FMICallException):
        slave.doStep(model.rows[1][0], 0.0)
    expected = model.step(slave, 2)
    slave.freeInstance()

    fresh = model.slave()
    model.start(fresh)
    model.step(fresh, 1)
    assert model.step(fresh, 2) == expected
    fresh.freeInstance()


def test_parameters_act(model):
    changed = {
        "JenkinsContact": "friction_coefficient", "ValanisContact": "smoothness", "SlipSlapContact": "normal_exponent"
    }
    parameter = model.variables[changed.get(model.name, "youngs_modulus")]
    runs = []
    for factor in (1.0, 1.2):
        slave = model.slave()
        slave.instantiate()
        slave.setReal([parameter.valueReference], [float(parameter.start) * factor])
        slave.setupExperiment(startTime=0.0)
        slave.enterInitializationMode()
        model.set_row(slave, 0)
        slave.exitInitializationMode()
        runs.append([model.step(slave, row) for row in range(1, 60)])
        slave.freeInstance()
    assert runs[0] != runs[1]


def test_nothing_is_written_to_the_console(model, capfd):
    slave = model.slave()
    model.start(slave)
    model.step(slave, 1)
    slave.terminate()
    slave.freeInstance()
    captured = capfd.readouterr()
    assert captured.out == "" and captured.err == ""
