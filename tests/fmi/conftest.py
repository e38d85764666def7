"""The exported FMUs under importers that are not ours.

STICKSLIP_FMUS names the folder that the example `native_trajectories` of `stickslip-fmu-package`
wrote: an FMU and a CSV file of the same run without FMI for each standard model, and the FMU of FMI 3.0 in `fmi3/`.
"""

import csv
import os
import shutil
from pathlib import Path

import pytest
from fmpy import extract, read_model_description
from fmpy.fmi2 import FMU2Slave
from fmpy.fmi3 import FMU3Slave

MODELS = [
    "JenkinsContact", "ValanisContact", "SlipSlapContact", "ModalBeam", "ModalBeamTwoContacts", "FrictionalBeam",
    "PinnedBeam", "SlipSlapBeam",
]


def fmu_folder() -> Path:
    folder = os.environ.get("STICKSLIP_FMUS")
    if not folder:
        pytest.exit("STICKSLIP_FMUS must name the folder with the FMUs", returncode=4)
    return Path(folder).resolve()


class Model:
    """One unpacked FMU and its native run."""

    folder = ""

    def __init__(self, name: str, unpacked: Path):
        self.name = name
        self.fmu = fmu_folder() / self.folder / f"{name}.fmu"
        self.unpacked = unpacked
        self.description = read_model_description(str(self.fmu))
        self.variables = {v.name: v for v in self.description.modelVariables}
        with open(fmu_folder() / f"{name}.csv", newline="") as file:
            rows = list(csv.reader(file))
        self.columns = rows[0]
        self.rows = [[float(cell) for cell in row] for row in rows[1:]]

    def names(self, causality: str) -> list[str]:
        return [n for n in self.columns[1:] if self.variables[n].causality == causality]

    def slave(self, guid: str | None = None) -> FMU2Slave:
        return FMU2Slave(
            instanceName="one",
            guid=guid or self.description.guid,
            unzipDirectory=str(self.unpacked),
            modelIdentifier=self.name,
        )

    def get(self, slave: FMU2Slave, name: str) -> float:
        variable = self.variables[name]
        read = slave.getInteger if variable.type == "Integer" else slave.getReal
        return read([variable.valueReference])[0]

    def set_row(self, slave: FMU2Slave, row: int) -> None:
        """Sets the inputs of a row of the native run."""
        names = self.names("input")
        references = [self.variables[name].valueReference for name in names]
        values = [self.rows[row][self.columns.index(name)] for name in names]
        slave.setReal(references, values)

    def start(self, slave: FMU2Slave) -> None:
        slave.instantiate()
        slave.setupExperiment(startTime=0.0)
        slave.enterInitializationMode()
        self.set_row(slave, 0)
        slave.exitInitializationMode()

    def step(self, slave: FMU2Slave, row: int) -> list[float]:
        """The step to a row; all outputs after it."""
        before, time = self.rows[row - 1][0], self.rows[row][0]
        self.set_row(slave, row)
        slave.doStep(before, time - before)
        return [self.get(slave, name) for name in self.names("output")]


class Model3(Model):
    """The same of FMI 3.0."""

    folder = "fmi3"

    def slave(self, guid: str | None = None) -> FMU3Slave:
        return FMU3Slave(
            instanceName="one",
            guid=guid or self.description.instantiationToken,
            unzipDirectory=str(self.unpacked),
            modelIdentifier=self.name,
        )

    def get(self, slave: FMU3Slave, name: str) -> float:
        variable = self.variables[name]
        read = slave.getInt64 if variable.type == "Enumeration" else slave.getFloat64
        return read([variable.valueReference])[0]

    def set_row(self, slave: FMU3Slave, row: int) -> None:
        names = self.names("input")
        values = [self.rows[row][self.columns.index(name)] for name in names]
        slave.setFloat64([self.variables[name].valueReference for name in names], values)

    def start(self, slave: FMU3Slave, **arguments) -> None:
        slave.instantiate(**arguments)
        slave.enterInitializationMode(startTime=0.0)
        self.set_row(slave, 0)
        slave.exitInitializationMode()


@pytest.fixture(params=MODELS)
def model3(request, tmp_path):
    unpacked = tmp_path / "unpacked with a space"
    extract(str(fmu_folder() / f"fmi3/{request.param}.fmu"), unzipdir=str(unpacked))
    yield Model3(request.param, unpacked)
    shutil.rmtree(unpacked, ignore_errors=True)


@pytest.fixture(params=MODELS)
def model(request, tmp_path):
    unpacked = tmp_path / "unpacked with a space"
    extract(str(fmu_folder() / f"{request.param}.fmu"), unzipdir=str(unpacked))
    yield Model(request.param, unpacked)
    shutil.rmtree(unpacked, ignore_errors=True)
