"""FMPy: its validator, and its co-simulation."""

import fmpy
import numpy as np
from fmpy.validation import validate_fmu

from case import judge


def run(case):
    names = list(case.stimuli)
    rows = zip(case.times, *case.stimuli.values())
    signals = np.array(list(rows), dtype=[("time", float)] + [(name, float) for name in names])
    found = fmpy.simulate_fmu(
        str(case.folder), stop_time=case.times[-1], step_size=case.step, output_interval=case.step,
        relative_tolerance=case.tolerance, fmi_type="CoSimulation", input=signals, output=case.real_outputs(),
    )
    return {name: list(found[name][1:]) for name in case.real_outputs()}


judge(run, lambda case: validate_fmu(str(case.fmu)))
