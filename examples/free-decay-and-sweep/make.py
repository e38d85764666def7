"""Simulates the measurements of this folder: a mass on a spring with a friction contact and, as nobody told the model, drag.

    python make.py

Classical Runge-Kutta steps with the slider moved between them, and noise: nothing of stickslip. No packages are needed.
"""

import math
import random

MASS, STIFFNESS, DAMPING = 2.0, 2e4, 2.0  # kg, N/m, N s/m
CONTACT, LIMIT = 4e3, 4.0  # N/m, N
DRAG = 4.0  # N s^2/m^2: what model.toml lacks
NOISE = 0.005


def march(state, force, step, count):
    """`count` steps from (displacement, velocity, slider); yields the acceleration before each."""
    x, v, slider = state

    def acceleration(x, v, time):
        friction = min(max(CONTACT * (x - slider), -LIMIT), LIMIT)
        return (force(time) - STIFFNESS * x - DAMPING * v - DRAG * v * abs(v) - friction) / MASS

    for k in range(count):
        time = k * step
        a1 = acceleration(x, v, time)
        yield a1
        x2, v2 = x + 0.5 * step * v, v + 0.5 * step * a1
        a2 = acceleration(x2, v2, time + 0.5 * step)
        x3, v3 = x + 0.5 * step * v2, v + 0.5 * step * a2
        a3 = acceleration(x3, v3, time + 0.5 * step)
        x4, v4 = x + step * v3, v + step * a3
        a4 = acceleration(x4, v4, time + step)
        x += step / 6.0 * (v + 2.0 * v2 + 2.0 * v3 + v4)
        v += step / 6.0 * (a1 + 2.0 * a2 + 2.0 * a3 + a4)
        slider = min(max(slider, x - LIMIT / CONTACT), x + LIMIT / CONTACT)


def sweep(amplitude, frequencies):
    """Rows of the steady response: frequency, force, amplitude, phase."""
    for frequency in frequencies:
        samples, periods = 200, 80
        step = 1.0 / (samples * frequency)
        speed = 2.0 * math.pi * frequency
        motion = list(march((0.0, 0.0, 0.0), lambda t: amplitude * math.cos(speed * t), step, samples * periods))
        last = motion[-4 * samples :]
        cosine = sum(a * math.cos(speed * k * step) for k, a in enumerate(last)) / (2 * samples)
        sine = sum(a * math.sin(speed * k * step) for k, a in enumerate(last)) / (2 * samples)
        yield frequency, amplitude, math.hypot(cosine, sine), math.degrees(math.atan2(-sine, cosine))


def main():
    random.seed(1)
    frequencies = [14.5, 15.2, 15.6, 15.9, 16.2, 16.6, 17.2, 18.0]
    for number, force in enumerate([4.0, 8.0, 15.0, 25.0], 1):
        with open(f"sweeps/sweep-{number}.csv", "w", encoding="utf-8") as file:
            file.write("frequency [Hz],excitation:m1 [N],acceleration:m1 [m/s^2],phase:m1 [deg]\n")
            for frequency, level, size, phase in sweep(force, frequencies):
                size *= 1.0 + random.gauss(0.0, NOISE)
                phase += math.degrees(random.gauss(0.0, NOISE))
                file.write(f"{frequency},{level},{size:.5g},{phase:.2f}\n")
    rate, finer = 200, 20
    for number, start in enumerate([0.02, 0.015, 0.01], 1):
        with open(f"decays/decay-{number}.csv", "w", encoding="utf-8") as file:
            file.write("time [s],acceleration:m1 [m/s^2]\n")
            slider = start - LIMIT / CONTACT
            motion = list(march((start, 0.0, slider), lambda _: 0.0, 1.0 / (rate * finer), 6 * rate * finer))
            for k, a in enumerate(motion[::finer]):
                file.write(f"{k / rate:g},{a + random.gauss(0.0, 0.1):.5g}\n")


if __name__ == "__main__":
    main()
