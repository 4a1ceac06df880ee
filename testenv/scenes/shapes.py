"""Closed quad cages for subdivision that the bundled scenes share. Metres, y up, faces counter-clockwise from outside."""
import math

from gltf_writer import Mesh


def unit(a):
    n = math.sqrt(sum(x * x for x in a))
    return tuple(x / n for x in a)


def cube_sphere(n, point_of):
    """A cube of n x n quads per side, deformed to point_of(unit direction)."""
    mesh, index = Mesh(), {}

    def vertex(p):
        key = tuple(round(c, 6) for c in p)
        if key not in index:
            index[key] = len(mesh.points)
            mesh.points.append(tuple(point_of(unit(p))))
        return index[key]

    for axis in range(3):
        for side in (-1, 1):
            for i in range(n):
                for j in range(n):
                    corners, uvs = [], []
                    for a, b in ((i, j), (i + 1, j), (i + 1, j + 1), (i, j + 1)):
                        p = [0.0, 0.0, 0.0]
                        p[axis] = side
                        # Equal angles rather than equal lengths give quads of similar size.
                        p[(axis + 1) % 3] = math.tan((2 * a / n - 1) * math.pi / 4)
                        p[(axis + 2) % 3] = math.tan((2 * b / n - 1) * math.pi / 4)
                        corners.append(vertex(p))
                        uvs.append((a / n, b / n))
                    if side < 0:
                        corners.reverse()
                        uvs.reverse()
                    mesh.quads.append(corners)
                    mesh.uvs.append(uvs)
    return mesh


def fan_cap(mesh, base, sides, centre, bottom, uv=(0.5, 0.0)):
    """Closes a ring of an even number of points with quads around one point."""
    mesh.points.append(centre)
    middle = len(mesh.points) - 1
    for j in range(0, sides, 2):
        quad = [base + j, base + j + 1, base + (j + 2) % sides, middle]
        if bottom:
            quad.reverse()
        mesh.quads.append(quad)
        mesh.uvs.append([uv] * 4)


def lathe(profile, sides=16, radius_of=None):
    """Turns (radius, height) pairs, from the bottom up along the outside, around the y axis, and closes both ends. A profile
    that goes up outside and down inside makes a vessel. radius_of(angle, k, radius) may deform ring k. `sides` is even."""
    mesh = Mesh()
    rings = []
    for k, (r, y) in enumerate(profile):
        ring = []
        for j in range(sides):
            a = 2 * math.pi * j / sides
            bent = radius_of(a, k, r) if radius_of else r
            ring.append((bent * math.cos(a), y, -bent * math.sin(a)))
        rings.append(ring)
    last = len(profile) - 1
    first = mesh.add_grid(rings, lambda i, j: (j / sides, i / last), closed_u=True)
    fan_cap(mesh, first, sides, (0.0, profile[0][1], 0.0), bottom=True)
    fan_cap(mesh, first + last * sides, sides, (0.0, profile[-1][1], 0.0), bottom=False)
    return mesh


def torus(major, minor, rings=16, sides=8, bend=None):
    """A torus around the y axis. bend(angle) lifts the ring at that angle."""
    mesh, points = Mesh(), []
    for i in range(rings):
        a = 2 * math.pi * i / rings
        lift = bend(a) if bend else 0.0
        points.append([((major + minor * math.cos(b)) * math.cos(a), lift + minor * math.sin(b),
                        -(major + minor * math.cos(b)) * math.sin(a))
                       for b in (2 * math.pi * j / sides for j in range(sides))])
    points.append(points[0])
    mesh.add_grid(points, lambda i, j: (j / sides, i / rings), closed_u=True, flip=True)
    # The last row shares the points of the first, so that subdivision sees no seam.
    n, count = sides, rings * sides
    mesh.quads = [[p - count if p >= count else p for p in quad] for quad in mesh.quads]
    del mesh.points[count:count + n]
    return mesh


def box(width, height, depth, bevel):
    """A box standing on y = 0. A loop of quads at `bevel` from each edge keeps the edges sharp."""
    def cuts(size):
        return [-size / 2, -size / 2 + bevel, size / 2 - bevel, size / 2]

    xs, zs, ys = cuts(width), cuts(depth), [y + height / 2 for y in cuts(height)]
    mesh, index = Mesh(), {}

    def vertex(i, j, k):
        if (i, j, k) not in index:
            index[(i, j, k)] = len(mesh.points)
            mesh.points.append((xs[i], ys[j], zs[k]))
        return index[(i, j, k)]

    for a in range(3):
        for b in range(3):
            uv = [(a / 3, b / 3), ((a + 1) / 3, b / 3), ((a + 1) / 3, (b + 1) / 3), (a / 3, (b + 1) / 3)]
            for at, axes in ((0, "x"), (3, "x"), (0, "y"), (3, "y"), (0, "z"), (3, "z")):
                def corner(p, q):
                    return vertex(*{"x": (at, p, q), "y": (q, at, p), "z": (p, q, at)}[axes])
                quad = [corner(a, b), corner(a + 1, b), corner(a + 1, b + 1), corner(a, b + 1)]
                uvs = list(uv)
                if at == 0:
                    quad.reverse()
                    uvs.reverse()
                mesh.quads.append(quad)
                mesh.uvs.append(uvs)
    return mesh


def backdrop(width=4.0, front=1.6, back=-0.75, rise=1.6):
    """A floor that sweeps up behind the subject."""
    mesh = Mesh()
    profile = [(front, 0.0), (front * 0.4, 0.0), (back * 0.3, 0.0), (back, 0.0), (back - 0.4, 0.12), (back - 0.6, 0.55),
               (back - 0.65, rise)]
    mesh.add_grid([[(x * width / 2, y, z) for x in (-1.0, -0.35, 0.35, 1.0)] for z, y in profile],
                  lambda i, j: (j / 3, i / (len(profile) - 1)))
    return mesh


def placed(turn=0.0, lean=0.0, size=1.0, at=(0.0, 0.0, 0.0)):
    """Column-major matrix: scale, lean towards +x, turn around y (radians), then move."""
    ct, st, cl, sl = math.cos(turn), math.sin(turn), math.cos(lean), math.sin(lean)
    x = (ct * cl * size, -sl * size, -st * cl * size)
    y = (ct * sl * size, cl * size, -st * sl * size)
    z = (st * size, 0.0, ct * size)
    return [*x, 0.0, *y, 0.0, *z, 0.0, *at, 1.0]


def lattice(x, y, salt):
    """A number in 0..1 that depends on whole x, y and salt alone."""
    n = (x * 374761393 + y * 668265263 + salt) & 0xffffffff
    n = ((n ^ (n >> 13)) * 1274126177) & 0xffffffff
    return ((n ^ (n >> 16)) & 0xffff) / 65535


def noise(x, y, salt):
    """Smooth noise in 0..1 over that lattice."""
    i, j = math.floor(x), math.floor(y)
    u, v = x - i, y - j
    u, v = u * u * (3 - 2 * u), v * v * (3 - 2 * v)
    a = lattice(i, j, salt) * (1 - u) + lattice(i + 1, j, salt) * u
    b = lattice(i, j + 1, salt) * (1 - u) + lattice(i + 1, j + 1, salt) * u
    return a * (1 - v) + b * v
