"""Eight records of 100 000 samples of a contact with a spring beside it, and a model without, in a folder:
python long_records.py FOLDER"""

import math
import pathlib
import random
import sys

RECORDS, SAMPLES, STEP = 8, 100_000, 1e-4
STIFFNESS, LIMIT, BESIDE = 2e6, 50.0, 2e5

folder = pathlib.Path(sys.argv[1])
(folder / "data").mkdir(parents=True)
(folder / "model.toml").write_text(
    'schema = "stickslip.model/1"\nkind = "contact"\n[contact]\nlaw = "jenkins"\n'
    "tangential_stiffness = 1.9e6\nfriction_coefficient = 0.52\nnormal_load = 100.0\n"
)
dataset = 'schema = "stickslip.dataset/1"\n'
noise = random.Random(1)
for record in range(RECORDS):
    amplitude = 2e-5 * (1 + record)
    force = before = 0.0
    with open(folder / "data" / f"r{record}.csv", "w") as file:
        file.write("time [s],displacement [m],force [N]\n")
        for row in range(SAMPLES):
            time = STEP * row
            displacement = amplitude * math.sin(2 * math.pi * 20 * time) * (0.2 + 0.8 * row / SAMPLES)
            force = max(-LIMIT, min(LIMIT, force + STIFFNESS * (displacement - before)))
            before = displacement
            measured = force + BESIDE * displacement + noise.gauss(0, 0.5)
            file.write(f"{time:.4f},{displacement:.9e},{measured:.6f}\n")
    dataset += f'[[record]]\nfile = "r{record}.csv"\nregime = "from-rest"\n'
(folder / "data" / "dataset.toml").write_text(dataset)
