"""Stages of lights over a white floor, whose irradiance is known in closed form or by quadrature: absolute brightness.

A camera looks straight down at the floor. Each quarter of the picture is tested by itself, so that a light that is turned or moved fails too.
"""
import math

try:
    import numpy
except ImportError:  # run_stages.py skips all stages then
    numpy = None

from stage_text import HEAD, camera, floor, bound, material, moved, prim, shader

WIDTH, HEIGHT, DISTANCE, SAMPLES = 64, 48, 3.0, 64
DEVIATIONS = 4.5  # of the mean that are allowed: once in 150,000 tests
LOBE = 3e-3       # the floor is Disney's lobe where it is nearest to Lambert's: 0.1 % to 0.2 % below it, seen from above
PRECISION = 5e-3  # that the mean of a quarter must have, so that the test says something
PLACE = (0.4, 2.0, -0.3)  # of the lights that have one


def stage(light):
    white = material("white", "s", shader("s", "AlabasterDisney", "color3f inputs:baseColor = (1, 1, 1)", "float inputs:specular = 0", "float inputs:ior = 1",
                                          "float inputs:roughness = 0.43", "token outputs:surface"), terminal="alabaster:surface")
    return HEAD + camera(moved(y=DISTANCE, turn=(-90, 0, 0)), z=None) + white + floor(bound("/white"), y=0) + light


def seen_points():
    """x and z on the floor in the middle of each pixel. The picture's upper edge is towards -z."""
    wide, high = 0.8 * DISTANCE, 0.6 * DISTANCE
    return numpy.meshgrid((numpy.arange(WIDTH) + 0.5) / WIDTH * wide - wide / 2, (numpy.arange(HEIGHT) + 0.5) / HEIGHT * high - high / 2)


def from_place():
    """Square of the distance to the lights' place, and the cosine there and on the floor."""
    x, z = seen_points()
    square = (x - PLACE[0]) ** 2 + PLACE[1] ** 2 + (z - PLACE[2]) ** 2
    return square, PLACE[1] / numpy.sqrt(square)


def sphere(radius, radiance):
    square, cosine = from_place()
    return math.pi * radiance * radius ** 2 / square * cosine


def disk(radius, radiance):
    """Seen from a plane that is parallel to it."""
    square, _ = from_place()
    aside = square - PLACE[1] ** 2
    return math.pi * radiance / 2 * (1 - (square - radius ** 2) / numpy.sqrt((square + radius ** 2) ** 2 - 4 * aside * radius ** 2))


def rect(width, height, turn, radiance):
    """Lambert 1760: half the sum of the angle of each edge times the cosine between the floor's normal and the plane of edge and point."""
    x, z = seen_points()
    points = numpy.stack([x, numpy.zeros_like(x), z], axis=-1)
    c, s = math.cos(turn), math.sin(turn)
    corners = [numpy.array([PLACE[0] + c * u + s * v, PLACE[1], PLACE[2] - s * u + c * v]) - points
               for u, v in ((-width / 2, -height / 2), (width / 2, -height / 2), (width / 2, height / 2), (-width / 2, height / 2))]
    total = 0
    for a, b in zip(corners, corners[1:] + corners[:1]):
        cross = numpy.cross(a, b)
        length = numpy.linalg.norm(cross, axis=-1)
        total = total + numpy.arctan2(length, (a * b).sum(axis=-1)) * cross[..., 1] / length
    return radiance / 2 * numpy.abs(total)


def cylinder(radius, length, radiance, steps=96):
    """Quadrature over the side that faces a point. It lies along x."""
    x, z = seen_points()
    points = numpy.stack([x, numpy.zeros_like(x), z], axis=-1)
    total = numpy.zeros_like(x)
    for i in range(steps):
        for j in range(steps):
            angle = 2 * math.pi * (j + 0.5) / steps
            out = numpy.array([0, math.cos(angle), math.sin(angle)])
            to = numpy.array([PLACE[0] + length * ((i + 0.5) / steps - 0.5), PLACE[1], PLACE[2]]) + radius * out - points
            facing = numpy.maximum(-(to @ out), 0)
            total += facing * to[..., 1] / (to ** 2).sum(axis=-1) ** 2
    return radiance * total * length * 2 * math.pi * radius / steps ** 2


def spot(angle, focus, intensity):
    """A point: UsdLux's focus is a power of the cosine to the axis, and beyond the cone there is no light. Not a number at its edge."""
    square, cosine = from_place()
    beyond = numpy.degrees(numpy.arccos(cosine)) - angle
    expected = numpy.where(beyond < 0, intensity * cosine ** (1 + focus) / square, 0)
    return numpy.where(numpy.abs(beyond) < 2, numpy.nan, expected)


def distant(angle, tilt, radiance):
    """A disk of the sky wholly above the floor: its solid angle on the plane that faces it, times the cosine."""
    return numpy.full((HEIGHT, WIDTH), math.pi * math.sin(math.radians(angle / 2)) ** 2 * radiance * math.cos(math.radians(tilt)))


def dome(radiance):
    return numpy.full((HEIGHT, WIDTH), math.pi * radiance)


def quarter_fault(found, expected):
    """The mean ratio must be 1 where light is expected."""
    lit = expected > 0
    ratio = found[lit] / expected[lit] - 1
    mean, error = float(ratio.mean()), float(ratio.std() / math.sqrt(ratio.size))
    if error > PRECISION:
        return f"known within {error:.1e} only"
    return f"off by {mean:+.4f}, of which {DEVIATIONS * error + LOBE:.4f} may be noise" if abs(mean) > DEVIATIONS * error + LOBE else ""


def fault_of(picture, irradiance, color):
    """The floor reflects the irradiance over pi: in each quarter and channel."""
    radiance = picture["color"]
    if numpy.any(radiance[..., :3][irradiance == 0]):
        return "there is light where none may be"
    for rows in (slice(0, HEIGHT // 2), slice(HEIGHT // 2, HEIGHT)):
        for columns in (slice(0, WIDTH // 2), slice(WIDTH // 2, WIDTH)):
            for channel in range(3):
                fault = quarter_fault(radiance[rows, columns, channel].astype(float), irradiance[rows, columns] * color[channel] / math.pi)
                if fault:
                    return f"rows from {rows.start}, columns from {columns.start}, channel {channel}: {fault}"
    return ""


def over_floor(kind, *lines, turn=(-90, 0, 0), about=""):
    return stage(prim(kind, "light", *lines, moved(*PLACE, turn), about=about))


def bright(text, irradiance, color=(1, 1, 1)):
    return lambda _: {"stage": text, "frames": [{"settings": {"alabaster:samples": SAMPLES}}],
                      "check": lambda pictures: fault_of(pictures[0], irradiance(), color)}


SPHERE_AREA, DISK_AREA = 4 * math.pi * 0.3 ** 2, math.pi * 0.5 ** 2
NORMALIZED, STOP = "bool inputs:normalize = 1", "float inputs:exposure = 1"
COLORED, COLOR = "color3f inputs:color = (1, 0.5, 0.25)", (1, 0.5, 0.25)
SIZE_3, RECT_SIZE = "float inputs:radius = 0.3", ("float inputs:width = 1.5", "float inputs:height = 0.5")
FOUR = "float inputs:intensity = 4"

CASES = {
    "irradiance_of_sphere": bright(over_floor("SphereLight", SIZE_3, FOUR, COLORED), lambda: sphere(0.3, 4), COLOR),
    "irradiance_of_sphere_normalized": bright(over_floor("SphereLight", SIZE_3, FOUR, STOP, NORMALIZED), lambda: sphere(0.3, 8 / SPHERE_AREA)),
    "irradiance_of_point": bright(over_floor("SphereLight", SIZE_3, FOUR, "bool treatAsPoint = 1", NORMALIZED), lambda: spot(180, 0, 1)),
    "irradiance_of_disk": bright(over_floor("DiskLight", "float inputs:radius = 0.5", FOUR, STOP), lambda: disk(0.5, 8)),
    "irradiance_of_disk_normalized": bright(over_floor("DiskLight", "float inputs:radius = 0.5", FOUR, NORMALIZED), lambda: disk(0.5, 4 / DISK_AREA)),
    "irradiance_of_rect": bright(over_floor("RectLight", *RECT_SIZE, FOUR, COLORED, turn=(-90, 30, 0)), lambda: rect(1.5, 0.5, math.radians(30), 4), COLOR),
    "irradiance_of_rect_normalized": bright(over_floor("RectLight", *RECT_SIZE, FOUR, NORMALIZED), lambda: rect(1.5, 0.5, 0, 4 / 0.75)),
    "irradiance_of_cylinder": bright(over_floor("CylinderLight", "float inputs:length = 1.5", "float inputs:radius = 0.2", FOUR), lambda: cylinder(0.2, 1.5, 4)),
    "irradiance_of_spot": bright(over_floor("SphereLight", SIZE_3, FOUR, "bool treatAsPoint = 1", NORMALIZED, "float inputs:shaping:cone:angle = 30",
                                            "float inputs:shaping:focus = 2", about='prepend apiSchemas = ["ShapingAPI"]'), lambda: spot(30, 2, 1)),
    "irradiance_of_distant": bright(over_floor("DistantLight", "float inputs:angle = 20", FOUR, COLORED, turn=(-50, 20, 0)), lambda: distant(20, 40, 4), COLOR),
    "irradiance_of_distant_normalized": bright(over_floor("DistantLight", "float inputs:angle = 20", FOUR, STOP, NORMALIZED, turn=(-50, 20, 0)),
                                               lambda: distant(20, 40, 8 / (math.pi * math.sin(math.radians(10)) ** 2))),
    "irradiance_of_dome": bright(stage(prim("DomeLight", "light", "float inputs:intensity = 0.7", COLORED)), lambda: dome(0.7), COLOR),
}
