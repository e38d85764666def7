"""How long each command takes to end after SIGTERM, at random moments, and whether what it leaves is whole.

    STICKSLIP=target/release/stickslip python tests/signals/measure.py [RUNS [SEED [COMMAND ...]]]

Each command runs once undisturbed, or for LONGEST seconds, and then RUNS times more, each of which is sent SIGTERM at a random moment of that
time: while it reads, computes and writes. The table says how long it took from the signal to the end; a file that is left must be whole, and
nothing temporary may be left. The exit code is 1 where an end took more than a second or something half-written was left.
"""

import collections
import csv
import json
import math
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time
import zipfile
from pathlib import Path

from cases import CASES, made

# Runs that take longer are signalled within this time (s), and an end is waited for so long.
LONGEST = 20.0
PATIENCE = 30.0
GOAL = 1.0


def start(program, words, folder, temporary):
    environment = {**os.environ, "TMPDIR": str(temporary)}
    return subprocess.Popen([program, *words], cwd=folder, env=environment, stdin=subprocess.DEVNULL,
                            stdout=subprocess.DEVNULL, stderr=subprocess.PIPE)


def is_whole(path):
    """Whether a result is complete, as far as its kind tells."""
    if path.suffix == ".json":
        json.loads(path.read_text())
        return True
    if path.suffix == ".html":
        return path.read_text().rstrip().endswith("</html>")
    if path.suffix == ".csv":
        text = path.read_text()
        return text.endswith("\n") and len({len(row) for row in csv.reader(text.splitlines())}) == 1
    if path.suffix in (".fmu", ".parquet"):
        return path.suffix != ".fmu" or zipfile.ZipFile(path).testzip() is None
    return path.read_text().endswith("\n")


def left_wrong(folder, before, temporary):
    """What was left that is not whole, or should not be there."""
    wrong = [f"temporary {path.name}" for path in temporary.iterdir()]
    for path in sorted(folder.rglob("*")):
        if path in before:
            continue
        if path.name.startswith(".stickslip-"):
            wrong.append(path.name)
        elif path.is_file():
            try:
                whole = is_whole(path)
            except (ValueError, zipfile.BadZipFile):
                whole = False
            wrong += [] if whole else [f"{path.relative_to(folder)} half-written"]
    # A dataset is there with all its files.
    for listed in folder.rglob("dataset.toml"):
        names = [line.split('"')[1] for line in listed.read_text().splitlines() if line.startswith("file = ")]
        wrong += [f"{name} missing" for name in names if listed not in before and not (listed.parent / name.split(":")[0]).exists()]
    return wrong


def emptied(folder, before):
    for path in sorted(folder.rglob("*"), reverse=True):
        if path not in before:
            path.unlink() if path.is_file() else path.rmdir()


def undisturbed(program, words, folder, temporary):
    begin = time.monotonic()
    child = start(program, words, folder, temporary)
    try:
        _, told = child.communicate(timeout=LONGEST)
    except subprocess.TimeoutExpired:
        child.kill()
        child.communicate()
        shutil.rmtree(temporary)
        temporary.mkdir()
        return LONGEST, None
    if child.returncode in (1, 2):
        sys.exit(f"{' '.join(words)}: {told.decode()}")
    return time.monotonic() - begin, child.returncode


def answered(program, words, folder, temporary, wait):
    """Seconds from the signal to the end, and the exit code; `None` where it had ended before."""
    child = start(program, words, folder, temporary)
    try:
        child.communicate(timeout=wait)
        return None, child.returncode
    except subprocess.TimeoutExpired:
        pass
    begin = time.monotonic()
    child.send_signal(signal.SIGTERM)
    try:
        child.communicate(timeout=PATIENCE)
    except subprocess.TimeoutExpired:
        child.kill()
        child.communicate()
        return math.inf, None
    return time.monotonic() - begin, child.returncode


def measured(program, name, folder, words, runs, chance):
    temporary = folder / "temporary"
    temporary.mkdir(exist_ok=True)
    before = set(folder.rglob("*"))
    duration, _ = undisturbed(program, words, folder, temporary)
    emptied(folder, before)
    times, codes, wrong = [], collections.Counter(), []
    while len(times) < runs:
        wait = chance.uniform(0.0, 0.98 * duration)
        seconds, code = answered(program, words, folder, temporary, wait)
        if seconds is not None:
            times.append(seconds)
            codes[code] += 1
            faults = left_wrong(folder, before, temporary)
            if seconds > GOAL or faults:
                print(f"{name}: signal after {wait:.2f} s: {seconds:.2f} s, exit code {code}: {', '.join(faults)}", file=sys.stderr, flush=True)
            wrong += faults
        emptied(folder, before)
    times.sort()
    ran = f"{duration:.1f} s" if duration < LONGEST else f"over {LONGEST:.0f} s"
    ends = ", ".join(f"{count} × {code}" for code, count in sorted(codes.items(), key=str))
    late = sum(seconds > GOAL for seconds in times)
    print(f"| {name} | {ran} | {times[len(times) // 2]:.2f} s | {times[-1]:.2f} s | {late} of {runs} | {ends} | {len(wrong)} |", flush=True)
    return late + len(wrong)


def main():
    program = os.path.abspath(os.environ["STICKSLIP"])
    runs = int(sys.argv[1]) if len(sys.argv) > 1 else 20
    seed = int(sys.argv[2]) if len(sys.argv) > 2 else 0
    wanted = sys.argv[3:] or list(CASES)
    print("| command | undisturbed | median | longest | over 1 s | exit codes | not whole |\n|---|---|---|---|---|---|---|")
    faults = 0
    with tempfile.TemporaryDirectory() as place:
        for name in wanted:
            folder = Path(place) / name.replace(" ", "-").replace(",", "")
            folder.mkdir()
            words = made(program, name, folder)
            faults += measured(program, name, folder, words, runs, random.Random(f"{seed} {name}"))
            shutil.rmtree(folder)
    sys.exit(faults > 0)


if __name__ == "__main__":
    main()
