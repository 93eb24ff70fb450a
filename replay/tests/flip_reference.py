"""Values of NVIDIA's FLIP for the pictures of flip.rs, as that test holds them.

pip install flip-evaluator==1.7 (NVIDIA's own code), then run this: it prints the rows of REFERENCE in flip.rs. The pictures are
made of integers only, by the same formulas as there.
"""

import flip_evaluator
import numpy as np


def noise(seed, brightest):
    """A picture of the linear congruential generator of flip.rs."""
    def make(width, height):
        state, values = seed, []
        for _ in range(width * height * 3):
            state = (state * 1664525 + 1013904223) % 2**32
            values.append((state >> 8) % brightest)
        return np.array(values).reshape(height, width, 3)
    return make


def formula(pixel):
    def make(width, height):
        return np.array([[pixel(x, y) for x in range(width)] for y in range(height)])
    return make


def disc(edge, red):
    inside = lambda x, y: (x - 20) ** 2 + (y - 15) ** 2 < edge
    return formula(lambda x, y: (red, 60, 40) if inside(x, y) else (x * 3 % 256, y * 5 % 256, 128))


def wires(columns):
    return formula(lambda x, y: (25, 20, 30) if x % columns == 0 or y % 7 == 0 else (220, 210, 180))


def waves(shift):
    return formula(lambda x, y: ((x * x + 3 * y * y + shift) // 8 % 256, (x * y + shift) // 4 % 256, (x + y + shift) % 256))


def flat(*colour):
    return formula(lambda x, y: colour)


PAIRS = [
    ("noise", 64, 48, noise(1, 256), noise(2, 256)),
    ("dim_noise", 40, 30, noise(3, 256), noise(3, 250)),
    ("disc", 60, 40, disc(144, 200), disc(121, 190)),
    ("wires", 72, 50, wires(9), wires(18)),
    ("waves", 33, 150, waves(0), waves(40)),
    ("one_code", 30, 30, flat(100, 100, 100), flat(101, 100, 100)),
    ("extremes", 24, 24, flat(0, 255, 0), flat(0, 0, 255)),
    ("tiny", 3, 2, noise(5, 256), noise(6, 256)),
]
DEFAULT = 67.0206432766  # 3840 pi / 180, the tool's default
JOBS = [(pair, DEFAULT) for pair in PAIRS] + [(PAIRS[3], 30.0), (PAIRS[3], 130.0)]

for (name, width, height, reference, test), ppd in JOBS:
    pictures = [np.ascontiguousarray(make(width, height) / 255.0, dtype=np.float32) for make in (reference, test)]
    values, _, _ = flip_evaluator.evaluate(*pictures, "LDR", applyMagma=False, parameters={"ppd": ppd})
    mean = np.mean(values.astype(np.float64))
    probes = [values[y, x, 0] for x, y in ((0, 0), (width // 2, height // 2), (width - 1, height // 3))]
    ppd = "PIXELS_PER_DEGREE" if ppd == DEFAULT else ppd
    print(f'    ("{name}", {ppd}, {mean:.7f}, [{", ".join(f"{v:.7f}" for v in probes)}]),')
