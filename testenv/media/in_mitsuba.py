"""A scene of scenes.py in Mitsuba 3 (PyPI: mitsuba): volpath, walls that are null or smooth dielectrics."""
import math
import pathlib
import tempfile

import drjit
import mitsuba as mi
import numpy as np

mi.set_variant("scalar_rgb")

from scenes import APERTURE, EYE, FOCAL, PIXELS, Clear, Matt, Medium, Mirror  # noqa: E402


def rgb(values):
    return {"type": "rgb", "value": [float(v) for v in values]}


def medium_of(look):
    """What is on the inner side of a wall, or None."""
    if isinstance(look, Medium):
        phase = {"type": "hg", "g": look.g} if look.g else {"type": "isotropic"}
        return {"type": "homogeneous", "albedo": rgb((1, 1, 1)), "sigma_t": 1 / look.free_path, "phase": phase}
    if isinstance(look, Clear) and look.absorption:
        return {"type": "homogeneous", "albedo": rgb((0, 0, 0)), "sigma_t": look.absorption}
    return None


def index_of(look):
    return look.ior if isinstance(look, (Medium, Clear)) else 1.0


def surface_of(look, outer):
    if isinstance(look, Matt):
        # Disney's diffuse of 2015, as ours; its dielectric lobe nearly without reflectance.
        matt = {"type": "principled", "base_color": rgb(look.color), "roughness": 0.43, "specular": 1e-3} if any(look.color) else \
               {"type": "diffuse", "reflectance": rgb((0, 0, 0))}
        return {"type": "twosided", "nested": matt}
    if isinstance(look, Mirror):
        return {"type": "twosided", "nested": {"type": "conductor", "material": "none"}}
    inner = index_of(look)
    return {"type": "null"} if inner == outer else {"type": "dielectric", "int_ior": inner, "ext_ior": outer}


def baked(points, place):
    return (np.c_[points, np.ones(len(points))] @ place)[:, :3]


def write_ply(path, points, faces):
    triangles = [(f[0], f[k], f[k + 1]) for f in faces for k in range(1, len(f) - 1)]
    header = f"ply\nformat ascii 1.0\nelement vertex {len(points)}\n" + "".join(f"property float {c}\n" for c in "xyz")
    header += f"element face {len(triangles)}\nproperty list uchar int vertex_indices\nend_header\n"
    with open(path, "w") as out:
        out.write(header)
        out.writelines("%.9g %.9g %.9g\n" % tuple(p) for p in points)
        out.writelines("3 %d %d %d\n" % t for t in triangles)


def shapes_of(thing, media, looks, folder, name):
    points, faces = thing.shape
    if thing.copies:
        n = len(points)
        faces = [tuple(n * i + c for c in f) for i in range(len(thing.copies)) for f in faces]
        points = np.concatenate([baked(points, m) for m in thing.copies])
    for k, (shape, around) in enumerate(thing.walls or (((points, faces), thing.within),)):
        file = folder / f"{name}{k}.ply"
        write_ply(file, baked(shape[0], thing.place), shape[1])
        found = {"type": "ply", "filename": str(file), "face_normals": True,
                 "bsdf": surface_of(thing.look, index_of(looks.get(around)))}
        if isinstance(thing.look, Matt) and thing.look.emission:
            found["emitter"] = {"type": "area", "radiance": rgb([thing.look.emission] * 3)}
        if isinstance(thing.look, (Medium, Clear)):
            for side, of in (("interior", name), ("exterior", around)):
                if media.get(of):
                    found[side] = media[of]
        yield f"{name}{k}", found


def scene_of(scene, folder):
    looks = {name: thing.look for name, thing in scene.things.items()}
    media = {name: mi.load_dict(m) for name, look in looks.items() if (m := medium_of(look))}
    found = {"type": "scene", "integrator": {"type": "volpath", "max_depth": -1, "rr_depth": 1000},
             "sensor": {"type": "perspective", "fov": 2 * math.degrees(math.atan(0.5 * APERTURE / FOCAL)), "fov_axis": "x",
                        "to_world": mi.ScalarTransform4f().look_at(list(EYE), [0, 0, 0], [0, 1, 0]),
                        "film": {"type": "hdrfilm", "width": PIXELS, "height": PIXELS, "rfilter": {"type": "box"}},
                        "sampler": {"type": "independent"}}}
    if scene.sky:
        found["sky"] = {"type": "constant", "radiance": rgb([scene.sky] * 3)}
    if scene.lamp:
        width, height, radiance = scene.lamp
        down = mi.ScalarTransform4f().look_at([0, 2.5, 0], [0, 0, 0], [0, 0, 1]) @ mi.ScalarTransform4f().scale([width / 2, height / 2, 1])
        found["lamp"] = {"type": "rectangle", "to_world": down, "emitter": {"type": "area", "radiance": rgb([radiance] * 3)}}
    for name, thing in scene.things.items():
        found.update(shapes_of(thing, media, looks, folder, name))
    return mi.load_dict(found)


def pictures(scene, samples):
    """One after the other, by seed."""
    drjit.set_thread_count(1)
    with tempfile.TemporaryDirectory() as folder:
        loaded = scene_of(scene, pathlib.Path(folder))
    seed = 0
    while True:
        yield np.array(mi.render(loaded, spp=samples, seed=seed), float)[..., :3]
        seed += 1
