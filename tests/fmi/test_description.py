"""The archive and its model description."""

import zipfile
from pathlib import Path

import fmpy
from fmpy.validation import validate_fmu
from lxml import etree


def test_the_validator_reports_nothing(model):
    assert validate_fmu(str(model.fmu)) == []


def test_the_xml_obeys_the_schema_of_the_standard(model):
    schema = Path(fmpy.__file__).parent / "schema/fmi2/fmi2ModelDescription.xsd"
    document = etree.parse(str(model.unpacked / "modelDescription.xml"))
    checker = etree.XMLSchema(etree.parse(str(schema)))
    assert checker.validate(document), checker.error_log


def test_the_archive_has_binary_model_documentation_and_licences(model):
    names = set(zipfile.ZipFile(model.fmu).namelist())
    assert {"modelDescription.xml", "resources/model.toml", "documentation/index.html"} <= names
    assert any(name.startswith("binaries/") and f"/{model.name}." in name for name in names)
    assert sum(name.startswith("documentation/licenses/LICENSE") for name in names) == 2


def test_capabilities_and_default_experiment_are_complete(model):
    slave = model.description.coSimulation
    assert slave.canGetAndSetFMUstate and slave.canSerializeFMUstate
    assert slave.canHandleVariableCommunicationStepSize
    assert slave.canInterpolateInputs and slave.providesDirectionalDerivative
    assert slave.maxOutputDerivativeOrder == 1
    assert not slave.canBeInstantiatedOnlyOncePerProcess
    experiment = model.description.defaultExperiment
    given = [experiment.startTime, experiment.stopTime, experiment.tolerance, experiment.stepSize]
    assert None not in given


def test_model_exchange_has_a_derivative_for_every_state_and_indicators_for_every_contact(model):
    description = model.description
    assert description.modelExchange.canGetAndSetFMUstate and description.modelExchange.needsCompletedIntegratorStep
    modes = sum(v.name.startswith("modal_displacement") for v in description.modelVariables)
    assert description.numberOfContinuousStates == 2 * modes
    assert (modes > 0) == ("Beam" in model.name)
    for unknown in description.derivatives:
        assert unknown.variable.derivative is not None
    has_contact = any(v.name == "slip_state" for v in description.modelVariables)
    assert description.numberOfEventIndicators == (3 if has_contact else 0)


def test_every_variable_has_a_description_and_every_real_a_unit(model):
    for variable in model.description.modelVariables:
        assert variable.description, variable.name
        assert variable.type == "Integer" or variable.unit, variable.name
    assert not any(v.causality == "independent" for v in model.description.modelVariables)


def test_declared_dependencies_are_those_that_act(model):
    """At the end of the initialization: an input or parameter that changes an output is declared."""
    variables = model.description.modelVariables
    # Continuous states and their derivatives are declared to depend on anything.
    outputs_declared = [u for u in model.description.initialUnknowns if u.variable.causality == "output"]
    declared = {u.variable.name: {v.name for v in u.dependencies} for u in outputs_declared}
    knowns = [v for v in variables if v.causality in ("input", "parameter")]

    def outputs(changed, value):
        slave = model.slave()
        slave.instantiate()
        slave.enterInitializationMode()
        for known in knowns:
            if known.causality == "input" and known is not changed:
                # Away from zero, where everything acts.
                base = {"displacement": 3e-5, "normal_load": 100.0}.get(known.name, 1.0)
                slave.setReal([known.valueReference], [base])
        if changed is not None:
            slave.setReal([changed.valueReference], [value])
        result = {name: model.get(slave, name) for name in declared}
        slave.exitInitializationMode()
        slave.freeInstance()
        return result

    reference = outputs(None, 0.0)
    for known in knowns:
        start = {"displacement": 3e-5, "normal_load": 100.0}.get(known.name) or float(known.start) or 1.0
        # Small enough that every neighbour makes a model (a beam must still carry its masses).
        changed = outputs(known, start * 1.001 + (0.5 if known.causality == "input" else 0.0) * start)
        for name, value in changed.items():
            if value != reference[name]:
                assert known.name in declared[name], f"{name} depends on {known.name}"
