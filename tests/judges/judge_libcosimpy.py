"""libcosim with FMILibrary, by libcosimpy. It sets no tolerance: the FMU's own, which is that of the reference."""

from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimManipulator import CosimManipulator
from libcosimpy.CosimObserver import CosimObserver
from libcosimpy.CosimSlave import CosimLocalSlave

from case import judge


def run(case):
    execution = CosimExecution.from_step_size(step_size=round(case.step * 1e9))
    slave = execution.add_local_slave(CosimLocalSlave(fmu_path=str(case.fmu), instance_name="one"))
    inputs = [case.variables[name].reference for name in case.stimuli]
    for reference, value in zip(inputs, case.inputs(0).values()):
        execution.real_initial_value(slave, reference, value)
    manipulator = CosimManipulator.create_override()
    execution.add_manipulator(manipulator=manipulator)
    observer = CosimObserver.create_last_value()
    execution.add_observer(observer=observer)
    names = case.real_outputs()
    references = [case.variables[name].reference for name in names]
    rows = []
    for row in range(len(case.times) - 1):
        manipulator.slave_real_values(slave, inputs, list(case.inputs(row).values()))
        if not execution.step():
            raise RuntimeError(f"the step from {case.times[row]} s fails")
        rows.append(list(observer.last_real_values(slave, references)))
    return {name: [row[column] for row in rows] for column, name in enumerate(names)}


judge(run)
