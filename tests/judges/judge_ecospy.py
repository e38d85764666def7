"""Ecos with fmi4c, by ecospy."""

from ecospy import EcosSimulation, EcosSimulationStructure

from case import judge


def run(case):
    structure = EcosSimulationStructure()
    structure.add_model("one", str(case.fmu))
    structure.add_parameter_set("start", {f"one::{name}": value for name, value in case.inputs(0).items()})
    names = case.real_outputs()
    rows = []
    with EcosSimulation(structure=structure, step_size=case.step) as simulation:
        simulation.init(parameter_set="start")
        for row in range(len(case.times) - 1):
            for name, value in case.inputs(row).items():
                simulation.set_real(f"one::{name}", value)
            simulation.step()
            rows.append([simulation.get_real(f"one::{name}") for name in names])
        simulation.terminate()
    return {name: [row[column] for row in rows] for column, name in enumerate(names)}


judge(run)
