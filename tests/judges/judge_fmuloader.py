"""fmuloader: another binding to the C functions."""

from fmuloader.fmi2 import Fmi2Slave, Fmi2Type

from case import judge


def run(case):
    slave = Fmi2Slave(case.folder, model_identifier=case.identifier)
    slave.instantiate("one", Fmi2Type.CO_SIMULATION, guid=case.guid)
    slave.setup_experiment(tolerance=case.tolerance, start_time=0.0, stop_time=case.times[-1])
    names = case.real_outputs()
    references = [case.variables[name].reference for name in names]

    def set_inputs(row):
        for name, value in case.inputs(row).items():
            slave.set_real([case.variables[name].reference], [value])

    slave.enter_initialization_mode()
    set_inputs(0)
    slave.exit_initialization_mode()
    rows = []
    for row, (begin, end) in enumerate(zip(case.times, case.times[1:])):
        set_inputs(row)
        slave.do_step(begin, end - begin)
        rows.append(slave.get_real(references))
    slave.terminate()
    slave.free_instance()
    return {name: [row[column] for row in rows] for column, name in enumerate(names)}


judge(run)
