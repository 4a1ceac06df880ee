"""Bodies that scatter behind a clear wall, with something in them, in a form that two renderers read: ours (in_ours.py) and Mitsuba 3
(in_mitsuba.py). Media and clear walls are white: a wall here takes the square root of its colour, and Mitsuba's takes nothing."""
import math
import pathlib
import sys
from typing import NamedTuple, Optional

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "scenes"))
from shapes import cube_sphere, torus  # noqa: E402

EYE, FOCAL, APERTURE = (0.0, 0.0, 5.0), 75.0, 36.0
PIXELS, BLOCK = 18, 6  # of a picture's side, of a block's side


class Medium(NamedTuple):
    free_path: float
    g: float = 0.0
    ior: float = 1.0


class Clear(NamedTuple):
    ior: float = 1.0
    absorption: float = 0.0  # per unit
    priority: int = 0


class Matt(NamedTuple):
    color: tuple = (0.0, 0.0, 0.0)
    emission: float = 0.0


class Mirror(NamedTuple):
    """It reflects all."""


class Thing(NamedTuple):
    shape: tuple  # points, faces
    look: object
    within: Optional[str] = None  # what is around it; None: air
    place: np.ndarray = np.eye(4)
    copies: tuple = ()  # matrices: one for each instance of an array
    # Where it stands out of what is around it Mitsuba needs its walls by what lies on both sides: (shape, within) each. An opaque thing
    # does not: the medium of a path is that from which it comes.
    walls: tuple = ()


class Scene(NamedTuple):
    things: dict
    sky: float = 1.0
    lamp: Optional[tuple] = None  # width, height, radiance: above, at y 2.5, facing down


def box(x, y, z, low=None):
    lower, upper = (np.array(low), np.array((x, y, z))) if low else (-np.array((x, y, z)), np.array((x, y, z)))
    points = np.array([[(lower, upper)[b][k] for k, b in enumerate(bits)] for bits in np.ndindex(2, 2, 2)], float)
    return points, [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)]


def of_mesh(mesh):
    return np.array(mesh.points, float), [tuple(q) for q in mesh.quads]


def ball(radius, n=12):
    return of_mesh(cube_sphere(n, lambda d: tuple(radius * c for c in d)))


def ring(major, minor):
    return of_mesh(torus(major, minor, rings=32, sides=16))


def rod(radius, low, high, sides=24):
    angles = [2 * math.pi * k / sides for k in range(sides)]
    points = [(radius * math.sin(a), y, radius * math.cos(a)) for y in (low, high) for a in angles]
    sides_of = [(k, (k + 1) % sides, sides + (k + 1) % sides, sides + k) for k in range(sides)]
    return np.array(points), [*sides_of, tuple(range(sides - 1, -1, -1)), tuple(range(sides, 2 * sides))]


def tetrahedron(size):
    points = size * np.array([(1, 1, 1), (1, -1, -1), (-1, 1, -1), (-1, -1, 1)], float)
    return points, [(0, 1, 2), (0, 3, 1), (0, 2, 3), (1, 3, 2)]


def octahedron(size):
    points = size * np.array([(1, 0, 0), (-1, 0, 0), (0, 1, 0), (0, -1, 0), (0, 0, 1), (0, 0, -1)], float)
    return points, [(0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4), (2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5)]


def open_box(half, low, high, lid):
    """The sides of a square prism about the y axis, and one of its ends: "top", "bottom"."""
    points, faces = box(half, high, half, (-half, low, -half))
    ends = {"bottom": 2, "top": 3}
    return points, [f for k, f in enumerate(faces) if k not in ends.values() or k == ends[lid]]


def box_with_hole(x, y, z, half):
    """A box whose top has a square hole about the y axis."""
    points, faces = box(x, y, z)
    corners = [(-1, -1), (-1, 1), (1, 1), (1, -1)]  # counter-clockwise from above, in x and z
    outer = [(a * x, y, b * z) for a, b in corners]
    inner = [(a * half, y, b * half) for a, b in corners]
    first = len(points)
    frame = [(first + k, first + (k + 1) % 4, first + 4 + (k + 1) % 4, first + 4 + k) for k in range(4)]
    return np.concatenate([points, outer, inner]), [f for k, f in enumerate(faces) if k != 3] + frame


def placed(axis, degrees, at=(0, 0, 0), scale=(1, 1, 1)):
    """Scaled, turned about an axis, moved; row vectors."""
    axis = np.array(axis, float) / np.linalg.norm(axis)
    k, a, m = np.cross(np.eye(3), axis), math.radians(degrees), np.eye(4)
    m[:3, :3] = np.diag(scale) @ (np.eye(3) + math.sin(a) * k + (1 - math.cos(a)) * k @ k)
    m[3, :3] = at
    return m


def grains(count):
    """Places of tiny cubes in a lattice, each turned otherwise."""
    n, places = round(count ** (1 / 3)), []
    for i, j, k in np.ndindex(n, n, n):
        at = [1.5 * ((c + 0.5) / n - 0.5) for c in (i, j, k)]
        places.append(placed((1 + i % 3, 1 + j % 5, 1 + k % 7), 37 * (i + 2 * j + 3 * k), at))
    return tuple(places)


TURN = placed((1, 2, 3), 50)
SCENES = {
    "black cube": Scene({
        "milk": Thing(ball(1.0), Medium(0.2)),
        "cube": Thing(box(0.35, 0.35, 0.35), Matt(), "milk", placed((1, 2, 3), 50, (0.1, 0.1, 0.15)))}),
    "coloured ring in jelly": Scene({
        "jelly": Thing(box(0.9, 0.8, 0.7), Medium(0.1, 0.8, 1.33)),
        "ring": Thing(ring(0.45, 0.15), Matt((0.8, 0.2, 0.05)), "jelly", placed((1, 0.3, 0), 60, (0, 0.05, 0.2)))}),
    "black octahedron, light thrown back": Scene({
        "milk": Thing(box(0.9, 0.9, 0.6), Medium(0.25, -0.3, 1.5)),
        "stone": Thing(octahedron(0.45), Matt(), "milk", placed((1, 1, 0), 30, (-0.1, 0, 0.1)))}),
    "absorbing cube": Scene({
        "milk": Thing(ball(1.0), Medium(0.2, 0.3)),
        "cube": Thing(box(0.4, 0.3, 0.3), Clear(1.0, 3.0), "milk", placed((0, 1, 1), 40, (0.1, 0.2, 0.2)))}),
    "glass within": Scene({
        "milk": Thing(ball(1.0), Medium(0.3, 0.0, 1.33)),
        "glass": Thing(box(0.45, 0.3, 0.3), Clear(1.5, 1.0), "milk", placed((1, 1, 1), 25, (0, 0.1, 0.2)))}),
    "straw": Scene({
        "milk": Thing(box(0.9, 0.6, 0.6), Medium(0.15, 0.5, 1.35)),
        "straw": Thing(rod(0.2, -0.45, 0.95), Matt((0.7, 0.1, 0.1)), "milk", placed((0, 0, 1), 15, (0, 0, 0.1)))}),
    "ice": Scene({
        "milk": Thing(box(0.9, 0.6, 0.7), Medium(0.2, 0.0, 1.4), walls=((box_with_hole(0.9, 0.6, 0.7, 0.4), None),)),
        "ice": Thing(box(0.4, 0.9, 0.4, (-0.4, -0.1, -0.4)), Clear(1.31, 1.0, 2), "milk",
                     walls=((open_box(0.4, -0.1, 0.6, "bottom"), "milk"), (open_box(0.4, 0.6, 0.9, "top"), None)))}),
    "a body in a body in a body": Scene({
        "fog": Thing(ball(1.0), Medium(0.4)),
        "cloud": Thing(box(0.6, 0.5, 0.5), Medium(0.1), "fog", placed((1, 0, 1), 35)),
        "stone": Thing(tetrahedron(0.3), Matt(), "cloud")}),
    "bodies of several indices": Scene({
        "fog": Thing(box(0.9, 0.9, 0.9), Medium(0.5, -0.2, 1.2)),
        "cloud": Thing(ball(0.75, 8), Medium(0.15, 0.6, 1.5), "fog"),
        "bubble": Thing(octahedron(0.5), Clear(1.0, 2.0), "cloud", TURN)}),
    "array of grains": Scene({
        "jelly": Thing(box(0.8, 0.8, 0.8), Medium(0.4, 0.0, 1.1)),
        "grains": Thing(box(0.012, 0.012, 0.012), Matt(), "jelly", copies=grains(9261))}),
    "turned": Scene({
        "milk": Thing(box(1.0, 0.5, 0.5), Medium(0.2, 0.2, 1.3), None, placed((1, 2, 3), 50, (0.1, 0, 0), (0.8, 1.2, 1.6))),
        "stone": Thing(tetrahedron(0.4), Matt((0.1, 0.5, 0.9)), "milk", placed((3, 1, 0), 70, (0.1, 0, 0.1), (1, 0.5, 1)))}),
    "under a lamp": Scene({
        "milk": Thing(box(0.9, 0.7, 0.7), Medium(0.3, 0.4, 1.0)),
        "stone": Thing(box(0.3, 0.3, 0.3), Matt(), "milk", placed((1, 1, 0), 40, (0.2, 0.1, 0.2))),
        "coin": Thing(rod(0.3, -0.05, 0.05), Mirror(), "milk", placed((1, 0, 1), 70, (-0.5, 0.1, 0.3)))}, 0.0, (6.0, 6.0, 3.0)),
    "a glowing ring": Scene({
        "milk": Thing(ball(1.0), Medium(0.3, 0.0, 1.2)),
        "ring": Thing(ring(0.4, 0.15), Matt((0, 0, 0), 3.0), "milk", placed((1, 0, 0), 50))}),
    # A thousandth of the body's width; found only by chance, so its noise is asked for separately (NOISE).
    "needle": Scene({
        "milk": Thing(ball(1.0), Medium(0.2)),
        "needle": Thing(box(0.001, 0.6, 0.001), Matt((0, 0, 0), 300.0), "milk", placed((0, 0, 1), 30))}),
}
NOISE = {"needle": 0.03}
