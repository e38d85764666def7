"""Two more importers, independent of FMPy and of each other: fmuloader (ctypes), libcosimpy (FMILibrary)."""

import math

import pytest
from fmuloader.fmi2 import Fmi2Slave, Fmi2Type
from fmuloader.fmi3 import Fmi3Slave
from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimManipulator import CosimManipulator
from libcosimpy.CosimObserver import CosimObserver
from libcosimpy.CosimSlave import CosimLocalSlave


def test_fmuloader_gets_the_native_run(model):
    slave = Fmi2Slave(model.unpacked, model_identifier=model.name)
    slave.instantiate("one", Fmi2Type.CO_SIMULATION, guid=model.description.guid)
    slave.setup_experiment(start_time=0.0)
    slave.enter_initialization_mode()

    def set_inputs(row):
        for name in model.names("input"):
            value = model.rows[row][model.columns.index(name)]
            slave.set_real([model.variables[name].valueReference], [value])

    set_inputs(0)
    slave.exit_initialization_mode()
    outputs = [n for n in model.names("output") if model.variables[n].type == "Real"]
    references = [model.variables[name].valueReference for name in outputs]
    columns = [model.columns.index(name) for name in outputs]
    for row in range(1, len(model.rows)):
        before, time = model.rows[row - 1][0], model.rows[row][0]
        set_inputs(row)
        slave.do_step(before, time - before)
        for found, column in zip(slave.get_real(references), columns):
            scale = max(abs(other[column]) for other in model.rows)
            assert abs(found - model.rows[row][column]) <= 1e-9 * scale
        if row == 200:
            break
    state = slave.get_fmu_state()
    again = slave.deserialize_fmu_state(slave.serialize_fmu_state(state))
    slave.set_fmu_state(again)
    slave.free_fmu_state(state)
    slave.free_fmu_state(again)
    slave.terminate()
    slave.free_instance()


def test_fmuloader_gets_the_native_run_from_the_fmu_of_fmi_3(model3):
    slave = Fmi3Slave(model3.unpacked, model_identifier=model3.name)
    slave.instantiate_co_simulation("one", instantiation_token=model3.description.instantiationToken)
    slave.enter_initialization_mode(start_time=0.0)
    inputs = [model3.variables[name].valueReference for name in model3.names("input")]

    def set_inputs(row):
        slave.set_float64(inputs, [model3.rows[row][model3.columns.index(name)] for name in model3.names("input")])

    set_inputs(0)
    slave.exit_initialization_mode()
    outputs = [n for n in model3.names("output") if model3.variables[n].type == "Float64"]
    references = [model3.variables[name].valueReference for name in outputs]
    columns = [model3.columns.index(name) for name in outputs]
    for row in range(1, 201):
        before, time = model3.rows[row - 1][0], model3.rows[row][0]
        set_inputs(row)
        done = slave.do_step(before, time - before)
        assert not (done.event_handling_needed or done.terminate_simulation or done.early_return)
        assert done.last_successful_time == pytest.approx(time, rel=1e-9)
        for found, column in zip(slave.get_float64(references), columns):
            scale = max(abs(other[column]) for other in model3.rows)
            assert abs(found - model3.rows[row][column]) <= 1e-9 * scale
    state = slave.get_fmu_state()
    again = slave.deserialize_fmu_state(slave.serialize_fmu_state(state))
    slave.set_fmu_state(again)
    slave.free_fmu_state(state)
    slave.free_fmu_state(again)
    slave.terminate()
    slave.free_instance()


def test_libcosim_steps_it(model):
    execution = CosimExecution.from_step_size(step_size=100_000)
    index = execution.add_local_slave(CosimLocalSlave(fmu_path=str(model.fmu), instance_name="one"))
    manipulator = CosimManipulator.create_override()
    execution.add_manipulator(manipulator=manipulator)
    observer = CosimObserver.create_last_value()
    execution.add_observer(observer=observer)
    name = model.names("input")[0]
    value = {"displacement": 1e-6}.get(name, 1.0)
    manipulator.slave_real_values(index, [model.variables[name].valueReference], [value])
    assert execution.step(step_count=20)
    output = "force" if model.name.endswith("Contact") else "displacement:x=0.55"
    found = observer.last_real_values(index, [model.variables[output].valueReference])[0]
    assert math.isfinite(found) and found != 0.0
    if model.name == "JenkinsContact":
        assert found == pytest.approx(7.9, rel=1e-12)
