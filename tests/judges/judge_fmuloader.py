"""fmuloader: another binding to the C functions."""

from fmuloader.fmi2 import Fmi2Slave, Fmi2Type
from fmuloader.fmi3 import Fmi3Slave

from case import judge


def initializing(case):
    """The slave in initialization mode, and its functions for real variables."""
    stop = case.times[-1]
    if case.fmi == 2:
        slave = Fmi2Slave(case.folder, model_identifier=case.identifier)
        slave.instantiate("one", Fmi2Type.CO_SIMULATION, guid=case.guid)
        slave.setup_experiment(tolerance=case.tolerance, start_time=0.0, stop_time=stop)
        slave.enter_initialization_mode()
        return slave, slave.set_real, slave.get_real
    slave = Fmi3Slave(case.folder, model_identifier=case.identifier)
    slave.instantiate_co_simulation("one", instantiation_token=case.guid)
    slave.enter_initialization_mode(start_time=0.0, stop_time=stop, tolerance=case.tolerance)
    return slave, slave.set_float64, slave.get_float64


def run(case):
    slave, set_values, get_values = initializing(case)
    names = case.real_outputs()
    references = [case.variables[name].reference for name in names]

    def set_inputs(row):
        for name, value in case.inputs(row).items():
            set_values([case.variables[name].reference], [value])

    set_inputs(0)
    slave.exit_initialization_mode()
    rows = []
    for row, (begin, end) in enumerate(zip(case.times, case.times[1:])):
        set_inputs(row)
        slave.do_step(begin, end - begin)
        rows.append(get_values(references))
    slave.terminate()
    slave.free_instance()
    return {name: [row[column] for row in rows] for column, name in enumerate(names)}


judge(run)
