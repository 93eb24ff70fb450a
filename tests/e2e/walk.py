"""Traverses the rays of a trace again, made from formats/FORMAT.md alone: the box test, the intersection, hits and pops.

usage: walk.py NODES TRIANGLES RAYS STEPS, tables of `rayreel export --format jsonl` of one trace without cut-outs

Every operation is one of single precision, rounded once. Prints how many steps were compared; ends with code 1 where a ray takes other
steps than the trace says, and with 77 where there is no NumPy.
"""

import json
import sys

try:
    import numpy as np
except ImportError as error:
    print(f"no NumPy: {error}")
    sys.exit(77)

np.seterr(all="ignore")
f = np.float32
ZERO, WIDEN, TINY = f(0), f(1) + f(2.0**-19), f(1e-18)
E20, E23 = f(2.0**-20), f(2.0**-23)


def table(path):
    with open(path) as lines:
        return [json.loads(line) for line in lines]


def point(row, name):
    return [f(row[f"{name}_{axis}"]) for axis in "xyz"]


def add(a, b):
    return [a[i] + b[i] for i in range(3)]


def sub(a, b):
    return [a[i] - b[i] for i in range(3)]


def dot(a, b):
    return (a[0] * b[0] + a[1] * b[1]) + a[2] * b[2]


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


def max_abs(v):
    return max(abs(v[0]), abs(v[1]), abs(v[2]))


class Scene:
    def __init__(self, nodes, triangles):
        assert not any(t["cutout"] for t in triangles), "a cut-out passes what only its texture says"
        self.corners = [[point(t, corner) for corner in "abc"] for t in triangles]
        self.glass = [t["optics"] == "dielectric" for t in triangles]
        positions = {t[f"vertex_{c}"]: point(t, c) for t in triangles for c in "abc"}
        ordered = np.sort(np.array(list(positions.values()), dtype=f), axis=0)
        self.middle = list(ordered[len(positions) // 2])
        self.nodes = [[self.child(row, side) for side in ("left", "right")] for row in nodes]

    def child(self, row, side):
        low, high = point(row, f"{side}_min"), point(row, f"{side}_max")
        away = max(max_abs(sub(low, self.middle)), max_abs(sub(high, self.middle))) * E20
        low = [v - (away + abs(v) * E23) for v in low]
        high = [v + (away + abs(v) * E23) for v in high]
        return low, high, (row[f"{side}_kind"], row[side], row[f"{side}_triangles"])

    def intersect(self, o, d, triangle, t_max):
        a, b, c = [sub(corner, o) for corner in self.corners[triangle]]
        e0, e1, e2 = sub(c, a), sub(a, b), sub(b, c)
        u, v, w = dot(cross(e0, add(c, a)), d), dot(cross(e1, add(a, b)), d), dot(cross(e2, add(b, c)), d)
        if not (u >= 0 and v >= 0 and w >= 0) and not (u <= 0 and v <= 0 and w <= 0):
            return None
        n = cross(e1, e0)
        t = dot(a, n) / dot(d, n)
        return t if 0 < t < t_max else None

    def walk(self, ray):
        o, d, shadow = point(ray, "origin"), point(ray, "direction"), ray["kind"] == "shadow"
        t_max = np.finfo(f).max if ray["t_max"] is None else f(ray["t_max"])
        away = max_abs(sub(o, self.middle)) * E20
        pad = [away + abs(v) * E23 for v in o]
        up, down = add(o, pad), sub(o, pad)
        inverse = [f(1) / (v if abs(v) >= TINY else np.copysign(TINY, v)) for v in d]

        def test(low, high):
            a = [(low[i] - up[i]) * inverse[i] for i in range(3)]
            b = [(high[i] - down[i]) * inverse[i] for i in range(3)]
            near = max(*map(min, a, b), ZERO)
            return near, near <= min(*map(max, a, b), t_max) * WIDEN

        steps, stack, at = [], [], ("inner", 0, 0)
        while True:
            kind, number, count = at
            if kind == "inner":
                (*left_box, left), (*right_box, right) = self.nodes[number]
                (left_near, left_met), (right_near, right_met) = test(*left_box), test(*right_box)
                if left_met and right_met:
                    left_first = left_near <= right_near
                    steps.append(("node", number, "left_first" if left_first else "right_first"))
                    stack.append((right, right_near) if left_first else (left, left_near))
                    at = left if left_first else right
                    continue
                if left_met or right_met:
                    steps.append(("node", number, "left" if left_met else "right"))
                    at = left if left_met else right
                    continue
                steps.append(("node", number, "none"))
            for triangle in range(number, number + count) if kind == "leaf" else ():
                t = self.intersect(o, d, triangle, t_max)
                passes = t is not None and shadow and self.glass[triangle]
                steps.append(("triangle", triangle, "miss" if t is None else "pass" if passes else "hit"))
                if t is None or passes:
                    continue
                t_max = t
                if shadow:
                    return steps
            while True:
                if not stack:
                    return steps
                at, near = stack.pop()
                if shadow or near <= t_max * WIDEN:
                    steps.append(("stack", None, "visited"))
                    break
                steps.append(("stack", None, "culled"))


def main(nodes, triangles, rays, steps):
    scene = Scene(table(nodes), table(triangles))
    place = lambda row: (row["frame"], row["tile"], row["x"], row["y"], row["ray"])
    recorded = {}
    for row in table(steps):
        number = None if row["at"] == "stack" else row["number"]
        recorded.setdefault(place(row), []).append((row["at"], number, row["outcome"]))
    rays = table(rays)
    for ray in rays:
        found, said = scene.walk(ray), recorded.pop(place(ray))
        if found != said:
            step = next((i for i, (a, b) in enumerate(zip(found, said)) if a != b), min(len(found), len(said)))
            sys.exit(f"ray {place(ray)}, step {step}: {found[step:step + 1]} is not {said[step:step + 1]}")
    assert not recorded, "steps of rays that are not there"
    print(f"{len(rays)} rays")


main(*sys.argv[1:])
