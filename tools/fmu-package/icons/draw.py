"""Draws the icons of FMUs, each as SVG and as PNG of the same shapes. Needs Pillow: python3 tools/fmu-package/icons/draw.py

A drawing is a list of shapes on a square of 200 by 200: ("line", points, colour, width) and ("area", points, colour).
"""

import math
from pathlib import Path

from PIL import Image, ImageDraw

SIDE, FINE = 200, 4
INK, BLUE, RED, GREEN, PAPER = "#1f2933", "#2166ac", "#b2182b", "#1b7837", "#ffffff"


def box(left, top, right, bottom, colour):
    return ("area", [(left, top), (right, top), (right, bottom), (left, bottom)], colour)


def frame():
    return [box(0, 0, 200, 200, INK), box(4, 4, 196, 196, PAPER)]


def hatched(points, dx, dy):
    """Short strokes from points, as the ground has them."""
    return [("line", [(x, y), (x + dx, y + dy)], INK, 3) for x, y in points]


def loop():
    """A hysteresis loop with slip that sets in gradually, Masing's branches of 1 - exp(-x)."""
    branch = [(-1 + 2 * k / 24, (1 - math.exp(-2.2 * k / 12)) / (1 - math.exp(-4.4)) * 2 - 1) for k in range(25)]
    points = branch + [(-x, -y) for x, y in branch[1:]]
    return [(100 + 74 * x, 100 - 66 * y) for x, y in points]


def spring(left, right, y, turns=4, height=10):
    step = (right - left) / (2 * turns + 2)
    zigzag = [(left + step * (k + 1.5), y + (height if k % 2 else -height)) for k in range(2 * turns)]
    return ("line", [(left, y), (left + step, y), *zigzag, (right - step, y), (right, y)], INK, 4)


CONTACT = frame() + [
    ("line", [(18, 100), (182, 100)], INK, 2),
    ("line", [(100, 18), (100, 182)], INK, 2),
    ("line", loop(), BLUE, 6),
]
BEAM = frame() + [
    ("line", [(26, 45), (26, 125)], INK, 5),
    *hatched([(26, 55 + 17 * k) for k in range(5)], -12, 10),
    box(26, 77, 168, 91, BLUE),
    box(136, 92, 176, 122, RED),
    ("line", [(120, 123), (192, 123)], INK, 4),
    *hatched([(134 + 15 * k, 124) for k in range(4)], -10, 12),
    ("line", [(80, 172), (80, 106)], GREEN, 5),
    ("area", [(80, 94), (70, 114), (90, 114)], GREEN),
]
OSCILLATOR = frame() + [
    ("line", [(20, 60), (20, 140)], INK, 5),
    *hatched([(20, 70 + 17 * k) for k in range(5)], -11, 10),
    spring(20, 72, 96, 3),
    box(72, 72, 108, 124, BLUE),
    spring(108, 146, 96, 2),
    box(146, 72, 182, 124, BLUE),
    ("line", [(60, 126), (192, 126)], INK, 4),
    *hatched([(76 + 17 * k, 127) for k in range(7)], -10, 12),
]
FLANGE = [box(0, 0, 200, 200, INK), box(20, 20, 180, 180, GREEN)]


def svg(shapes):
    drawn = [f'<svg xmlns="http://www.w3.org/2000/svg" viewBox="0 0 {SIDE} {SIDE}">']
    for kind, *rest in shapes:
        points = " ".join(f"{x:.4g},{y:.4g}" for x, y in rest[0])
        if kind == "area":
            drawn.append(f'<polygon points="{points}" fill="{rest[1]}"/>')
        else:
            drawn.append(
                f'<polyline points="{points}" fill="none" stroke="{rest[1]}" stroke-width="{rest[2]}" '
                'stroke-linejoin="round" stroke-linecap="round"/>'
            )
    return "\n".join([*drawn, "</svg>", ""])


def png(shapes, side):
    scale = side * FINE / SIDE
    image = Image.new("RGB", (side * FINE, side * FINE), PAPER)
    pen = ImageDraw.Draw(image)
    for kind, *rest in shapes:
        points = [(x * scale, y * scale) for x, y in rest[0]]
        if kind == "area":
            pen.polygon(points, fill=rest[1])
        else:
            pen.line(points, fill=rest[1], width=round(rest[2] * scale), joint="curve")
    return image.resize((side, side), Image.Resampling.LANCZOS).quantize(32)


for name, shapes, side in [
    ("contact", CONTACT, 128), ("beam", BEAM, 128), ("oscillator", OSCILLATOR, 128), ("flange", FLANGE, 32),
]:
    folder = Path(__file__).parent
    (folder / f"{name}.svg").write_text(svg(shapes))
    png(shapes, side).save(folder / f"{name}.png", optimize=True)
