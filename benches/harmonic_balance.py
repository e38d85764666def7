#!/usr/bin/env python3
"""Harmonic balance side by side: stickslip and pyHarm on the two masses with a Jenkins element.

    python3 benches/harmonic_balance.py

Stands alone: makes its own environment under target/ with the packages of benches/requirements.txt, runs
pyHarm, checks its answers against the event-driven exact solution, runs `cargo bench --bench harmonic`, prints
both in one table and writes benches/harmonic-balance.md and benches/harmonic-balance.svg.

Both sides follow the same response curve by arc length on one core; times are of the fastest of several runs
after one that warms up (pyHarm compiles parts of itself on first use). pyHarm is run a second time with the
number of threads its linear algebra takes by itself.
"""

import argparse
import json
import os
import pathlib
import platform
import subprocess
import sys
import time
import venv

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent
TARGET = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")).resolve()
ENVIRONMENT = TARGET / "harmonic-balance"
RECORD = TARGET / "harmonic-balance.json"
REQUIREMENTS = HERE / "requirements.txt"
THREAD_VARIABLES = ("OMP_NUM_THREADS", "OPENBLAS_NUM_THREADS", "MKL_NUM_THREADS", "RAYON_NUM_THREADS")
COMMAND = "python3 benches/harmonic_balance.py"
CARGO = ["cargo", "bench", "-p", "stickslip", "--bench", "harmonic"]

# k1 = 1, k2 = 0.5, c1 = c2 = 0.1, m1 = m2 = 1; Jenkins element on the second mass, force on the first.
STIFFNESS = [[1.5, -0.5], [-0.5, 0.5]]
DAMPING = 0.1
FRICTION, NORMAL_LOAD, TANGENTIAL_STIFFNESS, FORCE = 0.02, 1.0, 0.2, 0.4
RANGE = (0.2, 2.0)
# Angular frequency (rad/s): largest displacements x, y (m) and energy dissipated per cycle (J) of the
# event-driven exact solution, periodic to 2e-14.
EXACT = {
    0.5: (0.9273567601, 1.7803402056, 0.1344272164),
    1.0: (0.3905353959, 0.4036689866, 0.0242935189),
    1.3: (2.5342914047, 1.0651770248, 0.0772141620),
    2.0: (0.1643969548, 0.0248630093, 0.0),
}
# What 20 harmonics and 1024 samples of a period leave, by a wide margin.
AGREEMENT = 2e-5


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("--harmonics", type=int, default=20, help="of pyHarm (default 20)")
    parser.add_argument("--samples", type=int, default=1024, help="of a period in pyHarm (default 1024)")
    parser.add_argument("--step", type=float, default=0.1, help="longest arc-length step of pyHarm (default 0.1)")
    parser.add_argument("--redraw", type=pathlib.Path, metavar="JSON", help="page and plots of an earlier run's record")
    parser.add_argument("--measure-pyharm", action="store_true", help=argparse.SUPPRESS)
    arguments = parser.parse_args()
    if pathlib.Path(sys.prefix).resolve() != ENVIRONMENT.resolve():
        return in_environment()
    if arguments.measure_pyharm:
        print(json.dumps(measure_pyharm(arguments)))
        return 0
    record = json.loads(arguments.redraw.read_text()) if arguments.redraw else measure(arguments)
    if not arguments.redraw:
        RECORD.write_text(json.dumps(record, indent=1) + "\n")
    print(table(record))
    (HERE / "harmonic-balance.md").write_text(page(record), encoding="utf-8")
    draw(record, HERE / "harmonic-balance.svg")
    return 0


def in_environment():
    """Makes the environment where it is missing or not of these requirements; runs this script in it."""
    if sys.version_info < (3, 11):
        sys.exit(f"pyHarm needs Python 3.11 or newer; this is {platform.python_version()}")
    python = ENVIRONMENT / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    installed = ENVIRONMENT / "requirements.txt"
    if not installed.exists() or installed.read_bytes() != REQUIREMENTS.read_bytes():
        print(f"making {ENVIRONMENT}", file=sys.stderr)
        venv.create(ENVIRONMENT, clear=True, with_pip=True)
        pip = [python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", "-r", REQUIREMENTS]
        subprocess.run(pip, check=True)
        installed.write_bytes(REQUIREMENTS.read_bytes())
    return subprocess.run([python, __file__, *sys.argv[1:]]).returncode


def measure(arguments):
    one_thread = os.environ | dict.fromkeys(THREAD_VARIABLES, "1")
    own_choice = {key: value for key, value in os.environ.items() if key not in THREAD_VARIABLES}
    # Compiled before anything is timed.
    subprocess.run([*CARGO, "--no-run"], cwd=ROOT, check=True)
    script = [sys.executable, HERE / "harmonic_balance.py", "--measure-pyharm"]
    for name in ("harmonics", "samples", "step"):
        script += [f"--{name}", str(getattr(arguments, name))]
    record = {"machine": machine()}
    for name, environment in (("pyharm", one_thread), ("pyharm_own_threads", own_choice)):
        print(f"running {name} …", file=sys.stderr)
        output = subprocess.run(script, env=environment, check=True, stdout=subprocess.PIPE, text=True).stdout
        record[name] = json.loads(output.splitlines()[-1])
    print("running stickslip …", file=sys.stderr)
    output = subprocess.run(
        [*CARGO, "--", "--json"], cwd=ROOT, env=one_thread, check=True, stdout=subprocess.PIPE, text=True
    ).stdout
    record["stickslip"] = json.loads(output)
    return record


def machine():
    model = platform.processor() or platform.machine()
    cpuinfo = pathlib.Path("/proc/cpuinfo")
    if cpuinfo.exists():
        names = [line.split(":", 1)[1] for line in cpuinfo.read_text().splitlines() if line.startswith("model name")]
        model = names[0].strip() if names else model
    load = os.getloadavg()[0] if hasattr(os, "getloadavg") else float("nan")
    return {"processor": model, "cores": os.cpu_count(), "load": load}


# ---- pyHarm


def pyharm_input(arguments, start, end):
    import numpy

    return {
        "analysis": {
            "curve": {
                "study": "frf",
                "corrector": "arc_length",
                "predictor": "tangent",
                "solver": "scipyroot",
                "ds0": min(0.01, arguments.step),
                "ds_max": arguments.step,
                "ds_min": 1e-8,
                "puls_inf": start,
                "puls_sup": end,
                "verbose": False,
            }
        },
        "system": {"type": "Base", "nh": arguments.harmonics, "nti": arguments.samples},
        "substructures": {
            "masses": {
                "ndofs": 1,
                "nnodes": 2,
                "matrix": {
                    "M": numpy.eye(2),
                    "C": DAMPING * numpy.eye(2),
                    "K": numpy.array(STIFFNESS),
                    "G": numpy.zeros((2, 2)),
                },
            }
        },
        "connectors": {
            "friction": {
                "type": "Jenkins",
                "connect": {"masses": [1]},
                "dirs": [0],
                "mu": FRICTION,
                "N0": NORMAL_LOAD,
                "k": TANGENTIAL_STIFFNESS,
            },
            "force": {"type": "CosinusForcing", "connect": {"masses": [0]}, "dirs": [0], "amp": FORCE},
        },
    }


def measure_pyharm(arguments):
    import logging

    logging.disable(logging.INFO)
    os.chdir(ENVIRONMENT)  # pyHarm leaves a file where it runs
    from importlib.metadata import version

    from pyHarm.Maestro import Maestro

    error = max(pyharm_error(arguments, frequency) for frequency in EXACT)
    if not error <= AGREEMENT:
        sys.exit(f"pyHarm is off the exact solution by {error:.1e}, more than {AGREEMENT:.0e}")
    best, begun = None, time.perf_counter()
    for run in range(3):
        if run > 0 and time.perf_counter() - begun > 60.0:
            break
        maestro = Maestro(pyharm_input(arguments, *RANGE))
        analysis = maestro.nls["curve"]
        started = time.perf_counter()
        analysis.Solve()
        seconds = time.perf_counter() - started
        accepted = [solution for solution in analysis.SolList if solution.flag_accepted]
        if accepted[-1].x[-1] < RANGE[1]:
            sys.exit("pyHarm did not reach the end of the range")
        if best is None or seconds < best["seconds"]:
            best = {"seconds": seconds, "points": len(accepted)}
    return {
        "version": version("pyharm-os"),
        "harmonics": arguments.harmonics,
        "samples": arguments.samples,
        "largest_error": error,
        "seconds_per_point": best["seconds"] / best["points"],
        **best,
    }


def pyharm_error(arguments, frequency):
    """Largest relative error of both displacements and the dissipated energy at one frequency."""
    import numpy
    from pyHarm.Maestro import Maestro

    maestro = Maestro(pyharm_input(arguments, frequency, frequency + 1.0))
    analysis = maestro.nls["curve"]
    analysis.initialise()  # solves at the start of the range
    solution = analysis.SolList[-1].x[:-1]
    angle = numpy.linspace(0.0, 2.0 * numpy.pi, 40_000, endpoint=False)
    orders = numpy.arange(1, arguments.harmonics + 1)
    basis = numpy.ones((2 * orders.size + 1, angle.size))
    basis[1::2] = numpy.cos(numpy.outer(orders, angle))
    basis[2::2] = numpy.sin(numpy.outer(orders, angle))
    nodes = solution.reshape(-1, 2)
    largest = numpy.abs(nodes.T @ basis).max(axis=1)
    friction = next(element for element in maestro.system.LE if type(element).__name__ == "Jenkins")
    force = numpy.zeros_like(solution)
    force[friction.indices] = friction.evalResidual(solution, frequency)
    force, moved = force.reshape(-1, 2)[:, 1], nodes[:, 1]
    dissipated = numpy.pi * numpy.sum(orders * (force[1::2] * moved[2::2] - force[2::2] * moved[1::2]))
    found = (*largest, dissipated)
    return max(abs(a - b) / (abs(b) or 1.0) for a, b in zip(found, EXACT[frequency]))


# ---- what is shown


def rows(record):
    """Solver, harmonics, points, milliseconds of the curve and of a point, ratio to stickslip's point."""
    ours, per_point = record["stickslip"]["seed3"], record["stickslip"]["seed3"]["seconds_per_point"]
    yield "stickslip, one core", ours["harmonics"], ours["points"], ours["points"] * per_point, per_point, 1.0
    for name, label in (("pyharm", "one core"), ("pyharm_own_threads", "threads as it takes them")):
        run = record[name]
        solver = f"pyHarm {run['version']}, {label}"
        point = run["seconds_per_point"]
        yield solver, run["harmonics"], run["points"], run["seconds"], point, point / per_point


def table(record):
    lines = [
        "| solver | harmonics | points | curve (ms) | point (µs) | ratio |",
        "|---|---:|---:|---:|---:|---:|",
    ]
    for solver, harmonics, points, curve, point, ratio in rows(record):
        times = f"{1e3 * curve:.3g} | {1e6 * point:.3g}" if curve < 1 else f"{1e3 * curve:.0f} | {1e6 * point:.0f}"
        lines.append(f"| {solver} | {harmonics} | {points} | {times} | {ratio:.0f} |")
    return "\n".join(lines)


def page(record):
    machine, ours, pyharm = record["machine"], record["stickslip"], record["pyharm"]
    return f"""# Harmonic balance, measured

Two masses with a Jenkins element, 0.2 … 2.0 rad/s under arc-length continuation. Command:

```sh
{COMMAND}
```

{table(record)}

Fastest of several runs, warm. pyHarm samples the period {pyharm["samples"]} times; its largest error at
0.5, 1.0, 1.3 and 2.0 rad/s against the event-driven exact solution is {pyharm["largest_error"]:.1e}. Left to
itself its linear algebra starts a thread per core, which costs more than it gains at this size.

{beam(ours)}Machine: {machine["processor"]}, {machine["cores"]} cores, load {machine["load"]:.1f} when the run began.

## How the cost grows

![Time of a point against harmonics, sliders and degrees of freedom](harmonic-balance.svg)

Structures of up to 300 degrees of freedom are prepared once as sums over all their modes; above that the dynamic
stiffness is factorised, sparse, at every harmonic of every step.

{growth(ours)}
"""


def beam(ours):
    if "beam" not in ours:
        return ""
    modes, harmonics = ours["beam"]["modes"], ours["beam"]["harmonics"]
    return f"""The beam with a frictional support ({modes} modes, Valanis' law, {harmonics} harmonics, response held):
{1e3 * ours["beam"]["seconds_per_point"]:.3g} ms a point. Command: `{" ".join(CARGO)}`

"""


def growth(ours):
    def lines(title, unit, series, key):
        yield f"| {title} | {unit} |"
        yield "|---:|---:|"
        for entry in series:
            yield f"| {entry[key]} | {1e6 * entry['seconds_per_point']:.3g} |"
        yield ""

    freedoms = ["| degrees of freedom | preparation (ms) | point (µs) |", "|---:|---:|---:|"]
    for entry in ours["by_degrees_of_freedom"]:
        preparation, point = 1e3 * entry["preparation_seconds"], 1e6 * entry["seconds_per_point"]
        freedoms.append(f"| {entry['degrees_of_freedom']} | {preparation:.3g} | {point:.3g} |")
    return "\n".join(
        [
            *lines("harmonics", "point (µs)", ours["by_harmonics"], "harmonics"),
            *lines("sliders", "point (µs)", ours["by_sliders"], "sliders"),
            *freedoms,
        ]
    )


def draw(record, path):
    import matplotlib

    matplotlib.use("svg")
    # The same record gives the same file to the last byte.
    matplotlib.rcParams.update({"svg.hashsalt": "stickslip", "svg.fonttype": "none", "font.size": 9})
    from matplotlib import pyplot

    ours = record["stickslip"]
    panels = [
        ("harmonics", ours["by_harmonics"], "harmonics", "two masses, one slider"),
        ("sliders", ours["by_sliders"], "sliders", "two masses, 21 harmonics"),
        ("degrees of freedom", ours["by_degrees_of_freedom"], "degrees_of_freedom", "rod with a slider, 21 harmonics"),
    ]
    figure, axes = pyplot.subplots(1, 3, figsize=(10.5, 3.4), layout="constrained")
    for panel, (label, series, key, title) in zip(axes, panels):
        size = [entry[key] for entry in series]
        panel.loglog(size, [1e6 * entry["seconds_per_point"] for entry in series], "o-", ms=4, label="point")
        if "preparation_seconds" in series[0]:
            preparation = [1e6 * entry["preparation_seconds"] for entry in series]
            panel.loglog(size, preparation, "s--", ms=4, label="preparation, once")
            panel.legend(frameon=False)
        panel.set(xlabel=label, ylabel="time (µs)", title=title)
        panel.grid(True, which="major", alpha=0.3)
    figure.savefig(path, metadata={"Date": None, "Creator": None})


if __name__ == "__main__":
    sys.exit(main())
