"""A record of a million rows and a model for it, in a folder: python million_rows.py FOLDER"""

import math
import pathlib
import random
import sys

STEP = 1e-4
STIFFNESS = 2e6
LIMIT = 50.0

folder = pathlib.Path(sys.argv[1])
folder.mkdir()
(folder / "model.toml").write_text(
    'schema = "stickslip.model/1"\nkind = "contact"\n[contact]\nlaw = "jenkins"\n'
    f"tangential_stiffness = {STIFFNESS}\nfriction_coefficient = 0.5\nnormal_load = 100.0\n"
)
noise = random.Random(1)
force = before = 0.0
with open(folder / "rows.csv", "w") as file:
    file.write("time [s],displacement [m],force [N]\n")
    for row in range(1_000_000):
        time = STEP * row
        displacement = 5e-5 * math.sin(2 * math.pi * 20 * time) * (0.2 + 0.8 * row / 1e6)
        force = max(-LIMIT, min(LIMIT, force + STIFFNESS * (displacement - before)))
        before = displacement
        file.write(f"{time:.4f},{displacement:.9e},{force + noise.gauss(0, 0.3):.6f}\n")
