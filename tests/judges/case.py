"""What every judge is given: an FMU with its reference results.

A judge is a script that imports this file and calls `judge(run)`. It is started by its own interpreter, with an FMU as its last argument,
and prints one line: JUDGED, the result, a remark. `run(case)` steps the FMU through the stimuli and returns the values of outputs by
name, one for each row of the reference but the first; it may raise whatever it likes.
"""

import csv
import sys
import tempfile
import traceback
import zipfile
from pathlib import Path
from xml.etree import ElementTree

FOLDER = "extra/org.fmi-standard.fmi-ls-ref"
# Of the largest value of the output.
TOLERANCE = 1e-9


class Variable:
    def __init__(self, element, fmi: int):
        self.name = element.get("name")
        self.reference = int(element.get("valueReference"))
        self.causality = element.get("causality")
        # FMI 2.0 has the type within the variable.
        self.type = element[0].tag if fmi == 2 else element.tag


class Case:
    """An FMU of FMI 2.0 or 3.0, unpacked, with its variables, stimuli and reference results."""

    def __init__(self, fmu: Path, folder: Path):
        self.fmu, self.folder = fmu, folder
        with zipfile.ZipFile(fmu) as archive:
            archive.extractall(folder)
        root = ElementTree.parse(folder / "modelDescription.xml").getroot()
        self.fmi = int(root.get("fmiVersion")[0])
        self.identifier = root.find("CoSimulation").get("modelIdentifier")
        self.guid = root.get("guid") or root.get("instantiationToken")
        variables = (Variable(element, self.fmi) for element in root.find("ModelVariables"))
        self.variables = {variable.name: variable for variable in variables}
        self.stimuli = table(folder / FOLDER / "stimuli.csv")
        self.reference = table(folder / FOLDER / "reference.csv")
        self.times = self.reference.pop("time")
        self.stimuli.pop("time")
        self.step = self.times[1] - self.times[0]
        experiment = ElementTree.parse(folder / FOLDER / "experiments.exp").getroot()[0]
        self.tolerance = float(experiment.get("tolerance"))

    def real_outputs(self) -> list[str]:
        return [name for name in self.reference if self.variables[name].type in ("Real", "Float64")]

    def inputs(self, row: int) -> dict[str, float]:
        """Those that the step which begins at the row takes."""
        return {name: values[row] for name, values in self.stimuli.items()}


def table(file: Path) -> dict[str, list[float]]:
    with open(file, newline="") as lines:
        names, *rows = csv.reader(lines)
    return {name: [float(row[column]) for row in rows] for column, name in enumerate(names)}


def difference(case: Case, found: dict[str, list[float]]) -> tuple[float, str]:
    """The largest difference from the reference, relative to the largest value of the output, and where it is."""
    worst = (0.0, "")
    for name, values in found.items():
        expected = case.reference[name][1:]
        if len(values) != len(expected):
            raise AssertionError(f"{name}: {len(values)} values, not {len(expected)}")
        scale = max(map(abs, case.reference[name])) or 1.0
        worst = max(worst, (max(abs(a - b) for a, b in zip(values, expected)) / scale, name))
    return worst


def judge(run, remarks=lambda case: []) -> None:
    """Tells what comes of the FMU on the command line. `remarks` returns what else the judge says of it, or raises."""
    with tempfile.TemporaryDirectory() as folder:
        try:
            case = Case(Path(sys.argv[-1]).resolve(), Path(folder))
            lines = list(remarks(case))
            found = run(case)
            worst, name = difference(case, found) if found else (0.0, "")
            if worst > TOLERANCE:
                lines.append(f"`{name}` differs by {worst:.1e} of its largest value")
            result = "remarks" if lines else "good"
            distance = "bit by bit" if worst == 0.0 else f"within {worst:.0e}"
            compared = f"{len(found)} outputs {distance}" if found else "looks, does not run"
            remark = "; ".join([*lines, compared])
        except BaseException as error:  # a judge may also end by SystemExit
            traceback.print_exc()
            result, remark = "fails", f"{type(error).__name__}: {error}"
        print("JUDGED", result, " ".join(remark.split())[:300], flush=True)
