#!/usr/bin/env python3
"""A reader of Rayreel traces by the text of FORMAT.md, chapter by chapter: the executable check of that text.

    format_reader.py FILE            list what the file holds: per tile and column its codec, length and CRC-32
    format_reader.py FILE --digest   print what `rayreel digest FILE` prints

Standard library only, but for zstd before Python 3.14: `pip install zstandard`; without it the exit code is 77. It is
slow, because it is plain: each part follows the chapter of FORMAT.md that its comment names.
"""

import math
import struct
import sys
from ctypes import c_float
from zlib import crc32

try:
    from compression import zstd  # Python 3.14
except ImportError:
    try:
        import zstandard as zstd
    except ImportError:
        print("python3 has no zstd: pip install zstandard", file=sys.stderr)
        sys.exit(77)

NONE = 0xFFFFFFFF


class Bad(Exception):
    """The file is not what FORMAT.md says."""


def check(condition, what):
    if not condition:
        raise Bad(what)


def unzstd(data, raw_length):
    raw = zstd.ZstdDecompressor().decompress(data, raw_length)
    check(len(raw) == raw_length, "length of a zstd frame")
    return raw


# --- The file ---------------------------------------------------------------------------------------------------------


class File:
    """Header, trailer, index; chunks by kind, frame and tile."""

    def __init__(self, data):
        self.data = data
        check(data[:8] == b"\x89RRT\r\n\x1a\n", "no trace")
        major, _minor, header_length = struct.unpack_from("<HHI", data, 8)
        check(struct.unpack_from("<I", data, 28)[0] == crc32(data[:28]), "CRC of the file header")
        check(major == 1, "major version %d" % major)
        trailer = data[-32:]
        index_at, index_length, count, trailer_crc = struct.unpack("<QQQI", trailer[:28])
        check(trailer[28:] == b"RRTE", "the file was not finished")
        check(trailer_crc == crc32(trailer[:24]), "CRC of the trailer")
        check(index_at + index_length == len(data) - 32, "place of the index")
        check(count <= (index_at - header_length) // 48, "number of chunks")
        self.chunks = {}
        index = self.chunk(index_at, (b"INDX", NONE, NONE))
        chunks, columns = struct.unpack_from("<QQ", index)
        check(chunks == count and len(index) == 16 + 48 * chunks + 32 * columns, "length of the index")
        expected = header_length
        for i in range(chunks):
            entry = struct.unpack_from("<4sIIIQQQII", index, 16 + 48 * i)
            kind, frame, tile, _encoding, offset, packed, _raw, _crc, directory = entry
            check(offset == expected, "offset of a chunk")
            check((directory != 0) == (kind == b"TILE"), "length of a directory")
            expected = offset + 48 + packed
            check((kind, frame, tile) not in self.chunks, "a chunk is there twice")
            self.chunks[kind, frame, tile] = offset
        check(expected == index_at, "end of the chunks")

    def chunk(self, at, wanted):
        """The payload of the chunk at an offset, decoded."""
        header = self.data[at : at + 48]
        sync, kind, frame, tile, encoding, _zero, raw, packed, payload_crc, header_crc = struct.unpack(
            "<4s4sIIIIQQII", header
        )
        check(sync == b"\xf5RRC" and header_crc == crc32(header[:44]), "a chunk header")
        check((kind, frame, tile) == wanted, "the index names another chunk")
        payload = self.data[at + 48 : at + 48 + packed]
        check(len(payload) == packed and payload_crc == crc32(payload), "CRC of a payload")
        check(encoding in (0, 1), "encoding of a chunk")
        return unzstd(payload, raw) if encoding == 1 else payload

    def get(self, kind, frame=NONE, tile=NONE):
        at = self.chunks.get((kind, frame, tile))
        return None if at is None else self.chunk(at, (kind, frame, tile))


def tile_columns(payload):
    """Chapter "TILE payload": by id the codec, raw length and bytes."""
    n = payload[0]
    end = 8 + 24 * n
    check(struct.unpack_from("<I", payload, end - 4)[0] == crc32(payload[: end - 4]), "CRC of a directory")
    columns, at = {}, end
    for i in range(n):
        ident, codec, _reserved, crc, packed, raw = struct.unpack_from("<BBHIQQ", payload, 4 + 24 * i)
        data = payload[at : at + packed]
        check(len(data) == packed and crc32(data) == crc, "CRC of a column")
        check(not columns or ident > max(columns), "order of the columns")
        columns[ident] = (codec, raw, data)
        at += packed
    check(at == len(payload), "end of the columns")
    return columns


# --- Types of META, FRAM and the BVH tables -----------------------------------------------------------------------------


class Fields:
    def __init__(self, data):
        self.data, self.at = data, 0

    def take(self, count):
        part = self.data[self.at : self.at + count]
        check(len(part) == count, "fields are cut short")
        self.at += count
        return part

    def u32(self):
        return int.from_bytes(self.take(4), "little")

    def u64(self):
        return int.from_bytes(self.take(8), "little")

    def f32(self):
        return struct.unpack("<f", self.take(4))[0]

    def bool(self):
        byte = self.take(1)[0]
        check(byte < 2, "a bool")
        return byte == 1

    def string(self):
        return self.take(self.u64()).decode("utf-8")

    def vec(self, element):
        return [element() for _ in range(self.u64())]

    def vec3(self):
        return (self.f32(), self.f32(), self.f32())

    def end(self):
        check(self.at == len(self.data), "bytes left over")


class Meta:
    def __init__(self, payload):
        f = Fields(payload)
        self.tool = f.string()
        # For the digest: the same payload with an empty string as tool.
        self.untooled = bytes(8) + payload[f.at :]
        self.scene = f.string()
        self.scene_hash = f.take(32)
        self.width, self.height, self.samples, self.tile = f.u32(), f.u32(), f.u32(), f.u32()
        self.first_frame, self.frames, self.max_depth = f.u32(), f.u32(), f.u32()
        self.min_weight = f.f32()
        self.lights = f.vec(lambda: (f.u32(), f.vec3(), f.vec3()))
        f.end()
        check(all(light[0] < 2 for light in self.lights) and len(self.lights) <= 16, "lights")
        check(self.max_depth <= 14 and 1 <= self.tile <= 1024 and 1 <= self.samples <= 8, "metadata")
        self.grid = (self.width * self.samples, self.height * self.samples)
        self.tile_columns = -(-self.grid[0] // self.tile)
        self.tiles = self.tile_columns * -(-self.grid[1] // self.tile)

    def rect(self, i):
        x0, y0 = (i % self.tile_columns) * self.tile, (i // self.tile_columns) * self.tile
        return x0, y0, min(self.tile, self.grid[0] - x0), min(self.tile, self.grid[1] - y0)


# --- BVH ----------------------------------------------------------------------------------------------------------------

OPAQUE, MIRROR, FRESNEL_MIRROR, DIELECTRIC = range(4)


class Material:
    def __init__(self, f):
        self.name, self.optics, self.ior = f.string(), f.u32(), f.f32()
        self.specular, self.transmission, self.cutout = f.vec3(), f.vec3(), f.bool()
        check(self.optics < 4, "optics")


class Bvh:
    def __init__(self, payload):
        f = Fields(payload)
        n, t, v, b = f.u32(), f.u32(), f.u32(), f.u32()
        check(len(payload) == 16 + b + 2 * n + 16 * t + 20 * v, "length of the BVH")
        tables = Fields(f.take(b))
        self.objects = tables.vec(tables.string)
        self.materials = tables.vec(lambda: Material(tables))
        surfaces = tables.vec(lambda: (tables.u32(), tables.u32()))
        tables.end()
        shape = f.take(2 * n)

        def planes(count):
            parts = [f.take(count) for _ in range(4)]
            return [a | b << 8 | c << 16 | d << 24 for a, b, c, d in zip(*parts)]

        def sums(count):
            total, out = 0, []
            for d in planes(count):
                total = (total + d) & NONE
                out.append(total)
            return out

        # Per triangle (object, material).
        self.surfaces = [surfaces[i] for i in planes(t)]
        following, corners = 0, []
        for code in planes(3 * t):
            corners.append((following - code) & NONE)
            following += code == 0
        self.triangles = list(zip(corners[0::3], corners[1::3], corners[2::3]))
        xyz = [[struct.unpack("<f", struct.pack("<I", bits))[0] for bits in sums(v)] for _ in range(3)]
        self.positions = list(zip(*xyz))
        self.normals = list(zip(sums(v), sums(v)))
        f.end()
        check(all(code < 1 << 16 for normal in self.normals for code in normal), "a normal has more than 16 bits")
        check(all(c < v for c in corners), "a vertex is not there")
        check(all(math.isfinite(c) for p in self.positions for c in p), "a vertex is not finite")
        for o, m in surfaces:
            check(o < len(self.objects) and m < len(self.materials), "a surface is not there")

        # Children: ("node", index) or ("leaf", first triangle, count).
        self.children = [[None, None] for _ in range(n)]
        self.next_node, self.next_triangle = 1, 0

        def link(node, depth):
            check(depth <= 128, "depth of the tree")
            for side in (0, 1):
                code = shape[2 * node + side]
                if code == 0:
                    child = self.next_node
                    check(child < n, "a node is not there")
                    self.next_node += 1
                    self.children[node][side] = ("node", child)
                    link(child, depth + 1)
                else:
                    check(code <= 5, "size of a leaf")
                    self.children[node][side] = ("leaf", self.next_triangle, code - 1)
                    self.next_triangle += code - 1

        check(n > 0, "no nodes")
        link(0, 1)
        check(self.next_node == n and self.next_triangle == t, "the tree does not reach all")

    def corners(self, triangle):
        return [self.positions[v] for v in self.triangles[triangle]]

    def material(self, triangle):
        return self.materials[self.surfaces[triangle][1]]

    def may_pass(self, triangle, shadow):
        material = self.material(triangle)
        return material.cutout or (shadow and material.optics == DIELECTRIC)


# --- Arithmetic: each operation in f64, rounded to f32 --------------------------------------------------------------------


def r(x):
    return c_float(x).value


def divide(a, b):
    if b != 0:
        return r(a / b)
    if a == 0 or a != a or b != b:
        return math.nan
    return math.copysign(math.inf, a) * math.copysign(1.0, b)


def root(x):
    return r(math.sqrt(x))


def add(a, b):
    return (r(a[0] + b[0]), r(a[1] + b[1]), r(a[2] + b[2]))


def sub(a, b):
    return (r(a[0] - b[0]), r(a[1] - b[1]), r(a[2] - b[2]))


def neg(a):
    return (-a[0], -a[1], -a[2])


def scale(a, s):
    return (r(a[0] * s), r(a[1] * s), r(a[2] * s))


def dot(a, b):
    return r(r(r(a[0] * b[0]) + r(a[1] * b[1])) + r(a[2] * b[2]))


def cross(a, b):
    return (
        r(r(a[1] * b[2]) - r(a[2] * b[1])),
        r(r(a[2] * b[0]) - r(a[0] * b[2])),
        r(r(a[0] * b[1]) - r(a[1] * b[0])),
    )


def normalized(a):
    length = root(dot(a, a))
    return (divide(a[0], length), divide(a[1], length), divide(a[2], length))


def larger(p, q):
    return p if p > q else q


def max_abs(a):
    return larger(larger(abs(a[0]), abs(a[1])), abs(a[2]))


def fold(x, y):
    def sign(v):
        return -1.0 if v < 0 else 1.0

    return r(r(1 - abs(y)) * sign(x)), r(r(1 - abs(x)) * sign(y))


def oct_decode(code):
    x = r(r(r(code[0] / 65534) * 2) - 1)
    y = r(r(r(code[1] / 65534) * 2) - 1)
    z = r(r(1 - abs(x)) - abs(y))
    if z < 0:
        x, y = fold(x, y)
    return normalized((x, y, z))


def oct_encode(n):
    total = r(r(abs(n[0]) + abs(n[1])) + abs(n[2]))
    if not 0 < total < math.inf:
        n, total = (0.0, 0.0, 1.0), 1.0
    x, y = divide(n[0], total), divide(n[1], total)
    if n[2] < 0:
        x, y = fold(x, y)

    def quantise(q):
        return int(r(r(r(r(q * 0.5) + 0.5) * 65534) + 0.5))

    return quantise(x), quantise(y)


TINY = struct.unpack("<f", bytes.fromhex("bd378635"))[0]


def shading_normal(bvh, triangle, u, v):
    na, nb, nc = (bvh.normals[i] for i in bvh.triangles[triangle])
    if na == nb == nc:
        return na
    n = scale(oct_decode(na), r(r(1 - u) - v))
    n = add(add(n, scale(oct_decode(nb), u)), scale(oct_decode(nc), v))
    if dot(n, n) > TINY:
        return oct_encode(n)
    a, b, c = bvh.corners(triangle)
    return oct_encode(cross(sub(b, a), sub(c, a)))


def half(x):
    return struct.unpack("<H", struct.pack("<e", min(x, 65504.0)))[0] if x > 0 else 0


def halves(v):
    return tuple(half(x) for x in v)


# --- Rays: (origin, direction) --------------------------------------------------------------------------------------------


def primary(camera, x, y):
    eye, corner, right, down = camera
    d = add(add(corner, scale(right, r(x + 0.5))), scale(down, r(y + 0.5)))
    return eye, normalized(d)


def intersect(ray, corners):
    o, d = ray
    a, b, c = (sub(corner, o) for corner in corners)
    e0, e1, e2 = sub(c, a), sub(a, b), sub(b, c)
    u = dot(cross(e0, add(c, a)), d)
    v = dot(cross(e1, add(a, b)), d)
    w = dot(cross(e2, add(b, c)), d)
    if not (u >= 0 and v >= 0 and w >= 0) and not (u <= 0 and v <= 0 and w <= 0):
        return None
    n = cross(e1, e0)
    t = divide(dot(a, n), dot(d, n))
    if not (0 < t < math.inf):
        return None
    total = r(r(u + v) + w)
    return t, divide(u, total), divide(v, total)


class Surface:
    def __init__(self, ray, t, corners, normal):
        o, d = ray
        a, b, c = corners
        self.d = d
        self.point = add(o, scale(d, t))
        self.face = normalized(cross(sub(b, a), sub(c, a)))
        self.normal = oct_decode(normal)
        self.front = dot(self.face, d) < 0
        if not self.front:
            self.face, self.normal = neg(self.face), neg(self.normal)
        self.cosine = -dot(self.normal, d)
        if self.cosine <= 0:
            self.normal, self.cosine = self.face, -dot(self.face, d)
        self.offset = r(larger(max_abs(self.point), t) * 2.0**-17)

    def reflection(self):
        def mirror(n):
            return sub(self.d, scale(n, r(2 * dot(self.d, n))))

        out = mirror(self.normal)
        if dot(out, self.face) <= 0:
            out = mirror(self.face)
        return add(self.point, scale(self.face, self.offset)), normalized(out)

    def snell(self, c, ior):
        eta = divide(1.0, ior) if self.front else ior
        k = r(1 - r(r(eta * eta) * r(1 - r(c * c))))
        return (eta, root(k)) if k > 0 else None

    def refraction(self, ior):
        def bend(n, c):
            snell = self.snell(c, ior)
            if snell is None:
                return None
            eta, far = snell
            return add(scale(self.d, eta), scale(n, r(r(eta * c) - far)))

        out = bend(self.normal, self.cosine)
        if out is not None and dot(out, self.face) >= 0:
            out = bend(self.face, -dot(self.face, self.d))
        if out is None:
            return None
        return sub(self.point, scale(self.face, self.offset)), normalized(out)

    def weights(self, material):
        """Weights of reflection and refraction; 0, 0, 0 where there is none."""
        none = (0, 0, 0)
        if material.optics == OPAQUE:
            return none, none
        if material.optics == MIRROR:
            return halves(material.specular), none
        if material.optics == FRESNEL_MIRROR:
            m = r(1 - self.cosine)
            m2 = r(m * m)
            m5 = r(r(m2 * m2) * m)
            return halves([r(f0 + r(r(1 - f0) * m5)) for f0 in material.specular]), none
        snell = self.snell(self.cosine, material.ior)
        if snell is None or self.refraction(material.ior) is None:
            return halves(material.specular), none
        eta, far = snell
        cosine = self.cosine
        s = divide(r(r(eta * cosine) - far), r(r(eta * cosine) + far))
        p = divide(r(cosine - r(eta * far)), r(cosine + r(eta * far)))
        f = r(r(r(s * s) + r(p * p)) * 0.5)
        return halves(scale(material.specular, f)), halves(scale(material.transmission, r(1 - f)))


# --- Range coder and models -------------------------------------------------------------------------------------------------


def bits(count, q=32768, n=0):
    """Models of bits: p above, n in the lowest 8 bits."""
    return [q << 14 | n] * count


class Decoder:
    def __init__(self, data):
        self.data, self.at = data, 0
        self.code, self.range = 0, (1 << 48) - 1
        for _ in range(3):
            self.code = self.code << 16 | self.word()

    def word(self):
        two = self.data[self.at : self.at + 2]
        self.at += 2
        return int.from_bytes(two, "big") << 8 * (2 - len(two))

    def narrow(self, bound):
        if self.code < bound:
            self.range, result = bound, 1
        else:
            self.code -= bound
            self.range -= bound
            result = 0
        if self.range < 1 << 32:
            self.range <<= 16
            self.code = self.code << 16 | self.word()
        return result

    def bit(self, models, i):
        p, n = models[i] >> 8, models[i] & 255
        b = self.narrow((self.range >> 16) * min(max(p >> 6, 24), 65512))
        rate = 131072 // (2 * n + 3)
        p += (((1 << 22) - 1 if b else 0) - p) * rate >> 16
        models[i] = p << 8 | min(n + 1, 254)
        return b

    def raw(self, n):
        value = 0
        for _ in range(n):
            value = 2 * value + self.narrow(self.range >> 1)
        return value

    def symbol(self, models, k):
        node = 1
        for _ in range(k):
            node = 2 * node + self.bit(models, node)
        return node - (1 << k)

    def number(self, models):
        length = 0
        while length < 32 and self.bit(models.length, length):
            length += 1
        if length < 2:
            return length
        upper = models.upper[length]
        first = self.bit(upper, 1)
        value = 2 + first
        if length > 2:
            value = 2 * value + self.bit(upper, 2 + first)
        if length > 3:
            value = value << (length - 3) | self.raw(length - 3)
        return value


class Number:
    def __init__(self):
        self.length = bits(32)
        self.upper = [bits(4) for _ in range(33)]


def symbols(count, k):
    return [bits(1 << k) for _ in range(count)]


# --- A tile -------------------------------------------------------------------------------------------------------------------


class Node:
    def __init__(self, sample, cls):
        self.sample, self.cls = sample, cls
        self.hit, self.children, self.shadows = 0, 0, 0
        self.parent = None
        self.triangle, self.t, self.normal = None, None, None
        self.local, self.size, self.weights = None, 0, [None, None]
        self.ray, self.surface = None, None

    def casts(self):
        return [light for light in range(16) if self.shadows >> 2 * light & 3]


class Tile:
    def __init__(self, meta, bvh, camera, index):
        self.meta, self.bvh, self.camera = meta, bvh, camera
        self.x0, self.y0, self.w, self.h = meta.rect(index)
        self.nodes = []

    def around(self, sample, done):
        """W, N, NW, NE of a sample: what `done` has for them, else None."""
        x, y = sample % self.w, sample // self.w
        left, right = x > 0, x + 1 < self.w
        up = y > 0
        return (
            done.get(sample - 1) if left else None,
            done.get(sample - self.w) if up else None,
            done.get(sample - self.w - 1) if up and left else None,
            done.get(sample - self.w + 1) if up and right else None,
        )

    def classes(self):
        """By class, ascending, the nodes by sample."""
        found = {}
        for node in self.nodes:
            found.setdefault(node.cls, []).append(node)
        return sorted(found.items())

    # Canonical column bytes.

    def tree_bytes(self):
        out = bytearray()
        for node in self.nodes:
            out.append(node.hit | node.children << 1)
            if node.hit:
                out += struct.pack("<I", node.shadows)
        return bytes(out)

    def read_tree(self, data):
        f = Fields(data)
        for sample in range(self.w * self.h):
            stack = [(1, None)]
            while stack:
                cls, parent = stack.pop()
                node = Node(sample, cls)
                node.parent = parent
                flags = f.take(1)[0]
                node.hit, node.children = flags & 1, flags >> 1
                if node.hit:
                    node.shadows = f.u32()
                check(flags < 8 and (node.hit or not node.children), "flags of a node")
                check(not node.children or cls.bit_length() - 1 < self.meta.max_depth, "children at max depth")
                check(node.shadows >> 2 * len(self.meta.lights) == 0, "shadows of lights that are not there")
                self.nodes.append(node)
                if node.children & 2:
                    stack.append((2 * cls + 1, node))
                if node.children & 1:
                    stack.append((2 * cls, node))
        f.end()

    def hits_bytes(self):
        hits = [n for n in self.nodes if n.hit]
        return b"".join(struct.pack("<IIHH", n.triangle, n.t, *n.normal) for n in hits)

    def read_hits(self, data):
        f = Fields(data)
        for node in self.nodes:
            if node.hit:
                node.triangle, node.t, normal = f.u32(), f.u32(), f.u32()
                node.normal = (normal & 0xFFFF, normal >> 16)
                check(node.triangle < len(self.bvh.triangles), "a triangle is not there")
        f.end()

    def radiance_bytes(self):
        out = []
        for node in self.nodes:
            out.append(struct.pack("<3H", *node.local))
            for child in (0, 1):
                if node.children >> child & 1:
                    out.append(struct.pack("<3H", *node.weights[child]))
        return b"".join(out)

    def read_radiance(self, data):
        f = Fields(data)
        for node in self.nodes:
            node.local = struct.unpack("<3H", f.take(6))
            for child in (0, 1):
                if node.children >> child & 1:
                    node.weights[child] = struct.unpack("<3H", f.take(6))
        f.end()

    def ray_count(self):
        return sum(1 + len(node.casts()) for node in self.nodes)

    def paths_bytes(self):
        return struct.pack("<%dI" % len(self.paths), *map(len, self.paths)) + b"".join(self.paths)

    def read_paths(self, data):
        f = Fields(data)
        lengths = [f.u32() for _ in range(self.ray_count())]
        self.paths = [f.take(length) for length in lengths]
        f.end()
        check(all(step < 10 for path in self.paths for step in path), "a step")

    # Codec 1.

    def decode_tree(self, data):
        coder, lights = Decoder(data), len(self.meta.lights)
        hit_models = bits(3 * 81)
        children_models = symbols(3 * 125, 2)
        shadow_models = [symbols(3 * 125, 2) for _ in range(lights)]
        found = {1: [(sample, None) for sample in range(self.w * self.h)]}
        for cls in range(1, 1 << self.meta.max_depth + 1):
            kind = 0 if cls == 1 else 1 if cls % 2 == 0 else 2
            done = {}
            for sample, parent in found.get(cls, ()):
                around = self.around(sample, done)

                def context(states, near, value):
                    total = kind
                    for n in near:
                        total = total * states + (0 if n is None else 1 + value(n))
                    return total

                node = Node(sample, cls)
                node.parent = parent
                node.hit = coder.bit(hit_models, context(3, around, lambda n: n.hit))
                if node.hit:
                    models = children_models[context(5, around[:3], lambda n: n.children)]
                    node.children = coder.symbol(models, 2)
                    for light in range(lights):
                        models = shadow_models[light][context(5, around[:3], lambda n: n.shadows >> 2 * light & 3)]
                        node.shadows |= coder.symbol(models, 2) << 2 * light
                check(not node.children or cls.bit_length() - 1 < self.meta.max_depth, "children at max depth")
                if node.children & 1:
                    found.setdefault(2 * cls, []).append((sample, node))
                if node.children & 2:
                    found.setdefault(2 * cls + 1, []).append((sample, node))
                done[sample] = node
            found[cls] = done
        for sample in range(self.w * self.h):
            stack = [1]
            while stack:
                cls = stack.pop()
                node = found[cls][sample]
                self.nodes.append(node)
                if node.children & 2:
                    stack.append(2 * cls + 1)
                if node.children & 1:
                    stack.append(2 * cls)

    def rebuild_ray(self, node):
        """The ray of a node, from the camera or from its parent's surface."""
        if node.parent is None:
            node.ray = primary(self.camera, self.x0 + node.sample % self.w, self.y0 + node.sample // self.w)
        elif node.cls % 2 == 0:
            node.ray = node.parent.surface.reflection()
        else:
            surface = node.parent.surface
            straight = (surface.point, surface.d)
            node.ray = surface.refraction(self.bvh.material(node.parent.triangle).ior) or straight

    def rebuild_surface(self, node):
        t = struct.unpack("<f", struct.pack("<I", node.t))[0]
        node.surface = Surface(node.ray, t, self.bvh.corners(node.triangle), node.normal)

    def decode_hits(self, data):
        coder = Decoder(data)
        same = [[bits(5) for _ in range(5)] for _ in range(4)]
        distance, distance_far = Number(), Number()
        t_model, normal_model = bits(1, 65000, 30), bits(1, 65000, 30)
        last = 0

        def triangle_of(near):
            for place, candidate in enumerate(near):
                if candidate in near[:place]:
                    continue
                if coder.bit(same[place][near[place:].count(candidate)], len(near) - place):
                    return candidate
            v = coder.number(distance if near else distance_far)
            return ((near[0] if near else last) + (-(v + 1) // 2 if v % 2 else v // 2)) & NONE

        for _cls, nodes in self.classes():
            done = {}
            for node in nodes:
                if not node.hit:
                    continue
                near = [n for n in self.around(node.sample, done) if n is not None]
                node.triangle = last = triangle_of(near)
                check(last < len(self.bvh.triangles), "a triangle is not there")
                self.rebuild_ray(node)
                t, u, v = intersect(node.ray, self.bvh.corners(last)) or (0.0, 0.0, 0.0)
                if coder.bit(t_model, 0):
                    node.t = struct.unpack("<I", struct.pack("<f", t))[0]
                else:
                    node.t = coder.raw(32)
                if coder.bit(normal_model, 0):
                    node.normal = shading_normal(self.bvh, last, u, v)
                else:
                    raw = coder.raw(32)
                    node.normal = (raw & 0xFFFF, raw >> 16)
                self.rebuild_surface(node)
                done[node.sample] = last

    def decode_radiance(self, data):
        coder = Decoder(data)
        residual = [[[Number() for _ in range(14)] for _ in range(3)] for _ in range(3)]
        sign = [bits(3) for _ in range(3)]
        weight = bits(2, 65000, 30)

        def kind(node):
            return (self.bvh.surfaces[node.triangle] if node.hit else None, node.shadows)

        def median_edge(w, n, nw):
            if nw >= max(w, n):
                return min(w, n)
            if nw <= min(w, n):
                return max(w, n)
            return w + n - nw

        def predict(node, around):
            here = kind(node)
            alike = [n if n is not None and kind(n) == here else None for n in around]
            w, n, nw, _ne = alike
            activity = min(13, sum(a.size for a in (w, n) if a is not None).bit_length())
            if w and n and nw:
                return [median_edge(*v) for v in zip(w.local, n.local, nw.local)], 2, activity
            if w and n:
                return [(a + b) // 2 for a, b in zip(w.local, n.local)], 2, activity
            for a in alike:
                if a:
                    return a.local, 1, activity
            for a in around[:2]:
                if a:
                    return a.local, 0, activity
            return (0, 0, 0), 0, activity

        for _cls, nodes in self.classes():
            done = {}
            for node in nodes:
                colour, trust, activity = predict(node, self.around(node.sample, done))
                green, value = 0, [0, 0, 0]
                for channel in (1, 0, 2):
                    follow = 0 if channel == 1 or trust == 0 else green
                    expected = min(max(colour[channel] + follow, 0), 0x7BFF)
                    rest = min(coder.number(residual[channel][trust][activity]), 65535)
                    if rest > 0 and coder.bit(sign[channel], 1 + (green > 0) - (green < 0)):
                        rest = -rest
                    value[channel] = min(max(expected + rest, 0), 65535)
                    check(value[channel] < 0x7C00, "a colour")
                    if channel == 1:
                        green = rest
                node.local, node.size = value, abs(green)
                done[node.sample] = node
                if not node.hit:
                    continue
                self.rebuild_ray(node)
                self.rebuild_surface(node)
                predicted = node.surface.weights(self.bvh.material(node.triangle)) if node.children else None
                for child in (0, 1):
                    if node.children >> child & 1:
                        met = coder.bit(weight, child)
                        node.weights[child] = predicted[child] if met else [coder.raw(16) for _ in range(3)]

    def streams(self):
        """The streams of rays: whether shadow rays, and per ray (sample, ray number)."""
        number = 0
        for node in self.nodes:
            node.first_ray = number
            number += 1 + len(node.casts())
        for _cls, nodes in self.classes():
            yield False, [(node.sample, node.first_ray) for node in nodes]
            for light in range(16):
                rays = [(n.sample, n.first_ray + 1 + n.casts().index(light)) for n in nodes if light in n.casts()]
                if rays:
                    yield True, rays

    def decode_paths(self, data):
        f = Fields(data)
        runs = [f.take(f.u32()) for _ in range(5)]
        coder = PathDecoder(self.bvh, runs, data[f.at :])
        self.paths = [None] * self.ray_count()
        for shadow, rays in self.streams():
            # Per sample (path number, steps).
            done = {}
            for sample, ray in rays:
                done[sample] = coder.path(shadow, self.around(sample, done), done)
                self.paths[ray] = done[sample][1]


# --- Paths, codec 1 -------------------------------------------------------------------------------------------------------------

STEP_NONE, LEFT, RIGHT, LEFT_FIRST, RIGHT_FIRST, POP, CULLED, MISS, HIT, PASS = range(10)


def expect(w, n, nw, ne):
    return n if n != 0 and w == nw else w or n or ne or nw


class Run:
    def __init__(self, data):
        self.coder, self.models = Decoder(data), Number()
        self.count = self.coder.number(self.models)

    def as_expected(self):
        if self.count > 0:
            self.count -= 1
            return 1
        self.count = self.coder.number(self.models)
        return 0


class Cells:
    """The labels of a node or leaf: by cell (path, label)."""

    def __init__(self):
        self.cells, self.stale = {}, 0

    def label(self, path):
        held, label = self.cells.get(path % 64, (0, 0))
        return label if path != 0 and held == path else 0


class PathDecoder:
    def __init__(self, bvh, runs, main):
        self.bvh = bvh
        self.runs = [Run(run) for run in runs]
        self.coder = Decoder(main)
        self.next = 1
        self.labels = {}
        self.same = [bits(64), bits(64)]
        self.fresh = [symbols(8, 3) for _ in range(8)]
        self.others = [symbols(8, 3) for _ in range(8)]
        self.outcomes = self.priors() * 3
        self.pops = [bits(256) for _ in range(3)]
        self.leaves = [bits(16) for _ in range(3)]
        self.tests = [bits(256) for _ in range(3)]
        self.passes = bits(256)

    @staticmethod
    def priors():
        out = []
        for context in range(4096):
            labels = [context & 7, context >> 3 & 7, context >> 6 & 7, context >> 9]
            expected = expect(*labels)
            q = (32768, 52000, 60000, 63500, 64900)[labels.count(expected)]
            if any(label not in (0, expected) for label in labels):
                q = q * 7 // 8
            out += bits(1, q, 2)
        return out

    def path(self, shadow, around, done):
        w, n, nw, ne = (0 if a is None else a[0] for a in around)
        context = (w == n) + 2 * (w == nw) + 4 * (n == nw) + 8 * (n == ne) + 16 * (n == 0) + 32 * shadow
        if w != 0 and self.next - w < 32 and self.coder.bit(self.same[0], context):
            return around[0]
        if n != 0 and n != w and self.next - n < 32 and self.coder.bit(self.same[1], context):
            return around[1]
        numbers = (w, n, nw, ne)
        if self.next > 16383:
            self.next = 1
            self.labels.clear()
            for sample in done:
                done[sample] = (0, done[sample][1])
            numbers = (0, 0, 0, 0)
        number = self.next
        self.next += 2 if self.next % 64 == 63 else 1
        return number, self.steps(shadow, number, numbers)

    def note(self, met):
        self.surprises = (self.surprises << 1 | (not met)) & 7

    def level(self):
        return min(bin(self.surprises).count("1"), 2)

    def cells(self, key):
        cells = self.labels.get(key)
        if cells is None:
            cells = self.labels[key] = Cells()
        return cells

    def steps(self, shadow, number, numbers):
        out = bytearray()
        current, stack, hit = ("node", 0), [], False
        self.surprises, self.last = 0, 0
        while True:
            following = None
            if current[0] == "leaf":
                if current[2] > 0:
                    cells = self.cells(current)
                    label = self.leaf(shadow, current, [cells.label(p) for p in numbers])
                    cells.cells[number % 64] = (number, label)
                    while label:
                        out.append(label % 4 - 1 + MISS)
                        hit = hit or label % 4 == 2
                        label //= 4
                    if shadow and hit:
                        return bytes(out)
            else:
                cells = self.cells(current)
                labels = [cells.label(p) for p in numbers]
                outcome = self.outcome(cells, [label & 7 for label in labels])
                check(1 <= outcome <= 5, "an outcome")
                cells.cells[number % 64] = (number, outcome)
                cells.stale = outcome
                out.append(outcome - 1)
                left, right = self.bvh.children[current[1]]
                waiting = None
                if outcome - 1 in (LEFT, LEFT_FIRST):
                    following, waiting = left, right
                elif outcome - 1 in (RIGHT, RIGHT_FIRST):
                    following, waiting = right, left
                if outcome - 1 in (LEFT_FIRST, RIGHT_FIRST):
                    w, n, nw, ne = (label >> 3 & 3 for label in labels)
                    stack.append((waiting, cells, w + 4 * n + 16 * nw + 64 * ne))
            while following is None and stack:
                child, cells, context = stack.pop()
                visited = 1
                if not shadow:
                    if hit:
                        visited = self.pop(context)
                    path, label = cells.cells[number % 64]
                    cells.cells[number % 64] = (path, label | (8 if visited else 16))
                out.append(POP if visited else CULLED)
                if visited:
                    following = child
            if following is None:
                return bytes(out)
            current = following

    def outcome(self, cells, labels):
        w, n, nw, ne = labels
        context = w + 8 * n + 64 * nw + 512 * ne
        agree = 2
        if n != 0 and w == n:
            if nw == n and ne == n:
                agree = 0
            elif nw in (n, 0) and ne in (n, 0):
                agree = 1

        def other(expected):
            return self.coder.symbol(self.others[expected][n if n != expected else w], 3)

        if agree < 2 and self.surprises == 0:
            outcome = n
            if not self.runs[agree].as_expected():
                self.note(False)
                outcome = other(n)
        elif context == 0:
            outcome = self.coder.symbol(self.fresh[cells.stale][self.last], 3)
        else:
            expected = expect(w, n, nw, ne)
            met = self.coder.bit(self.outcomes, self.level() * 4096 + context)
            self.note(met)
            outcome = expected if met else other(expected)
        self.last = outcome
        return outcome

    def pop(self, context):
        if context in (0x55, 0xAA) and self.surprises == 0:
            met = self.runs[4].as_expected()
            self.note(met)
            return met == (context == 0x55)
        return self.coder.bit(self.pops[self.level()], context)

    def leaf(self, shadow, leaf, labels):
        w, n, nw, ne = labels
        expected = expect(w, n, nw, ne)
        if expected != 0:
            agree = (w == expected) + 2 * (n == expected) + 4 * (nw == expected) + 8 * (ne == expected)
            if agree == 15 and self.surprises == 0:
                met = self.runs[2].as_expected()
            elif agree == 7 and self.surprises == 0:
                met = self.runs[3].as_expected()
            else:
                met = self.coder.bit(self.leaves[self.level()], agree)
            self.note(met)
            if met:
                return expected
        result = 0
        for i in range(leaf[2]):
            a, b, c, d = (label >> 2 * i & 3 for label in labels)
            context = a + 4 * b + 16 * c + 64 * d
            value = 1
            if self.coder.bit(self.tests[self.level()], context):
                passes = self.bvh.may_pass(leaf[1] + i, shadow) and self.coder.bit(self.passes, context)
                value = 3 if passes else 2
            result |= value << 2 * i
            if shadow and value == 2:
                break
        return result


# --- BLAKE3 (its specification, without key or key derivation) --------------------------------------------------------------

IV = (0x6A09E667, 0xBB67AE85, 0x3C6EF372, 0xA54FF53A, 0x510E527F, 0x9B05688C, 0x1F83D9AB, 0x5BE0CD19)
PERMUTATION = (2, 6, 3, 10, 7, 0, 4, 13, 1, 11, 12, 5, 9, 14, 15, 8)
MIXES = (
    (0, 4, 8, 12), (1, 5, 9, 13), (2, 6, 10, 14), (3, 7, 11, 15),
    (0, 5, 10, 15), (1, 6, 11, 12), (2, 7, 8, 13), (3, 4, 9, 14),
)
CHUNK_START, CHUNK_END, PARENT, ROOT = 1, 2, 4, 8


def compress(value, words, counter, length, flags):
    s = list(value) + list(IV[:4]) + [counter & NONE, counter >> 32, length, flags]
    for turn in range(7):
        for k, (a, b, c, d) in enumerate(MIXES):
            va, vb, vc, vd = s[a], s[b], s[c], s[d]
            va = (va + vb + words[2 * k]) & NONE
            vd ^= va
            vd = (vd >> 16 | vd << 16) & NONE
            vc = (vc + vd) & NONE
            vb ^= vc
            vb = (vb >> 12 | vb << 20) & NONE
            va = (va + vb + words[2 * k + 1]) & NONE
            vd ^= va
            vd = (vd >> 8 | vd << 24) & NONE
            vc = (vc + vd) & NONE
            vb ^= vc
            s[a], s[b], s[c], s[d] = va, (vb >> 7 | vb << 25) & NONE, vc, vd
        if turn < 6:
            words = [words[i] for i in PERMUTATION]
    return [s[i] ^ s[i + 8] for i in range(8)]


def blake3(data):
    def chunk(part, counter, root):
        value = IV
        for at in range(0, max(len(part), 1), 64):
            block = part[at : at + 64]
            flags = CHUNK_START if at == 0 else 0
            if at + 64 >= len(part):
                flags |= CHUNK_END | root
            value = compress(value, struct.unpack("<16I", block.ljust(64, b"\0")), counter, len(block), flags)
        return value

    def tree(first, count, root):
        """The value over chunks first to first + count - 1."""
        if count == 1:
            return chunk(data[1024 * first : 1024 * first + 1024], first, root)
        left = 1 << (count - 1).bit_length() - 1
        words = tree(first, left, 0) + tree(first + left, count - left, 0)
        return compress(IV, words, 0, 64, PARENT | root)

    return struct.pack("<8I", *tree(0, max(1, -(-len(data) // 1024)), ROOT))


# --- The whole trace --------------------------------------------------------------------------------------------------------

COLUMNS = ("tree", "hits", "radiance", "paths")


def canonical_columns(meta, bvh, camera, index, payload):
    """By column (name, codec, canonical bytes) of a tile; each is decoded and written again."""
    columns = tile_columns(payload)
    tile = Tile(meta, bvh, camera, index)
    for ident, name in enumerate(COLUMNS):
        check(ident in columns, "a tile lacks column " + name)
        codec, raw_length, data = columns[ident]
        check(codec < 2, "column %s is coded by codec %d, which is unknown" % (name, codec))
        if codec == 0:
            getattr(tile, "read_" + name)(unzstd(data, raw_length))
        else:
            getattr(tile, "decode_" + name)(data)
        canonical = getattr(tile, name + "_bytes")()
        check(len(canonical) == raw_length, "raw length of column " + name)
        yield name, codec, canonical


def main(path, digest):
    assert blake3(b"abc").hex().startswith("6437b3ac38465133ffb63b75273a8db5")
    with open(path, "rb") as file:
        trace = File(file.read())
    meta_payload, bvh_payload = trace.get(b"META"), trace.get(b"BVH ")
    check(meta_payload is not None and bvh_payload is not None, "META or BVH is missing")
    meta, bvh = Meta(meta_payload), Bvh(bvh_payload)
    if not digest:
        print("%s by %s: %d nodes, %d triangles" % (meta.scene, meta.tool, len(bvh.children), len(bvh.triangles)))
    cameras, hashes = [], {name: [] for name in COLUMNS}
    for frame in range(meta.first_frame, meta.first_frame + meta.frames):
        payload = trace.get(b"FRAM", frame)
        if payload is None:
            continue
        cameras.append(struct.pack("<I", frame) + payload)
        fields = Fields(payload)
        camera = [fields.vec3() for _ in range(4)]
        fields.end()
        for index in range(meta.tiles):
            payload = trace.get(b"TILE", frame, index)
            if payload is None:
                continue
            for name, codec, canonical in canonical_columns(meta, bvh, camera, index, payload):
                if digest:
                    hashes[name].append(struct.pack("<II", frame, index) + blake3(canonical))
                else:
                    row = (frame, index, name, codec, len(canonical), crc32(canonical))
                    print("frame %d tile %d %s: codec %d, %d bytes, CRC-32 %08x" % row)
    if digest:
        parts = [("meta", meta.untooled), ("bvh", bvh_payload), ("cameras", b"".join(cameras))]
        parts += [(name, b"".join(hashes[name])) for name in COLUMNS]
        parts = [(name, blake3(data)) for name, data in parts]
        parts.append(("total", blake3(b"".join(value for _, value in parts))))
        for name, value in parts:
            print("%s  %s" % (value.hex(), name))


if __name__ == "__main__":
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    try:
        main(sys.argv[1], "--digest" in sys.argv[2:])
    except Bad as bad:
        sys.exit("%s: %s" % (sys.argv[1], bad))
