"""Terminals, icons, types, display units and reference results of the exported FMUs."""

import csv
from pathlib import Path

import fmpy
import numpy as np
import pytest
from lxml import etree
from PIL import Image

REFERENCE = "extra/org.fmi-standard.fmi-ls-ref"
MANIFEST = "{http://fmi-standard.org/fmi-ls-manifest}"


def terminals(model):
    return etree.parse(str(model.unpacked / "terminalsAndIcons/terminalsAndIcons.xml"))


def test_terminals_obey_the_schema_of_fmi_3_which_is_that_of_fmi_2_too(model):
    schema = Path(fmpy.__file__).parent / "schema/fmi3/fmi3TerminalsAndIcons.xsd"
    checker = etree.XMLSchema(etree.parse(str(schema)))
    assert checker.validate(terminals(model)), checker.error_log


def test_every_flange_joins_a_motion_with_a_force_the_other_way(model):
    found = terminals(model).findall(".//Terminal")
    assert (len(found) == 0) == (model.name in ("FrictionalBeam", "SlipSlapBeam"))
    for terminal in found:
        members = {m.get("memberName"): m for m in terminal.findall("TerminalMemberVariable")}
        causality = {name: model.variables[m.get("variableName")].causality for name, m in members.items()}
        units = {name: model.variables[m.get("variableName")].unit for name, m in members.items()}
        assert {causality["position"], causality["force"]} == {"input", "output"}
        assert causality.get("velocity", causality["position"]) == causality["position"]
        assert (units["position"], units["force"], units.get("velocity", "m/s")) == ("m", "N", "m/s")
        assert members["force"].get("variableKind") == ("inflow" if causality["force"] == "output" else "outflow")


def test_every_picture_that_is_named_is_there_twice(model):
    folder = model.unpacked / "terminalsAndIcons"
    names = {t.get("iconBaseName") for t in terminals(model).findall(".//TerminalGraphicalRepresentation")} | {"icon"}
    for name in names:
        with Image.open(folder / f"{name}.png") as picture:
            assert picture.size[0] == picture.size[1] >= 32
        assert etree.parse(str(folder / f"{name}.svg")).getroot().tag.endswith("svg")
    assert (model.unpacked / "model.png").read_bytes() == (folder / "icon.png").read_bytes()


def test_types_and_display_units_are_defined(model):
    description = model.description
    units = {u.name: {d.name: d for d in u.displayUnits} for u in description.unitDefinitions}
    for variable in description.modelVariables:
        if variable.declaredType is not None:
            assert variable.declaredType.unit == variable.unit
        if variable.displayUnit:
            assert variable.displayUnit in units[variable.unit]
    assert units["m"]["mm"].factor == 1e3 and units["N"]["kN"].factor == 1e-3
    assert description.author and description.generationDateAndTime


def test_the_manifest_names_files_that_are_there(model):
    root = etree.parse(str(model.unpacked / REFERENCE / "fmi-ls-manifest.xml")).getroot()
    assert root.get(f"{MANIFEST}fmi-ls-name") == "org.fmi-standard.fmi-ls-ref"
    assert root.get(f"{MANIFEST}fmi-ls-version") == "1.0.0-alpha.1"
    for related in root.findall("Related"):
        assert (model.unpacked / REFERENCE / related.get("source")).is_file()


def read(path):
    with open(path, newline="") as file:
        names, *rows = list(csv.reader(file))
    return names, np.array([[float(cell) for cell in row] for row in rows])


def test_an_importer_repeats_the_reference_results(model):
    folder = model.unpacked / REFERENCE
    experiment = etree.parse(str(folder / "experiments.exp")).find("Experiment")
    names, stimuli = read(folder / experiment.find("Stimuli").get("source"))
    columns, expected = read(folder / experiment.find("References").get("source"))
    signals = np.array([tuple(row) for row in stimuli], dtype=[(name, float) for name in names])
    step = float(experiment.get("stepSize"))
    outputs = [name for name in columns[1:] if model.variables[name].type == "Real"]
    found = fmpy.simulate_fmu(
        str(model.unpacked),
        stop_time=float(experiment.get("stopTime")),
        step_size=step,
        output_interval=step,
        relative_tolerance=float(experiment.get("tolerance")),
        fmi_type="CoSimulation",
        input=signals,
        output=outputs,
    )
    assert len(found) == len(expected) == 201
    for name in outputs:
        column = expected[:, columns.index(name)]
        scale = np.abs(column).max()
        assert found[name] == pytest.approx(column, rel=0, abs=1e-9 * scale), name
        # A run that shows nothing would agree with anything.
        assert scale > 0.0, name
