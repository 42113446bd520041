#!/usr/bin/env python3
"""Writes the meshes that the shots stand on, a mesh for each colour since a mesh has one albedo.

    landscape.py FOLDER

The same bytes every time. Lengths of the valley are kilometres, those of the stones and the works metres;
+y is up.
"""
import argparse
import math
import os


def unit_noise(*key):
    """A number in [0, 1) that depends on the integers of the key alone."""
    h = 2166136261
    for k in key:
        h = ((h ^ (k & 0xffffffff)) * 16777619) & 0xffffffff
        h ^= h >> 15
        h = (h * 0x2c1b3c6d) & 0xffffffff
        h ^= h >> 13
    return h / 2.0**32


def value_noise(x, z, seed):
    """Smooth noise in [-1, 1] whose features are a unit wide."""
    i, k = math.floor(x), math.floor(z)
    u, v = x - i, z - k
    u, v = u * u * (3 - 2 * u), v * v * (3 - 2 * v)
    a, b = unit_noise(i, k, seed), unit_noise(i + 1, k, seed)
    c, d = unit_noise(i, k + 1, seed), unit_noise(i + 1, k + 1, seed)
    return 2 * (a + (b - a) * u + (c - a) * v + (a - b - c + d) * u * v) - 1


def fractal_noise(x, z, seed, octaves=5):
    return sum(value_noise(x * 2**o, z * 2**o, seed + o) / 2**o for o in range(octaves)) / 2


def smooth_step(lo, hi, x):
    t = min(max((x - lo) / (hi - lo), 0), 1)
    return t * t * (3 - 2 * t)


class Mesh:
    def __init__(self):
        self.vertices, self.faces, self.index = [], [], {}

    def vertex(self, p):
        key = tuple(round(c, 5) for c in p)
        if key not in self.index:
            self.vertices.append(key)
            self.index[key] = len(self.vertices)
        return self.index[key]

    def face(self, *points):
        self.faces.append([self.vertex(p) for p in points])

    def cone(self, foot, radius, height, sides=5):
        ring = [(foot[0] + radius * math.cos(2 * math.pi * s / sides), foot[1],
                 foot[2] + radius * math.sin(2 * math.pi * s / sides)) for s in range(sides)]
        tip = (foot[0], foot[1] + height, foot[2])
        for s in range(sides):
            self.face(ring[s], tip, ring[(s + 1) % sides])

    def prism(self, foot, size, turn=0.0, taper=1.0, lean=(0, 0)):
        """A box that stands on `foot`, turned by degrees, whose top is `taper` times its base."""
        c, s = math.cos(math.radians(turn)), math.sin(math.radians(turn))

        def corner(x, z, y):
            k = (taper if y else 1) / 2
            x, z = x * size[0] * k + lean[0] * y, z * size[2] * k + lean[1] * y
            return (foot[0] + c * x - s * z, foot[1] + size[1] * y, foot[2] + s * x + c * z)

        around = [(-1, -1), (1, -1), (1, 1), (-1, 1)]
        low = [corner(x, z, 0) for x, z in around]
        high = [corner(x, z, 1) for x, z in around]
        for i in range(4):
            j = (i + 1) % 4
            self.face(low[i], low[j], high[j], high[i])
        self.face(*high)
        return high

    def house(self, foot, size, roof, turn):
        """Walls under a gable as high as `roof`, along the longer x."""
        a, b, c, d = self.prism(foot, size, turn)
        left = tuple((p + q) / 2 + (roof if n == 1 else 0) for n, (p, q) in enumerate(zip(a, d)))
        right = tuple((p + q) / 2 + (roof if n == 1 else 0) for n, (p, q) in enumerate(zip(b, c)))
        for polygon in ((a, b, right, left), (c, d, left, right), (a, left, d), (b, c, right)):
            self.face(*polygon)

    def cylinder(self, a, b, radius_a, radius_b, sides=24):
        """From a to b, closed at both ends."""
        axis = [q - p for p, q in zip(a, b)]
        length = math.sqrt(sum(x * x for x in axis))
        w = [x / length for x in axis]
        other = (0, 0, 1) if abs(w[2]) < 0.9 else (1, 0, 0)
        u = cross(other, w)
        scale = math.sqrt(sum(x * x for x in u))
        u = [x / scale for x in u]
        v = cross(w, u)

        def ring(centre, radius):
            return [tuple(p + radius * (math.cos(t) * x + math.sin(t) * y)
                          for p, x, y in zip(centre, u, v))
                    for t in (2 * math.pi * s / sides for s in range(sides))]

        low, high = ring(a, radius_a), ring(b, radius_b)
        for s in range(sides):
            t = (s + 1) % sides
            self.face(low[s], low[t], high[t], high[s])
        self.face(*low[::-1])
        self.face(*high)

    def ellipsoid(self, centre, radii, seed, rings=7, sides=10):
        """A rough one, as the crown of a tree is."""
        rows = []
        for r in range(rings + 1):
            polar = math.pi * r / rings
            row = []
            for s in range(sides):
                t = 2 * math.pi * s / sides
                k = 0.85 + 0.3 * unit_noise(r, s if 0 < r < rings else 0, seed)
                row.append((centre[0] + k * radii[0] * math.sin(polar) * math.cos(t),
                            centre[1] + k * radii[1] * math.cos(polar),
                            centre[2] + k * radii[2] * math.sin(polar) * math.sin(t)))
            rows.append(row)
        self.wrap(rows)

    def wrap(self, rings):
        """The wall between rings of as many points each, one above the other."""
        for low, high in zip(rings, rings[1:]):
            for s in range(len(low)):
                t = (s + 1) % len(low)
                self.face(low[s], low[t], high[t])
                self.face(low[s], high[t], high[s])

    def write(self, path):
        with open(path, "w") as out:
            out.write("# Written by samples/shots/landscape.py\n")
            for v in self.vertices:
                out.write("v %.6g %.6g %.6g\n" % v)
            for f in self.faces:
                out.write("f " + " ".join(map(str, f)) + "\n")


def cross(a, b):
    return [a[1] * b[2] - a[2] * b[1], a[2] * b[0] - a[0] * b[2], a[0] * b[1] - a[1] * b[0]]


# The valley: kilometres, seen from the origin towards -z.

def ground_height(x, z):
    away = math.hypot(x, z)
    rolling = 0.11 * fractal_noise(x / 3.1, z / 3.1, 1) * smooth_step(0.2, 3, away)
    valley = -0.2 * math.exp(-((x + 0.6 * z / 10) / 3.2)**2)          # the river's
    hills = 0.75 * smooth_step(7, 18, away) * (0.25 + 1.3 * fractal_noise(x / 6.3, z / 6.3, 20))
    ridge = 1 - abs(fractal_noise(x / 16, z / 16, 40, 6)) * 2.2
    mountains = 1.7 * smooth_step(22, 40, away) * max(0, ridge)**1.6
    return rolling + valley + max(hills, 0) + mountains


def nearest_field(x, z):
    """The field that a place belongs to: the nearest of jittered centres, half a kilometre apart."""
    cell, best = 0.42, (9e9, 0)
    i, k = math.floor(x / cell), math.floor(z / cell)
    for a in (i - 1, i, i + 1):
        for b in (k - 1, k, k + 1):
            dx = (a + unit_noise(a, b, 5)) * cell - x
            dz = (b + unit_noise(a, b, 6)) * cell - z
            best = min(best, (dx * dx + dz * dz, unit_noise(a, b, 7)))
    return best[1]


def is_wooded(x, z):
    return fractal_noise(x / 1.9 + 7, z / 1.9, 60, 4) > 0.17


def make_valley(meshes):
    columns, rows = 330, 150
    near, far, half_angle = 0.12, 75.0, math.radians(44)

    def place(c, r):
        angle = half_angle * (2 * c / columns - 1)
        away = near * (far / near)**(r / rows)
        x, z = away * math.sin(angle), -away * math.cos(angle)
        return (x, ground_height(x, z), z)

    grid = [[place(c, r) for c in range(columns + 1)] for r in range(rows + 1)]
    for r in range(rows):
        for c in range(columns):
            a, b, d, e = grid[r][c], grid[r][c + 1], grid[r + 1][c + 1], grid[r + 1][c]
            x, z = (a[0] + d[0]) / 2, (a[2] + d[2]) / 2
            if math.hypot(x, z) > 24:
                name = "far"
            elif is_wooded(x, z):
                name = "woods"
            else:
                field = nearest_field(x, z)
                name = "wheat" if field > 0.72 else "fallow" if field > 0.5 else "meadow"
            meshes[name].face(a, b, d)
            meshes[name].face(a, d, e)


def plant_trees(mesh):
    """Trees in the woods and a few in the open, fewer where they are too far to be told apart."""
    for n in range(60000):
        away = 0.5 * 24**unit_noise(n, 1, 90)
        angle = math.radians(41) * (2 * unit_noise(n, 2, 90) - 1)
        x, z = away * math.sin(angle), -away * math.cos(angle)
        if not is_wooded(x, z) and unit_noise(n, 3, 90) > 0.012:
            continue
        size = (0.6 + 0.8 * unit_noise(n, 4, 90)) * (1 + away / 9)
        mesh.cone((x, ground_height(x, z) - 0.002, z), 0.0055 * size, 0.019 * size)


def build_village(mesh, x, z, houses, seed):
    for n in range(houses):
        turn = 360 * unit_noise(n, 1, seed)
        u = x + 0.3 * (unit_noise(n, 2, seed) - 0.5)
        v = z + 0.3 * (unit_noise(n, 3, seed) - 0.5)
        mesh.house((u, ground_height(u, v) - 0.002, v), (0.018, 0.008, 0.011), 0.006, turn)
    y = ground_height(x, z) - 0.002
    mesh.prism((x, y, z), (0.009, 0.032, 0.009), 20)
    mesh.cone((x, y + 0.032, z), 0.0075, 0.02, 4)


# The fire: metres, on the plane y = 0.

def pile_logs(mesh):
    for n in range(9):
        angle = 2 * math.pi * (n + 0.5 * unit_noise(n, 1, 70)) / 9
        out = 0.75 + 0.25 * unit_noise(n, 2, 70)
        top = 0.62 + 0.25 * unit_noise(n, 3, 70)
        foot = (out * math.cos(angle), 0.03, out * math.sin(angle))
        tip = (-0.16 * math.cos(angle + 0.5), top, -0.16 * math.sin(angle + 0.5))
        mesh.cylinder(foot, tip, 0.075 + 0.03 * unit_noise(n, 4, 70), 0.05, 10)


def rough_stone(mesh, foot, size, turn, seed):
    """A standing stone: rings of a rough outline, narrower and leaning towards the top."""
    rings, sides = 7, 11
    c, s = math.cos(math.radians(turn)), math.sin(math.radians(turn))
    levels = []
    for r in range(rings + 1):
        y = r / rings
        narrow = (1 - 0.28 * y * y) * (0.62 if r == rings else 1)
        ring = []
        for k in range(sides):
            t = 2 * math.pi * k / sides
            rough = 1 + 0.22 * (unit_noise(k, r, seed) - 0.5) + 0.2 * (unit_noise(k, 99, seed) - 0.5)
            x = size[0] * 0.5 * narrow * rough * math.copysign(abs(math.cos(t))**0.6, math.cos(t))
            z = size[2] * 0.5 * narrow * rough * math.copysign(abs(math.sin(t))**0.6, math.sin(t))
            x += 0.12 * size[1] * y * (unit_noise(1, 2, seed) - 0.5)
            drop = 0.05 * size[1] * (unit_noise(k, r, seed + 1) - 0.5)
            ring.append((foot[0] + c * x - s * z, foot[1] + size[1] * y + drop,
                         foot[2] + s * x + c * z))
        levels.append(ring)
    mesh.wrap(levels)
    middle = tuple(sum(p[n] for p in levels[-1]) / sides for n in range(3))
    for k in range(sides):
        mesh.face(levels[-1][k], levels[-1][(k + 1) % sides], middle)


def raise_stones(mesh):
    for n in range(11):
        if n in (2, 3):                                          # open towards the camera
            continue
        angle = 2 * math.pi * (n + 0.25 * unit_noise(n, 1, 80)) / 11
        x, z = 4.4 * math.cos(angle), 4.4 * math.sin(angle)
        high = 1.7 + 1.1 * unit_noise(n, 2, 80)
        size = (0.8 + 0.5 * unit_noise(n, 3, 80), high, 0.45)
        rough_stone(mesh, (x, -0.05, z), size, math.degrees(angle) + 90, 200 + 10 * n)
    for n in range(16):                                          # around the fire
        angle = 2 * math.pi * (n + 0.4 * unit_noise(n, 4, 80)) / 16
        big = 0.2 + 0.14 * unit_noise(n, 5, 80)
        rough_stone(mesh, (1.2 * math.cos(angle), -0.04, 1.2 * math.sin(angle)),
                    (big * 1.4, big, big * 1.2), math.degrees(angle), 500 + 10 * n)


# The works: metres, on the plane y = 0, the chimney at the origin.

def build_chimney(mesh, bands):
    height, steps = 90.0, 60
    for n in range(steps):
        lo, hi = height * n / steps, height * (n + 1) / steps
        radius = 4.6 - 2.0 * lo / height, 4.6 - 2.0 * hi / height
        target = bands if lo > 66 and int((lo - 66) / 6) % 2 == 0 else mesh
        target.cylinder((0, lo, 0), (0, hi, 0), *radius, sides=32)


def build_halls(mesh):
    for x, z, size, roof, turn in ((-34, 8, (44, 12, 20), 5, 0), (-30, -22, (36, 16, 18), 6, 0),
                                   (26, -14, (24, 9, 14), 4, 90), (16, 14, (14, 6, 9), 3, 0)):
        mesh.house((x, 0, z), size, roof, turn)


def plant_park(mesh):
    """Broad trees behind the halls: three rough crowns each."""
    for n in range(700):
        x = 1100 * (unit_noise(n, 1, 95) - 0.42)
        z = -50 - 450 * unit_noise(n, 2, 95)
        size = 5 + 4 * unit_noise(n, 3, 95)
        for crown in range(3):
            u, v, w = (size * 0.9 * (unit_noise(n, crown, 96 + k) - 0.5) for k in range(3))
            mesh.ellipsoid((x + u, size * (0.85 + 0.25 * crown) + 0.5 * v, z + w),
                           (size * 0.62, size * 0.6, size * 0.62), 3 * n + crown)


def main():
    parser = argparse.ArgumentParser(description="Writes the meshes of the shots in this folder as .obj.")
    parser.add_argument("folder", help="for the files; made if it is missing")
    folder = parser.parse_args().folder
    os.makedirs(folder, exist_ok=True)
    names = ("meadow", "wheat", "fallow", "woods", "far", "trees", "houses", "logs", "stones", "works",
             "bands", "halls", "park")
    meshes = {name: Mesh() for name in names}
    make_valley(meshes)
    plant_trees(meshes["trees"])
    build_village(meshes["houses"], -0.55, -2.6, 34, 300)
    build_village(meshes["houses"], 1.9, -5.2, 30, 400)
    pile_logs(meshes["logs"])
    raise_stones(meshes["stones"])
    build_chimney(meshes["works"], meshes["bands"])
    build_halls(meshes["halls"])
    plant_park(meshes["park"])
    for name, mesh in meshes.items():
        if mesh.faces:
            mesh.write(os.path.join(folder, name + ".obj"))


if __name__ == "__main__":
    main()
