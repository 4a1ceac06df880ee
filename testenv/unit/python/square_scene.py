"""A scene of one square, and how the tests of the Python module draw and read it."""
import hdalabaster

CORNERS = [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)]
BACK = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 6, 1]]


def moved(x, y=0, z=0):
    return [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [x, y, z, 1]]


def square(**options):
    """A square under a dome, seen from the front."""
    scene = hdalabaster.Scene(**options)
    scene.set_mesh("/square", CORNERS, [[0, 1, 2, 3]], material="/wax")
    scene.set_material("/wax", baseColor=(0.9, 0.6, 0.3))
    scene.set_light("/dome", "domeLight", intensity=1)
    scene.set_camera("/camera", BACK, focalLength=0.05, horizontalAperture=0.036, verticalAperture=0.036)
    return scene


def draw(renderer, **frame):
    return renderer.render(width=16, height=16, camera="/camera", **frame)


def pixel(render, x, y, aov="color"):
    view = memoryview(render.pixels(aov))
    return [view[y, x, c] for c in range(view.shape[2])] if view.ndim == 3 else view[y, x]
