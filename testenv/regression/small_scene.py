"""A small scene of the Python module: wax, glass, metal and a textured floor under a lamp and a dome, all tiny."""
import pathlib
import sys

import hdalabaster

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "scenes"))
from gltf_writer import png  # noqa: E402
from shapes import cube_sphere  # noqa: E402

WIDTH, HEIGHT = 24, 16
CAMERA = [[1, 0, 0, 0], [0, 0.97, -0.24, 0], [0, 0.24, 0.97, 0], [0, 1.6, 5, 1]]
KEY = [[0.8, 0, 0.6, 0], [-0.42, 0.71, 0.57, 0], [-0.43, -0.71, 0.57, 0], [-1.5, 2.4, 2, 1]]


def at(x, y, z, scale=1.0):
    return [[scale, 0, 0, 0], [0, scale, 0, 0], [0, 0, scale, 0], [x, y, z, 1]]


def set_ball(scene, path, place, **options):
    ball = cube_sphere(2, lambda d: d)
    scene.set_mesh(path, ball.points, ball.quads, **{"transform": place, "scheme": "catmullClark", "refine_level": 2, **options})


def small_scene(folder, report=None):
    """`folder` holds its image, which is read when the scene is first drawn."""
    image = pathlib.Path(folder) / "checks.png"
    if not image.exists():
        image.write_bytes(png(64, 64, lambda x, y: ((x // 2 + y // 2) % 2, 0.4, 0.3)))
    scene = hdalabaster.Scene(report=report)
    scene.set_camera("/camera", CAMERA, focalLength=0.05, horizontalAperture=0.036, verticalAperture=0.024)
    scene.set_light("/key", "rectLight", KEY, width=0.6, height=0.6, intensity=20)
    scene.set_light("/sky", "domeLight", intensity=0.3)
    scene.set_material("/wax", baseColor=(0.9, 0.6, 0.4), scatterDistance=(0.4, 0.2, 0.1))
    scene.set_material("/glass", roughness=0.05, specTrans=1.0, baseColor=(0.95, 0.98, 0.95))
    scene.set_material("/metal", metallic=1.0, roughness=0.35, baseColor=(0.9, 0.8, 0.6))
    scene.set_material("/floor", nodes={"surface": {"baseColor": ("image", "rgb"), "roughness": 0.8, "sheen": 1.0, "sheenRoughness": 0.6},
                                        "image": {"type": "AlabasterTexture", "file": str(image)}})
    set_ball(scene, "/wax_ball", at(-1.2, 0.5, 0, 0.5), material="/wax")
    set_ball(scene, "/glass_ball", at(0, 0.5, 0.2, 0.5), material="/glass")
    set_ball(scene, "/metal_ball", at(1.2, 0.5, 0, 0.5), material="/metal")
    scene.set_mesh("/ground", [(-3, 0, 2), (3, 0, 2), (3, 0, -3), (-3, 0, -3)], [[0, 1, 2, 3]], material="/floor",
                   primvars={"st": hdalabaster.Primvar([(0, 0), (4, 0), (4, 4), (0, 4)], role="textureCoordinate")})
    return scene


def draw(renderer, aovs=("color",), **frame):
    """{AOV: bytes} of a render that has ended."""
    render = renderer.render(**{"width": WIDTH, "height": HEIGHT, "camera": "/camera", "aovs": list(aovs), **frame})
    if render.state != "converged":
        raise RuntimeError(f"the render ended as {render.state}: {renderer.stats().get('error')}")
    return {aov: bytes(memoryview(render.pixels(aov))) for aov in aovs}
