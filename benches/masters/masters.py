"""Our master beside libcosim, Ecos and FMPy on the same `.ssp`, and every algorithm of ours on every signal.

`cargo xtask masters` runs it: masters.py PROGRAM FOLDER writes FOLDER/masters.md and a drawing for each system. The reference is
the beam with the contact inside, FrictionalBeam's model with the contact of the system: steps of 1e-6 s, tolerance 1e-11.
"""

import csv
import json
import os
import subprocess
import sys
import tempfile
import time
import zipfile
from importlib.metadata import version
from math import log
from pathlib import Path

import numpy as np

# The force lets both contacts slip; that of the packages, 20 N, leaves Jenkins' element stuck.
STOP, GRID, EXCITATION = 0.1, 1e-3, 60.0
REPETITIONS = 3
STEPS = [1e-3, 5e-4, 2e-4, 1e-4, 5e-5, 2e-5, 1e-5]
COMPARED = [1e-4, 1e-5]
SYSTEM, MONOLITH = "BeamWithValanis", "FrictionalBeam"
MODELS = Path(__file__).parents[2] / "modelDescription"
# Systems whose convergence is shown, each with the contact that the monolith has inside.
SYSTEMS = {"BeamWithValanis": "ValanisContact", "BeamWithJenkins": "JenkinsContact"}
ALGORITHMS = {
    "Jacobi, held": ["--algorithm", "jacobi", "--extrapolation", "0"],
    "Gauss–Seidel, held": ["--algorithm", "gauss-seidel", "--extrapolation", "0"],
    "Jacobi, extrapolated": ["--algorithm", "jacobi", "--extrapolation", "1"],
    "Gauss–Seidel, extrapolated": ["--algorithm", "gauss-seidel", "--extrapolation", "1"],
    "strong": ["--algorithm", "strong"],
}


def table(file):
    with open(file, newline="") as lines:
        names, *rows = csv.reader(lines)
    values = np.array([[float(cell) for cell in row] for row in rows])
    return {name.split(" [")[0]: values[:, column] for column, name in enumerate(names)}


def simulate(program, system, step, *more):
    """Columns at the instants of the grid, and the seconds of the whole program."""
    with tempfile.TemporaryDirectory() as folder:
        out = Path(folder) / "r.csv"
        begin = time.perf_counter()
        done = subprocess.run(
            [program, "simulate", system, "--stop", str(STOP), "--step", repr(step), "--out", out,
             "--every", str(round(GRID / step)), *more,
             "--set", f"{'beam.' if str(system).endswith('.ssp') else ''}excitation={EXCITATION}"], capture_output=True, text=True,
        )
        seconds = time.perf_counter() - begin
        if done.returncode != 0:
            return None, seconds
        return table(out), seconds


def signals(reference):
    """Names in the reference and in the coupled system."""
    names = [name.split(".", 1)[1] for name in reference if name.startswith(MONOLITH)]
    shared = [name for name in names if name.split(":")[0] in ("displacement", "velocity", "acceleration", "force")]
    return {name: f"contact.{name}" if name == "force" else f"beam.{name}" for name in shared}


def errors(found, reference, shared):
    """The root mean square of the difference over the standard deviation of the signal."""
    if found is None:
        return {name: np.inf for name in shared}
    result = {}
    for name, coupled in shared.items():
        expected = reference[f"{MONOLITH}.{name}"]
        if coupled not in found:
            result[name] = np.nan
            continue
        values = np.asarray(found[coupled])[: len(expected)]
        good = len(values) == len(expected) and np.isfinite(values).all()
        result[name] = np.sqrt(np.mean((values - expected) ** 2)) / np.std(expected) if good else np.inf
    return result


def grid(columns, step):
    """Values at the instants of the grid, of columns that begin with the end of the first step."""
    every = round(GRID / step)
    return {name: np.concatenate([[np.nan], np.asarray(values)])[::every][: round(STOP / GRID) + 1] for name, values in columns.items()}


# One process each, started below: libraries of several masters do not share one.
FMPY = """
import json, sys, time
from fmpy.ssp.simulation import simulate_ssp
from fmpy.ssp.ssd import read_ssv
file, step, stop, names = sys.argv[1], float(sys.argv[2]), float(sys.argv[3]), json.loads(sys.argv[4])
begin = time.perf_counter()
start = read_ssv(file, "resources/parameters.ssv")
for parameter in start.parameters:
    if parameter.name == "beam.excitation":
        parameter.value = "%r"
found = simulate_ssp(file, stop_time=stop, step_size=step, parameter_set=start)
seconds = time.perf_counter() - begin
print("DONE", json.dumps([seconds, {name: [float(value) for value in found[name]] for name in names if name in found.dtype.names}]))
""" % EXCITATION
ECOS = """
import json, sys, time
from ecospy import EcosSimulation
file, step, stop, names = sys.argv[1], float(sys.argv[2]), float(sys.argv[3]), json.loads(sys.argv[4])
begin = time.perf_counter()
columns = {name: [] for name in names}
with EcosSimulation(ssp_path=file, step_size=step) as simulation:
    simulation.init()
    simulation.set_real("beam::excitation", %r)
    for _ in range(round(stop / step)):
        simulation.step()
        for name in names:
            columns[name].append(simulation.get_real(name.replace(".", "::", 1)))
    simulation.terminate()
print("DONE", json.dumps([time.perf_counter() - begin, columns]))
""" % EXCITATION
LIBCOSIM = """
import json, sys, time, tempfile, zipfile
from pathlib import Path
from fmpy import read_model_description
from libcosimpy.CosimExecution import CosimExecution
from libcosimpy.CosimObserver import CosimObserver
file, step, stop, names = sys.argv[1], float(sys.argv[2]), float(sys.argv[3]), json.loads(sys.argv[4])
begin = time.perf_counter()
with tempfile.TemporaryDirectory() as folder:
    zipfile.ZipFile(file).extractall(folder)
    execution = CosimExecution.from_ssp_file(ssp_path=folder, step_size=round(step * 1e9))
    observer = CosimObserver.create_last_value()
    execution.add_observer(observer=observer)
    fmus = {"beam": "ModalBeam", "contact": "ValanisContact"}
    columns = {name: [] for name in names}
    of = {}
    for part, fmu in fmus.items():
        known = {v.name: v.valueReference for v in read_model_description(str(next(Path(folder).rglob(fmu + ".fmu")))).modelVariables}
        if part == "beam":
            excitation = known["excitation"]
        of[part] = [(name, known[name.split(".", 1)[1]]) for name in names if name.startswith(part)]
    slaves = {part: execution.slave_index_from_instance_name(part) for part in fmus}
    # It does not take the start values of the package's parameter file over.
    execution.real_initial_value(slaves["beam"], excitation, %r)
    for _ in range(round(stop / step)):
        if not execution.step():
            raise RuntimeError("a step fails")
        for part, list_ in of.items():
            values = observer.last_real_values(slaves[part], [reference for _, reference in list_])
            for (name, _), value in zip(list_, values):
                columns[name].append(value)
print("DONE", json.dumps([time.perf_counter() - begin, columns]))
""" % EXCITATION
MASTERS = {"FMPy": ("fmpy", FMPY), "Ecos": ("ecospy", ECOS), "libcosim": ("libcosimpy", LIBCOSIM)}


def other(script, file, step, names):
    """Columns from the end of the first step on, and seconds, of another master."""
    environment = dict(os.environ, LD_LIBRARY_PATH=str(Path(sys.prefix) / "lib"))
    done = subprocess.run(
        [sys.executable, "-c", script, str(file), repr(step), repr(STOP), json.dumps(names)],
        env=environment, capture_output=True, text=True,
    )
    line = [line for line in done.stdout.splitlines() if line.startswith("DONE ")]
    if done.returncode != 0 or not line:
        print(done.stdout[-2000:], done.stderr[-2000:], file=sys.stderr)
        return None, float("nan")
    seconds, columns = json.loads(line[0][5:])
    return grid(columns, step), seconds


def with_start(found, reference, shared):
    """The first row, which a master that tells the ends of steps does not have, is not compared."""
    if found is not None:
        for name, coupled in shared.items():
            if coupled in found:
                found[coupled][0] = reference[f"{MONOLITH}.{name}"][0]
    return found


def repeated(run):
    """Columns, and the seconds of the fastest of some runs."""
    runs = [run() for _ in range(REPETITIONS)]
    return runs[0][0], min(seconds for _, seconds in runs)


def monolith(program, contact, folder):
    """The run of a beam that has the contact inside."""
    beam = (MODELS / f"{MONOLITH}.toml").read_text()
    law = (MODELS / f"{contact}.toml").read_text().split("[contact]")[1]
    model = Path(folder) / "model.toml"
    model.write_text(beam.split("[contact]")[0] + "[contact]" + law)
    fmu = Path(folder) / f"{MONOLITH}.fmu"
    subprocess.run([program, "export", model, "-o", fmu], check=True, capture_output=True)
    reference, _ = simulate(program, fmu, 1e-6, "--fmu-tolerance", "1e-11")
    return reference


def masters_table(program, ssp, reference, shared):
    pick = [name for name in ("displacement", "velocity", "force", "displacement:x=0.55", "acceleration:x=0.55") if name in shared]
    lines = ["| master | algorithm | H (s) | " + " | ".join(pick) + " | seconds |", "|---|---|---|" + "---|" * (len(pick) + 1)]
    for step in COMPARED:
        rows = [
            ("stickslip", name, *repeated(lambda: simulate(program, ssp, step, *words))) for name, words in ALGORITHMS.items()
        ] + [
            (f"{name} ({package} {version(package)})", "its own", *repeated(lambda: other(script, ssp, step, list(shared.values()))))
            for name, (package, script) in MASTERS.items()
        ]
        for master, algorithm, found, seconds in rows:
            found = with_start(found, reference, shared)
            error = errors(found, reference, shared)
            lines.append(f"| {master} | {algorithm} | {step:.0e} | " + " | ".join(shown(error[name]) for name in pick) + f" | {seconds:.2f} |")
    return lines


def shown(error):
    if np.isnan(error):
        return "not told"
    return f"{error:.1e}" if error < 1e3 else "diverges"


def order(values):
    """Between the two finest steps whose errors are above that of the reference."""
    good = [k for k, value in enumerate(values) if 3e-7 < value < 1e-1][-2:]
    if len(good) < 2:
        return "–"
    (a, b) = good
    return f"{log(values[a] / values[b]) / log(STEPS[a] / STEPS[b]):.2f}"


def convergence(program, ssp, reference, shared):
    """Errors of every algorithm on every signal at every step."""
    found = {}
    for name, words in ALGORITHMS.items():
        runs = [errors(with_start(simulate(program, ssp, step, *words)[0], reference, shared), reference, shared) for step in STEPS]
        found[name] = {signal: [run[signal] for run in runs] for signal in shared}
    return found


def draw(found, shared, file):
    import matplotlib

    matplotlib.use("svg")
    matplotlib.rcParams.update({"svg.hashsalt": "stickslip", "svg.fonttype": "none"})
    from matplotlib import pyplot

    columns = 4
    rows = -(-len(shared) // columns)
    figure, axes = pyplot.subplots(rows, columns, figsize=(14, 3 * rows), sharex=True, sharey=True)
    for axis, signal in zip(axes.flat, shared):
        for name, errors_of in found.items():
            values = [value if value < 10 else np.nan for value in errors_of[signal]]
            axis.loglog(STEPS, values, marker="o", markersize=3, label=name)
        axis.set_title(signal, fontsize=9)
        axis.grid(True, alpha=0.3)
        axis.minorticks_off()
    for axis in axes.flat[len(shared):]:
        axis.axis("off")
    axes.flat[0].legend(fontsize=7)
    figure.supxlabel("communication step H (s)")
    figure.supylabel("rms error over standard deviation")
    figure.tight_layout()
    figure.savefig(file, metadata={"Date": None})


def convergence_section(program, system, contact, made, folder):
    """What each algorithm does on each signal of a system, as text; draws it."""
    ssp = Path(made) / f"{system}.ssp"
    reference = monolith(program, contact, made)
    shared = signals(reference)
    found = convergence(program, ssp, reference, shared)
    draw(found, shared, folder / f"masters-{system}.svg")
    text = [
        "", f"## Every algorithm on every signal of {system}", "", f"![errors over the communication step](masters-{system}.svg)", "",
        f"Error at H = 1e-4 s, and the order between the two finest steps of {', '.join(f'{step:.0e}' for step in STEPS)} s whose "
        "errors are above 3e-7:", "",
        "| signal | " + " | ".join(ALGORITHMS) + " |", "|---|" + "---|" * len(ALGORITHMS),
    ]
    at = STEPS.index(1e-4)
    for signal in shared:
        cells = [f"{shown(found[name][signal][at])}, {order(found[name][signal])}" for name in ALGORITHMS]
        text.append(f"| `{signal}` | " + " | ".join(cells) + " |")
    return text


def main():
    program, folder = str(Path(sys.argv[1]).resolve()), Path(sys.argv[2])
    with tempfile.TemporaryDirectory() as made:
        subprocess.run([program, "fmu", "--out", made], check=True, capture_output=True)
        reference = monolith(program, SYSTEMS[SYSTEM], made)
        compared = masters_table(program, Path(made) / f"{SYSTEM}.ssp", reference, signals(reference))
        sections = [
            line for system, contact in SYSTEMS.items() for line in convergence_section(program, system, contact, made, folder)
        ]
    text = [
        "# Masters on one system", "",
        f"Written by `cargo xtask masters`. `{SYSTEM}.ssp` (beam and contact, each an FMU; the exciter's force is a step of {EXCITATION:.0f} N) over {STOP} s; "
        f"the reference is the same beam with the contact inside, in steps of 1e-6 s with a tolerance of 1e-11. An error is the root mean "
        f"square of the difference every {GRID:.0e} s over the standard deviation of the signal.", "",
        f"Seconds are those from the file to the last value, the least of {REPETITIONS} runs: of the whole program for stickslip, without the start of Python for the "
        "others, which are driven from Python and read every signal after every step. FMPy tells the outputs that are connected alone.", "",
        *compared, *sections, "",
    ]
    (folder / "masters.md").write_text("\n".join(text))


main()
