"""A scene of scenes.py in this renderer, by its Python module."""
import hdalabaster
import numpy as np

from scenes import APERTURE, EYE, FOCAL, Clear, Matt, Medium, Mirror

WHITE = {"baseColor": (1.0,) * 3, "specTrans": 1.0, "roughness": 0.0}


def material_of(look):
    if isinstance(look, Medium):
        # A white medium: eq. 2 and 3 of Chiang, Kutz, Burley 2016 with A = 1.
        distance = look.free_path / ((1.9 - 1 + 3.5 * 0.2 ** 2) * (1 - look.g))
        return {**WHITE, "scatterDistance": (distance,) * 3, "scatterAnisotropy": look.g, "ior": look.ior}
    if isinstance(look, Clear):
        return {**WHITE, "ior": look.ior, "attenuationColor": (float(np.exp(-look.absorption)),) * 3, "attenuationDistance": 1.0,
                "priority": look.priority}
    if isinstance(look, Mirror):
        return {"baseColor": (1.0,) * 3, "metallic": 1.0, "roughness": 0.0}
    return {"baseColor": look.color, "specular": 0.0, "roughness": 0.43, "emission": (look.emission,) * 3}


def scene_of(scene):
    made = hdalabaster.Scene()
    for name, thing in scene.things.items():
        made.set_material(f"/looks/{name}", **material_of(thing.look))
        given = {"transform": thing.place}
        if thing.copies:
            made.set_instancer(f"/{name}_copies", {f"/{name}": range(len(thing.copies))}, transforms=np.array(thing.copies), **given)
            given = {"instancer": f"/{name}_copies"}
        points, faces = thing.shape
        made.set_mesh(f"/{name}", np.float32(points), [np.int32(f) for f in faces], material=f"/looks/{name}", **given)
    if scene.sky:
        made.set_light("/sky", "domeLight", intensity=scene.sky, visibleToCamera=True)
    if scene.lamp:
        width, height, radiance = scene.lamp
        down = np.array([[1, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0, 2.5, 0, 1]], float)
        made.set_light("/lamp", "rectLight", down, width=width, height=height, intensity=radiance, visibleToCamera=True)
    camera = np.eye(4)
    camera[3, :3] = EYE
    return made, {"transform": camera, "focalLength": FOCAL, "horizontalAperture": APERTURE, "verticalAperture": APERTURE}
