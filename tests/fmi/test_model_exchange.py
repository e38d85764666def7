"""The continuous-time form under FMPy's solvers, with events, against the slave in the same file."""

import numpy as np
import pytest
from fmpy import simulate_fmu

from conftest import fmu_folder

PERIOD = 0.02


def loop(load):
    """Three periods of a displacement with its velocity, under a normal load."""
    time = np.linspace(0.0, 3 * PERIOD, 3001)
    omega = 2 * np.pi / PERIOD
    columns = [time, 8e-5 * np.sin(omega * time), 8e-5 * omega * np.cos(omega * time), load(time)]
    names = [(name, float) for name in ("time", "displacement", "velocity", "normal_load")]
    return np.array(list(zip(*columns)), dtype=names)


def run(name, kind, names, **settings):
    return simulate_fmu(str(fmu_folder() / f"{name}.fmu"), fmi_type=kind, output=names, **settings)


def distances(name, names, tolerance=1e-5, lag=0.0, **settings):
    """Largest distance of each signal over its largest value, and the number of events.

    FMPy sets a slave's inputs at the beginning of a step, so that what follows them is one step older: the `lag`.
    """
    integrated = run(name, "ModelExchange", names, record_events=True, relative_tolerance=tolerance, **settings)
    stepped = run(name, "CoSimulation", names, **settings)
    time = integrated["time"]
    found = []
    for signal in names:
        # Rows of an event lie between those of the slave.
        here = np.interp(stepped["time"] - lag, time, integrated[signal])
        found.append(np.abs(here - stepped[signal]).max() / np.abs(stepped[signal]).max())
    return np.array(found), len(integrated) - len(stepped)


@pytest.mark.parametrize("solver", ["CVode", "Euler"])
@pytest.mark.parametrize("name", ["JenkinsContact", "ValanisContact"])
def test_a_contact_carries_the_force_of_the_slave(name, solver):
    for load in (lambda time: 0 * time + 140.0, lambda time: 140.0 + 60.0 * np.sin(170.0 * time + 0.3)):
        errors, events = distances(
            name, ["force", "dissipated_energy"], solver=solver, input=loop(load), stop_time=3 * PERIOD,
            output_interval=2e-5, step_size=2e-5, lag=2e-5,
        )  # fmt: skip
        assert (errors < 2e-3).all(), errors
        # Six reversals at least; Euler's scheme has its events at its own points.
        assert events >= 6 or solver == "Euler", events


def test_lift_off_and_meeting_again_are_events():
    load = lambda time: 40.0 + 100.0 * np.sin(200.0 * time)  # noqa: E731
    errors, events = distances(
        "JenkinsContact", ["force", "dissipated_energy"], input=loop(load), stop_time=3 * PERIOD,
        output_interval=2e-5, step_size=2e-5, lag=2e-5,
    )  # fmt: skip
    assert (errors < 2e-3).all(), errors
    assert events >= 8, events


def test_a_contact_in_two_directions_slips_parts_and_meets_again_as_the_slave_does():
    period = 0.01
    time = np.linspace(0.0, 4 * period, 4001)
    omega = 2 * np.pi / period
    opening = 1.2e-5 * np.sin(0.6 * omega * time)
    columns = [time, 4e-5 * np.sin(omega * time), 4e-5 * omega * np.cos(omega * time)]
    columns += [opening, np.gradient(opening, time)]
    names = [(name, float) for name in ("time", "displacement", "velocity", "opening", "opening_velocity")]
    motion = np.array(list(zip(*columns)), dtype=names)
    signals = ["force", "normal_force", "separation", "dissipated_energy"]
    errors, events = distances(
        "SlipSlapContact", signals, input=motion, stop_time=4 * period, output_interval=1e-5, step_size=1e-5, lag=1e-5,
    )  # fmt: skip
    assert (errors < 2e-3).all(), dict(zip(signals, errors))
    assert events >= 8, events


def test_a_frictional_beam_struck_by_a_force_rings_down_as_the_slave_does():
    names = ["force", "dissipated_energy", "displacement", "displacement:x=0.55", "velocity:x=0.55"]
    errors, events = distances(
        "FrictionalBeam", names, tolerance=1e-7, start_values={"excitation": 150.0}, stop_time=0.04,
        output_interval=1e-4, step_size=1e-4,
    )  # fmt: skip
    assert (errors < 2e-3).all(), dict(zip(names, errors))
    assert events > 0


@pytest.mark.parametrize("name", ["ModalBeam", "ModalBeamTwoContacts"])
def test_a_beam_under_forces_from_outside_moves_as_the_slave_does(name):
    names = ["displacement", "displacement:x=0.55", "velocity:x=0.55", "acceleration:x=0.55"]
    errors, _ = distances(
        name, names, tolerance=1e-8, start_values={"excitation": 20.0, "contact_force": 5.0}, stop_time=0.02,
        output_interval=1e-4, step_size=1e-4,
    )  # fmt: skip
    assert (errors < 1e-4).all(), dict(zip(names, errors))
