"""FMU Manipulation Toolbox: its checks. It runs nothing."""

import subprocess
import sys
from pathlib import Path

from case import judge


def remarks(case):
    tool = Path(sys.executable).parent / "fmutool"
    done = subprocess.run([tool, "-input", case.fmu, "-check", "-summary"], capture_output=True, text=True)
    if done.returncode != 0:
        raise RuntimeError(f"code {done.returncode}: {done.stderr or done.stdout}")
    said = [line.split("|", 1)[-1].strip() for line in (done.stdout + done.stderr).splitlines()]
    expected = [
        f"This FMU seems to be compliant with FMI-{case.fmi}.0.",
        f"No semantic error against the FMI-{case.fmi} standard.",
    ]
    missing = [f"does not say: {line}" for line in expected if line not in said]
    return missing + [line for line in said if line.startswith(("WARNING", "ERROR"))]


judge(lambda case: {}, remarks)
