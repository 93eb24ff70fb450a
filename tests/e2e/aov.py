"""Reads the layers of an EXR file with the reference library, and compares them with exported tables: aov.py FILE HITS SAMPLES."""

import json
import sys

try:
    import numpy as np
    import OpenEXR
except ImportError as error:
    print(f"{error}", file=sys.stderr)
    sys.exit(77)

file, hits, samples = sys.argv[1], np.load(sys.argv[2]), np.load(sys.argv[3])
with OpenEXR.File(file, separate_channels=True) as exr:
    header, channels = dict(exr.header()), {name: channel.pixels for name, channel in exr.channels().items()}
height, width = channels["depth.Z"].shape
n = (int(samples["x"].max()) + 1) // width

# Of the upper left sample of each pixel its primary hit.
first = hits[(hits["ray"] == 0) & (hits["x"] % n == 0) & (hits["y"] % n == 0)]
rows, columns = first["y"] // n, first["x"] // n


def plane(values, none):
    all = np.full((height, width), none, values.dtype)
    all[rows, columns] = values
    return all


def same(name, expected):
    assert np.array_equal(channels[name], expected), name


same("depth.Z", plane(first["t"], np.inf))
for axis in "xyz":
    same(f"position.{axis.upper()}", plane(first[f"position_{axis}"], 0))
    same(f"normal.{axis.upper()}", plane(first[f"normal_{axis}"], 0))
same("object.id", plane(first["object"], 0xFFFFFFFF))
same("material.id", plane(first["material"], 0xFFFFFFFF))
lights = sum(name.startswith("shadow.") for name in channels)
assert lights > 0
for light in range(lights):
    same(f"shadow.light{light}", plane(first["shadows"] >> (2 * light) & 3, 0))
for name, column in [("rays.all", "rays"), ("rays.shadow", "shadow_rays"), ("work.node_visits", "node_visits"),
                     ("work.triangle_tests", "triangle_tests"), ("work.pops", "pops"),
                     ("policy.rays", "rays_traced"), ("policy.shadow_rays", "shadow_rays_traced")]:
    sums = np.zeros((height, width), np.uint32)
    np.add.at(sums, (samples["y"] // n, samples["x"] // n), samples[column])
    same(name, sums)
for name, column in zip("RGB", "rgb"):
    means = np.zeros((height, width))
    np.add.at(means, (samples["y"] // n, samples["x"] // n), samples[column] / n**2)
    assert np.allclose(channels[name], means, rtol=1e-5, atol=1e-6), name

json.dump({
    "channels": sorted(channels),
    "comments": header["comments"],
    "rayreel": header["rayreel"],
    "traced_samples": round(float(channels["policy.traced"].sum()) * n**2),
    "traced_rays": int(channels["policy.rays"].sum()),
    "traced_shadow_rays": int(channels["policy.shadow_rays"].sum()),
    "mean_flip": float(channels["flip.value"].mean(dtype=np.float64)),
}, sys.stdout)
