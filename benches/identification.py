#!/usr/bin/env python3
"""Identification side by side: stickslip, PySINDy and SysIdentPy on contacts with a hidden effect.

    python3 benches/identification.py CASES [--kind contact]

CASES is a folder of case-N/ folders, each with model.toml and dataset.toml, and truth.json beside them, as
`cargo xtask hidden-effects` writes them to target/hidden-effects. The script stands alone: it makes its own
environment under target/ with the packages of benches/identification-requirements.txt, runs
`stickslip diagnose` (release build), and gives the other two the very split of the records that stickslip
used: their settings are tried on a grid, fitted to the same records, chosen on the same validation records
by their error in free run, and scored once on the same test records.

What is compared is the error in free run on records that nothing was fitted to or chosen by, normalised by the
force's standard deviation; and what the result says to an engineer.
"""

import argparse
import itertools
import json
import os
import pathlib
import platform
import subprocess
import sys
import time
import tomllib
import venv
import warnings

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parent
TARGET = pathlib.Path(os.environ.get("CARGO_TARGET_DIR", ROOT / "target")).resolve()
ENVIRONMENT = TARGET / "identification"
REQUIREMENTS = HERE / "identification-requirements.txt"
# A free run that leaves the range of the data by this factor has diverged.
DIVERGED = 10.0


def main():
    parser = argparse.ArgumentParser(description=__doc__.splitlines()[0])
    parser.add_argument("cases", type=pathlib.Path, help="folder of case-N folders with truth.json")
    parser.add_argument("--limit", type=int, default=24, help="cases at most (default 24)")
    parser.add_argument("--only", help="cases whose effect contains this text")
    parser.add_argument("--program", type=pathlib.Path, help="this stickslip instead of a release build")
    parser.add_argument("--out", type=pathlib.Path, default=HERE / "identification.md", help="the page written")
    arguments = parser.parse_args()
    if pathlib.Path(sys.prefix).resolve() != ENVIRONMENT.resolve():
        return in_environment()
    warnings.filterwarnings("ignore")
    program = arguments.program or build()
    rows = []
    for case, truth in chosen(arguments):
        row = {"case": case.name, "effect": truth["effect"], "noise": truth["noise"]}
        ours, split = diagnose(program, case)
        row["stickslip"] = ours
        records = read(case)
        for name, method in (("pysindy", sindy), ("sysidentpy", narx)):
            begin = time.perf_counter()
            result = method(records, split)
            row[name] = result | {"seconds": time.perf_counter() - begin}
        rows.append(row)
        print(line(row), flush=True)
    arguments.out.write_text(page(rows, arguments), encoding="utf-8")
    print(f"wrote {arguments.out}")
    return 0


def in_environment():
    """Makes the environment where it is missing or not of these requirements; runs this script in it."""
    python = ENVIRONMENT / ("Scripts/python.exe" if os.name == "nt" else "bin/python")
    installed = ENVIRONMENT / "requirements.txt"
    if not installed.exists() or installed.read_bytes() != REQUIREMENTS.read_bytes():
        print(f"making {ENVIRONMENT}", file=sys.stderr)
        venv.create(ENVIRONMENT, clear=True, with_pip=True)
        pip = [python, "-m", "pip", "install", "--quiet", "--disable-pip-version-check", "-r", REQUIREMENTS]
        subprocess.run(pip, check=True)
        installed.write_bytes(REQUIREMENTS.read_bytes())
    return subprocess.run([python, __file__, *sys.argv[1:]]).returncode


def build():
    subprocess.run(["cargo", "build", "--release", "--quiet", "-p", "stickslip-cli"], cwd=ROOT, check=True)
    return TARGET / "release" / ("stickslip.exe" if os.name == "nt" else "stickslip")


def chosen(arguments):
    truth = json.loads((arguments.cases / "truth.json").read_text())
    cases = []
    for name, told in truth.items():
        kind = told.get("family", told.get("kind"))
        if kind == "contact" and (not arguments.only or arguments.only in told["effect"]):
            cases.append((arguments.cases / name, told))
    # Spread over the list: neighbours in it tend to be alike.
    step = max(1, -(-len(cases) // arguments.limit))
    return cases[::step]


# ---- stickslip


def diagnose(program, case):
    out = TARGET / "identification.json"
    begin = time.perf_counter()
    done = subprocess.run(
        [program, "diagnose", case / "model.toml", case / "dataset.toml", "--json", out],
        stdout=subprocess.DEVNULL,
        stderr=subprocess.PIPE,
        text=True,
    )
    if done.returncode not in (0, 10, 11, 12, 13):
        sys.exit(f"{case}: {done.stderr}")
    seconds = time.perf_counter() - begin
    found = json.loads(out.read_text())
    said = ", ".join(found["effects"]) or " | ".join("/".join(g) for g in found["groups"]) or found["verdict"]
    uses = [entry["use"] if isinstance(entry, dict) else entry for entry in found["split"]]
    split = {use: [i for i, u in enumerate(uses) if u == use] for use in ("fit", "select", "confirm")}
    return {"error": found["error"]["untouched"], "says": said, "seconds": seconds}, split


# ---- what the others get


def read(case):
    """Per record: time, displacement and velocity over their largest values, direction, force over its own."""
    import numpy

    tables = []
    for record in tomllib.loads((case / "dataset.toml").read_text())["record"]:
        file = case / record["file"]
        header = [column.split("[")[0].strip() for column in file.read_text().splitlines()[0].split(",")]
        table = numpy.genfromtxt(file, delimiter=",", skip_header=1)
        tables.append([table[:, header.index(name)] for name in ("time", "displacement", "force", "normal_load")])
    displacement = max(abs(table[1]).max() for table in tables)
    force = max(abs(table[2]).max() for table in tables)
    load = max(abs(table[3]).max() for table in tables)
    speed = max(abs(numpy.gradient(table[1], table[0])).max() for table in tables)
    records = []
    for time_, u, f, n in tables:
        v = numpy.gradient(u, time_)
        records.append(
            {
                "step": time_[1] - time_[0],
                "u": u / displacement,
                "v": v / speed,
                "rate": v / displacement,
                "du": numpy.diff(u, prepend=u[0]) / displacement,
                "sign": numpy.sign(v),
                "n": n / load,
                "f": f / force,
            }
        )
    return records


def error(predicted, measured):
    import numpy

    predicted = numpy.nan_to_num(predicted, nan=DIVERGED, posinf=DIVERGED, neginf=-DIVERGED)
    return float(numpy.sqrt(numpy.mean((predicted.clip(-DIVERGED, DIVERGED) - measured) ** 2)) / measured.std())


def total(errors):
    return float((sum(e * e for e in errors) / len(errors)) ** 0.5)


def best(settings, fit, run, records, split):
    """Fits each setting, chooses by the free run on the validation records, scores the test records."""
    winner = None
    for setting in settings:
        try:
            model = fit(setting, [records[i] for i in split["fit"]])
            chosen_by = total([error(run(model, records[i]), records[i]["f"]) for i in split["select"]])
        except Exception as failure:  # a setting that the package cannot fit is one that is not chosen
            print(f"  {setting}: {type(failure).__name__}", file=sys.stderr)
            continue
        if winner is None or chosen_by < winner[0]:
            winner = (chosen_by, setting, model)
    if winner is None:
        return {"error": float("nan"), "says": "no setting could be fitted"}
    _, setting, model = winner
    scored = total([error(run(model, records[i]), records[i]["f"]) for i in split["confirm"]])
    return {"error": scored, "setting": setting, "says": model["says"]}


# ---- PySINDy: df/du·|u̇| form, so that the state is the force and the controls are motion and load


def sindy(records, split):
    """f' = Θ(f, u, v, direction, load) ξ by sequential thresholding, integrated in free run.

    The rate is divided by the displacement's, so that a rate-independent contact has constant coefficients."""
    import numpy
    import pysindy

    def library(record, f):
        s = record["sign"]
        return numpy.column_stack([f, record["u"], s, record["n"], record["v"]])

    def fit(setting, chosen_records):
        degree, threshold, smooth = setting
        polynomials = pysindy.PolynomialLibrary(degree=degree)
        rows, targets = [], []
        for record in chosen_records:
            f = smoothed(record["f"], smooth)
            moving = abs(record["rate"]) > 0.05 * abs(record["rate"]).max()
            slope = numpy.gradient(f, record["step"])[moving] / record["rate"][moving]
            rows.append(library(record, f)[moving])
            targets.append(slope)
        x, y = numpy.vstack(rows), numpy.concatenate(targets)
        theta = numpy.asarray(polynomials.fit_transform(x))
        scale = numpy.abs(theta).max(axis=0) + 1e-12
        optimizer = pysindy.STLSQ(threshold=threshold * numpy.abs(y).max(), alpha=1e-6)
        optimizer.fit(theta / scale, y[:, None])
        coefficients = optimizer.coef_[0] / scale
        kept = int((coefficients != 0).sum())
        return {"library": polynomials, "coefficients": coefficients, "says": f"{kept} polynomial terms"}

    def run(model, record):
        count = len(record["f"])
        f = numpy.empty(count)
        f[0] = record["f"][0]
        # The terms are those of the library; only the force changes from step to step.
        exponents = model["library"].powers_ if hasattr(model["library"], "powers_") else None
        base = library(record, numpy.zeros(count))
        for k in range(1, count):
            row = base[k].copy()
            row[0] = f[k - 1]
            if exponents is None:
                theta = numpy.asarray(model["library"].transform(row[None, :]))[0]
            else:
                theta = numpy.prod(row**exponents, axis=1)
            f[k] = f[k - 1] + theta @ model["coefficients"] * record["du"][k]
            if not abs(f[k]) < DIVERGED:
                f[k:] = DIVERGED
                break
        return f

    grid = itertools.product((1, 2, 3), (0.003, 0.01, 0.03, 0.1), (1, 7))
    return best(list(grid), fit, run, records, split)


def smoothed(values, width):
    from scipy.signal import savgol_filter

    return values if width == 1 else savgol_filter(values, width, 2)


# ---- SysIdentPy: polynomial NARX by forward regression


def narx(records, split):
    """f(k) from earlier forces, displacements, increments, direction and load; free run from the first samples."""
    import numpy
    from sysidentpy.basis_function import Polynomial
    from sysidentpy.model_structure_selection import FROLS
    from sysidentpy.parameter_estimation import LeastSquares

    def inputs(record):
        increment = 20.0 * record["du"]
        return numpy.column_stack([record["u"], increment, record["sign"], record["n"]])

    def fit(setting, chosen_records):
        degree, lag, terms = setting
        x = numpy.vstack([inputs(record) for record in chosen_records])
        y = numpy.concatenate([record["f"] for record in chosen_records])[:, None]
        model = FROLS(
            order_selection=False,
            n_terms=terms,
            ylag=lag,
            xlag=[list(range(1, lag + 1))] * x.shape[1],
            estimator=LeastSquares(),
            basis_function=Polynomial(degree=degree),
        )
        model.fit(X=x, y=y)
        return {"model": model, "says": f"{terms} regressors"}

    def run(model, record):
        start = record["f"][: model["model"].max_lag, None]
        return numpy.asarray(model["model"].predict(X=inputs(record), y=start)).ravel()[: len(record["f"])]

    grid = [(2, 1, 8), (2, 2, 12), (3, 1, 8), (3, 1, 15), (3, 2, 15), (3, 2, 25)]
    return best(grid, fit, run, records, split)


# ---- results


def line(row):
    parts = [f"{row['case']:>10} {row['effect']:<32} noise {row['noise']:.3f}"]
    parts += [f"{name} {row[name]['error']:.4f} ({row[name]['says']})" for name in ("stickslip", "pysindy", "sysidentpy")]
    return "  ".join(parts)


def page(rows, arguments):
    import numpy

    def middle(name, key):
        return float(numpy.nanmedian([row[name][key] for row in rows]))

    text = [
        "# Identification side by side",
        "",
        "Error in free run on the test records over the force's standard deviation. The same split of the",
        "records for all three; settings of PySINDy (24) and SysIdentPy (6) chosen on the validation records.",
        "`python3 benches/identification.py CASES` writes this page; `cargo xtask hidden-effects --kind contact --generate` makes CASES.",
        "",
        f"{len(rows)} contact cases of `{arguments.cases.name}`; {platform.processor() or platform.machine()},",
        f"{os.cpu_count()} cores, load {os.getloadavg()[0]:.1f} at the end: beside other work the seconds compare with each other alone.",
        "",
        "| case | hidden effect | noise | stickslip | it says | PySINDy | SysIdentPy |",
        "|---|---|---|---|---|---|---|",
    ]
    for row in rows:
        ours, sindy_, narx_ = row["stickslip"], row["pysindy"], row["sysidentpy"]
        text.append(
            f"| {row['case']} | {row['effect']} | {100 * row['noise']:g} % | {shown(ours['error'])} | {ours['says']} "
            f"| {shown(sindy_['error'])} ({sindy_['says']}) | {shown(narx_['error'])} ({narx_['says']}) |"
        )
    text += [
        "",
        "| | stickslip | PySINDy | SysIdentPy |",
        "|---|---|---|---|",
        "| median error | " + " | ".join(shown(middle(n, "error")) for n in ("stickslip", "pysindy", "sysidentpy")) + " |",
        "| median time (s) | " + " | ".join(f"{middle(n, 'seconds'):.1f}" for n in ("stickslip", "pysindy", "sysidentpy")) + " |",
        "| says | the effect, with its parameters in SI and their intervals | terms | terms |",
        "",
    ]
    return "\n".join(text)


def shown(value):
    return "–" if value is None or value != value else f"{value:.4f}"


if __name__ == "__main__":
    sys.exit(main())
