"""fmi-sim, a program: the stimuli are its input file, and its output file has all outputs that are no enumerations.

Where it cannot read an FMU, it is asked once more about a copy without what it does not know: see at-fault.md.
"""

import shutil
import subprocess
import sys
from xml.etree import ElementTree

from case import FOLDER, judge, table

UNKNOWN = ("unit", "displayUnit", "nominal")


def simulate(case, fmu):
    """The failure in one line, if it fails, and where the outputs are."""
    found = case.folder / "found.csv"
    files = ["--model", fmu, "--input-file", case.folder / FOLDER / "stimuli.csv", "--output-file", found]
    settings = ["--output-interval", case.step, "-f", case.times[-1], "--tolerance", case.tolerance]
    command = [sys.argv[1], *files, "co-simulation", *settings]
    done = subprocess.run([str(word) for word in command], capture_output=True, text=True)
    return done.stderr.partition("\n")[0] if done.returncode else None, found


def reduced(case):
    """A copy of the FMU without attributes that are unknown to it, and without arrays."""
    copy = case.folder / "copy"
    shutil.unpack_archive(case.fmu, copy, "zip")
    description = copy / "modelDescription.xml"
    tree = ElementTree.parse(description)
    variables, structure = tree.find("ModelVariables"), tree.find("ModelStructure")
    arrays = [variable for variable in variables if variable.find("Dimension") is not None]
    references = [array.get("valueReference") for array in arrays]
    for array in arrays:
        variables.remove(array)
    for entry in [entry for entry in structure if entry.get("valueReference") in references]:
        structure.remove(entry)
    for variable in variables:
        for name in UNKNOWN:
            variable.attrib.pop(name, None)
    tree.write(description)
    return shutil.make_archive(case.folder / "reduced", "zip", copy)


def remarks(case):
    failure, _ = simulate(case, case.fmu)
    if failure is None:
        return []
    return [f"does not read it: {failure}", f"without {', '.join(UNKNOWN)} and arrays in the description"]


def run(case):
    failure, found = simulate(case, case.fmu)
    if failure:
        failure, found = simulate(case, reduced(case))
    if failure:
        raise RuntimeError(failure)
    rows = table(found)
    return {name: rows[name][1:] for name in case.real_outputs()}


judge(run, remarks)
