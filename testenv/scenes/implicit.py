"""Closed quad cages around implicit bodies by surface nets (Gibson 1998), for shapes that sweeps cannot make. Standard library
only.

A body is a function of (x, y, z): negative inside, with about the distance to the surface as its absolute value.
"""
import math

from gltf_writer import Mesh


def smooth_min(a, b, k):
    """The union of two bodies with a fillet of width k (polynomial; Quilez)."""
    h = max(k - abs(a - b), 0.0) / k
    return min(a, b) - 0.25 * h * h * k


def smooth_max(a, b, k):
    return -smooth_min(-a, -b, k)


def ellipsoid(p, centre, radii):
    x, y, z = ((a - c) / r for a, c, r in zip(p, centre, radii))
    k0 = math.sqrt(x * x + y * y + z * z)
    if k0 == 0.0:
        return -min(radii)
    k1 = math.sqrt(sum((a / r) ** 2 for a, r in zip((x, y, z), radii)))
    return k0 * (k0 - 1.0) / k1


def cone_chain(p, joints):
    """A tube through joints (x, y, z, radius) that tapers between them."""
    best = float("inf")
    for a, b in zip(joints, joints[1:]):
        d = (b[0] - a[0], b[1] - a[1], b[2] - a[2])
        v = (p[0] - a[0], p[1] - a[1], p[2] - a[2])
        t = (d[0] * v[0] + d[1] * v[1] + d[2] * v[2]) / (d[0] * d[0] + d[1] * d[1] + d[2] * d[2])
        t = min(1.0, max(0.0, t))
        e = (v[0] - t * d[0], v[1] - t * d[1], v[2] - t * d[2])
        best = min(best, math.sqrt(e[0] * e[0] + e[1] * e[1] + e[2] * e[2]) - (a[3] + t * (b[3] - a[3])))
    return best


def curve(joints, steps=4):
    """Joints along a Catmull-Rom spline through `joints`, `steps` per span."""
    out = []
    ends = [joints[0]] + list(joints) + [joints[-1]]
    for a, b, c, d in zip(ends, ends[1:], ends[2:], ends[3:]):
        for s in range(steps):
            t = s / steps
            out.append(tuple(0.5 * (2 * q + (r - p) * t + (2 * p - 5 * q + 4 * r - s3) * t * t +
                                    (3 * q - p - 3 * r + s3) * t ** 3) for p, q, r, s3 in zip(a, b, c, d)))
    return out + [tuple(joints[-1])]


CORNERS = [(i, j, k) for i in (0, 1) for j in (0, 1) for k in (0, 1)]
EDGES = [(a, b) for a in CORNERS for b in CORNERS if sum(b) - sum(a) == 1 and all(q >= p for p, q in zip(a, b))]
BLOCK = 6  # cells per side of a block; blocks far from the surface are skipped


class SurfaceNet:
    """Samples a body on a lattice of `cell` within a box, and connects one point for each cell that the surface crosses."""

    def __init__(self, body, low, high, cell):
        self.body, self.low, self.cell = body, low, cell
        self.size = [math.ceil((b - a) / cell) for a, b in zip(low, high)]
        self.values = {}

    def place(self, node):
        return tuple(a + self.cell * n for a, n in zip(self.low, node))

    def value(self, node):
        if node not in self.values:
            self.values[node] = self.body(self.place(node))
        return self.values[node]

    def cells(self):
        """The cells of blocks near the surface: within twice the half diagonal, because distances are not exact."""
        reach = 2.0 * math.sqrt(3.0) * 0.5 * BLOCK * self.cell
        for bx in range(0, self.size[0], BLOCK):
            for by in range(0, self.size[1], BLOCK):
                for bz in range(0, self.size[2], BLOCK):
                    if abs(self.body(self.place((bx + BLOCK / 2, by + BLOCK / 2, bz + BLOCK / 2)))) < reach:
                        for i in range(bx, min(bx + BLOCK, self.size[0])):
                            for j in range(by, min(by + BLOCK, self.size[1])):
                                for k in range(bz, min(bz + BLOCK, self.size[2])):
                                    yield (i, j, k)

    def repair(self, cells):
        """Fills nodes until, in every cell, both the nodes inside and those outside are connected along its edges. Only then
        do at most two quads meet in an edge. Surfaces closer than a cell are joined, and small pits are filled."""
        again = True
        while again:
            again = False
            for cell in cells:
                nodes = [tuple(c + o for c, o in zip(cell, corner)) for corner in CORNERS]
                inside = [self.value(n) < 0 for n in nodes]
                if any(inside) and not all(inside) and self.is_pinched(inside):
                    nearest = min((self.value(n), n) for n, i in zip(nodes, inside) if not i)[1]
                    self.values[nearest] = -1e-3 * self.cell
                    again = True

    @staticmethod
    def is_pinched(inside):
        state = dict(zip(CORNERS, inside))
        for side in (True, False):
            members = [c for c in CORNERS if state[c] is side]
            reached, todo = {members[0]}, [members[0]]
            while todo:
                a = todo.pop()
                for b in members:
                    if b not in reached and sum(abs(p - q) for p, q in zip(a, b)) == 1:
                        reached.add(b)
                        todo.append(b)
            if len(reached) != len(members):
                return True
        for axis in range(3):  # a face whose diagonals differ, although the cell's nodes are connected around it
            for level in (0, 1):
                face = [state[c] for c in CORNERS if c[axis] == level]
                if face[0] == face[3] != face[1] == face[2]:
                    return True
        return False

    def crossing(self, cell):
        """The mean of the points where the surface crosses the cell's edges, or None."""
        found = []
        for a, b in EDGES:
            p, q = (tuple(c + o for c, o in zip(cell, corner)) for corner in (a, b))
            u, v = self.value(p), self.value(q)
            if (u < 0) != (v < 0):
                t = u / (u - v)
                found.append(tuple(x + t * (y - x) for x, y in zip(p, q)))
        if not found:
            return None
        return self.place(tuple(sum(c) / len(found) for c in zip(*found)))

    def onto_surface(self, p):
        """One Newton step along the gradient, of at most half a cell."""
        h, d = 0.1 * self.cell, self.body(p)
        g = [(self.body(tuple(c + (h if a == axis else 0.0) for a, c in enumerate(p))) - d) / h for axis in range(3)]
        n = sum(x * x for x in g)
        if n < 1e-6:
            return p
        step = max(-0.5 * self.cell, min(0.5 * self.cell, d / math.sqrt(n))) / math.sqrt(n)
        return tuple(c - step * x for c, x in zip(p, g))

    def mesh(self, uv_of=None, relax=2):
        mesh, index = Mesh(), {}
        cells = list(self.cells())
        self.repair(cells)
        for cell in cells:
            p = self.crossing(cell)
            if p:
                index[cell] = len(mesh.points)
                mesh.points.append(p)
        for cell in index:
            self.join(mesh, index, cell)
        self.relax(mesh, relax)
        check_closed(mesh)
        mesh.uvs = [[uv_of(mesh.points[p]) if uv_of else (0.0, 0.0) for p in quad] for quad in mesh.quads]
        return mesh

    def join(self, mesh, index, cell):
        """A quad across each of the three lattice edges that end in the cell's far corner."""
        for axis in range(3):
            u, v = (axis + 1) % 3, (axis + 2) % 3
            start = [cell[0], cell[1], cell[2]]
            start[u] += 1
            start[v] += 1
            end = list(start)
            end[axis] += 1
            inside = self.value(tuple(start)) < 0
            if inside == (self.value(tuple(end)) < 0):
                continue
            quad = []
            for a, b in ((0, 0), (1, 0), (1, 1), (0, 1)):
                other = list(cell)
                other[u] += a
                other[v] += b
                quad.append(index[tuple(other)])
            mesh.quads.append(quad if inside else quad[::-1])

    def relax(self, mesh, times):
        """Evens out the quads: each point moves half way to its neighbours' mean, then back onto the surface."""
        near = [set() for _ in mesh.points]
        for quad in mesh.quads:
            for a, b in zip(quad, quad[1:] + quad[:1]):
                near[a].add(b)
                near[b].add(a)
        near = [sorted(n) for n in near]  # sums must not depend on a set's order
        for _ in range(times):
            moved = []
            for p, around in zip(mesh.points, near):
                mean = [sum(mesh.points[n][c] for n in around) / len(around) for c in range(3)]
                moved.append(self.onto_surface(tuple(0.5 * a + 0.5 * m for a, m in zip(p, mean))))
            mesh.points = moved


def check_closed(mesh):
    """Checks that every edge joins two quads that run along it in opposite directions."""
    seen = {}
    for quad in mesh.quads:
        for edge in zip(quad, quad[1:] + quad[:1]):
            seen[edge] = seen.get(edge, 0) + 1
    bad = sum(1 for (a, b), n in seen.items() if n != 1 or seen.get((b, a)) != 1)
    if bad:
        raise ValueError("%d edges of an implicit body are open or shared by more than two quads; use smaller cells, "
                         "a larger box, or thicker parts" % bad)
