"""Drives an FMU of a beam from rest by the force of a steady record and compares its steady state with the record.

    python predict.py FMU RECORD.csv PERIODS

PERIODS is the number of periods in the record. Needs FMPy and NumPy: pip install fmpy
"""

import csv
import sys
import tempfile

import numpy as np
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave

# From rest until the motion repeats, and steps of a period.
SETTLING, STEPS = 150, 256
HARMONICS = 9


def read(file):
    """The columns of a record by name, without their units."""
    with open(file, newline="") as lines:
        rows = list(csv.reader(lines))
    columns = np.array(rows[1:], dtype=float).T
    return {name.split(" [")[0]: column for name, column in zip(rows[0], columns)}


def driven(fmu, step, force):
    """The outputs of an FMU under a force that runs straight from step to step."""
    description = read_model_description(str(fmu))
    outputs = {v.name: v.valueReference for v in description.modelVariables if v.causality == "output"}
    # Integers are read by another function.
    del outputs["slip_state"]
    excitation = [v.valueReference for v in description.modelVariables if v.name == "excitation"]
    rows = []
    with tempfile.TemporaryDirectory() as folder:
        slave = FMU2Slave(
            instanceName="beam",
            guid=description.guid,
            unzipDirectory=extract(str(fmu), unzipdir=folder),
            modelIdentifier=description.coSimulation.modelIdentifier,
        )
        slave.instantiate()
        slave.setupExperiment(startTime=0.0)
        slave.enterInitializationMode()
        slave.exitInitializationMode()
        for k, (now, then) in enumerate(zip(force[:-1], force[1:])):
            slave.setReal(excitation, [now])
            slave.setRealInputDerivatives(excitation, [1], [(then - now) / step])
            slave.doStep(k * step, step)
            rows.append(slave.getReal(list(outputs.values())))
        slave.terminate()
        slave.freeInstance()
    return dict(zip(outputs, np.array(rows).T))


def coefficients(phases, values, harmonics=HARMONICS):
    """Of the harmonics by least squares, the mean left out."""
    orders = np.outer(phases, np.arange(1, harmonics + 1))
    columns = np.hstack([np.ones((len(phases), 1)), np.cos(orders), np.sin(orders)])
    return np.linalg.lstsq(columns, values, rcond=None)[0][1:]


def predict(fmu, record, periods):
    """By channel, the coefficients of the record and of the FMU's last eight periods."""
    measured = read(record)
    time = measured["time"]
    step = (time[1] - time[0]) * len(time) / periods / STEPS
    recorded = 2 * np.pi * time / (STEPS * step)
    cosine, sine = coefficients(recorded, measured["excitation"], 1)
    phases = 2 * np.pi / STEPS * np.arange(SETTLING * STEPS + 1)
    found = driven(fmu, step, cosine * np.cos(phases) + sine * np.sin(phases))
    last = slice(-8 * STEPS, None)
    return {
        name: (coefficients(recorded, measured[name]), coefficients(phases[1:][last], found[name][last]))
        for name in measured
        if name in found
    }


def error(expected, found):
    """Root mean square of the difference over that of what is expected."""
    return np.linalg.norm(found - expected) / np.linalg.norm(expected)


if __name__ == "__main__":
    for name, pair in predict(sys.argv[1], sys.argv[2], int(sys.argv[3])).items():
        print(f"{name}: {100 * error(*pair):.2f} % off")
