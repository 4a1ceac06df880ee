"""Renders a neutral scene (neutral_scene.py) with Mitsuba 3, variant llvm_ad_rgb; arguments and output as in cycles_scene.py.

Mitsuba has no subsurface model of its own, so a body is a homogeneous medium (the same sigma_t and alpha) behind a boundary
that transmits diffusely both ways, which is our model without its Fresnel factors, retro-reflection and specular lobe.
"""
import json
import math
import pathlib
import resource
import struct
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))

import drjit as dr  # noqa: E402
import mitsuba as mi  # noqa: E402

mi.set_variant("llvm_ad_rgb")

import formulas  # noqa: E402
import neutral_scene  # noqa: E402

SAMPLES_AT_ONCE = 8  # bounds the memory of the wavefront


class DiffuseTransmitter(mi.BSDF):
    """All light crosses the boundary, cosine-distributed on the other side."""

    def __init__(self, props):
        mi.BSDF.__init__(self, props)
        self.m_components = [mi.BSDFFlags.DiffuseTransmission | mi.BSDFFlags.FrontSide | mi.BSDFFlags.BackSide]
        self.m_flags = self.m_components[0]

    def sample(self, ctx, si, sample1, sample2, active):
        wo = mi.warp.square_to_cosine_hemisphere(sample2)
        result = mi.BSDFSample3f()
        result.pdf = mi.warp.square_to_cosine_hemisphere_pdf(wo)
        result.wo = dr.select(mi.Frame3f.cos_theta(si.wi) > 0, -wo, wo)
        result.eta = 1.0
        result.sampled_type = mi.UInt32(int(mi.BSDFFlags.DiffuseTransmission))
        result.sampled_component = mi.UInt32(0)
        return result, mi.Color3f(1.0) & (active & (result.pdf > 0))

    def eval(self, ctx, si, wo, active):
        return mi.Color3f(self.pdf(ctx, si, wo, active))

    def pdf(self, ctx, si, wo, active):
        crosses = mi.Frame3f.cos_theta(si.wi) * mi.Frame3f.cos_theta(wo) < 0
        return dr.select(active & crosses, dr.abs(mi.Frame3f.cos_theta(wo)) * dr.inv_pi, 0)

    def eval_pdf(self, ctx, si, wo, active):
        pdf = self.pdf(ctx, si, wo, active)
        return mi.Color3f(pdf), pdf

    def to_string(self):
        return "DiffuseTransmitter[]"


mi.register_bsdf("diffusetransmitter", DiffuseTransmitter)


def rgb(values):
    return {"type": "rgb", "value": list(values)}


def material_of(disney):
    """Entries of a shape."""
    if disney.get("specTrans", 0) > 0:
        raise neutral_scene.Unsupported("glass")
    distances = disney.get("scatterDistance", [0, 0, 0])
    if max(distances) > 0:
        color = disney["baseColor"]
        sigma_t = [1 / formulas.mean_free_path(a, d) for a, d in zip(color, distances)]
        largest = max(sigma_t)
        medium = {"type": "homogeneous", "sigma_t": rgb([s / largest for s in sigma_t]), "scale": largest,
                  "albedo": rgb(map(formulas.exact_alpha, color)), "has_spectral_extinction": len(set(sigma_t)) > 1}
        return {"bsdf": {"type": "diffusetransmitter"}, "interior": medium}
    bsdf = {"type": "principled", "base_color": rgb(disney["baseColor"]), "roughness": disney["roughness"],
            "metallic": disney["metallic"], "specular": max(formulas.f0_from_ior(disney["ior"]) / 0.08, 1e-3),
            "clearcoat": disney.get("clearcoat", 0.0), "clearcoat_gloss": disney.get("clearcoatGloss", 1.0),
            "sheen": disney.get("sheen", 0.0), "sheen_tint": disney.get("sheenTint", 0.5)}
    return {"bsdf": {"type": "twosided", "nested": bsdf}}


def write_ply(path, glb, primitive):
    points, normals = (glb.accessor(primitive["attributes"][key]) for key in ("POSITION", "NORMAL"))
    indices = glb.accessor(primitive["indices"])
    header = "ply\nformat binary_little_endian 1.0\nelement vertex %d\n" % len(points)
    header += "".join(f"property float {name}\n" for name in ("x", "y", "z", "nx", "ny", "nz"))
    header += "element face %d\nproperty list uchar int vertex_indices\nend_header\n" % (len(indices) // 3)
    with open(path, "wb") as out:
        out.write(header.encode())
        out.write(b"".join(struct.pack("<6f", *p, *n) for p, n in zip(points, normals)))
        out.write(b"".join(struct.pack("<B3i", 3, *indices[i:i + 3]) for i in range(0, len(indices), 3)))


def make_shapes(folder, work):
    glb = neutral_scene.Glb(folder / "scene.glb")
    shapes = {}
    for i, entry in enumerate(glb.json["meshes"]):
        primitive, file = entry["primitives"][0], work / f"mesh{i}.ply"
        write_ply(file, glb, primitive)
        disney = glb.json["materials"][primitive["material"]]["extensions"]["ALAB_materials_disney"]
        shapes[f"mesh{i}"] = {"type": "ply", "filename": str(file), **material_of(disney)}
    return shapes


def make_light(light):
    radiance = rgb([light.get("intensity", 1) * c for c in light.get("color", [1, 1, 1])])
    if light["type"] == "domeLight":
        if light.get("texture:file"):
            raise neutral_scene.Unsupported("a dome with a texture")
        return {"type": "constant", "radiance": radiance}
    emitter = {"emitter": {"type": "area", "radiance": radiance}, "bsdf": {"type": "null"}}
    position = light.get("position", [0, 0, 0])
    if light["type"] == "sphereLight":
        return {"type": "sphere", "center": position, "radius": light.get("radius", 0.5), **emitter}
    below = [position[0], position[1], position[2] - 1]
    x, y, z = formulas.look_at(position, light.get("target", below), light.get("up", [0, 1, 0]))
    u, v = [0.5 * light.get("width", 1) * c for c in x], [-0.5 * light.get("height", 1) * c for c in y]
    matrix = [[u[i], v[i], -z[i], position[i]] for i in range(3)] + [[0, 0, 0, 1]]
    return {"type": "rectangle", "to_world": mi.ScalarTransform4f(matrix), **emitter}


def make_scene(job, work):
    folder = pathlib.Path(job["scene"])
    description = json.loads((folder / "scene.json").read_text())
    camera, look = description["camera"], description["camera"]["lookAt"]
    slope = 0.5 * camera.get("verticalAperture", 24) / camera.get("focalLength", 50)
    sensor = {"type": "perspective", "fov": math.degrees(2 * math.atan(slope)), "fov_axis": "y",
              "near_clip": 1e-4, "far_clip": 1e4,
              "to_world": mi.ScalarTransform4f().look_at(look["eye"], look["target"], look.get("up", [0, 1, 0])),
              "film": {"type": "hdrfilm", "width": job["width"], "height": job["height"], "pixel_format": "rgb",
                       "component_format": "float32", "rfilter": {"type": "box"}}}
    if camera.get("fStop", 0) > 0:
        sensor.update(type="thinlens", aperture_radius=camera["focalLength"] * 1e-3 / (2 * camera["fStop"]),
                      focus_distance=camera["focusDistance"])
    seen = any(light.get("visibleToCamera") for light in description["lights"])
    scatters = "homogeneous" in str(shapes := make_shapes(folder, work))
    integrator = ({"type": "volpathmis", "max_depth": -1, "hide_emitters": not seen} if scatters else
                  {"type": "path", "max_depth": description["settings"]["maxDepth"] + 1, "hide_emitters": not seen})
    lights = {f"light{i}": make_light(light) for i, light in enumerate(description["lights"])}
    return mi.load_dict({"type": "scene", "integrator": integrator, "sensor": sensor, **shapes, **lights})


def render(scene, task):
    before = resource.getrusage(resource.RUSAGE_SELF)
    total, left, part = None, task["samples"], 0
    while left > 0:
        n = min(left, SAMPLES_AT_ONCE)
        image = n * mi.render(scene, spp=n, seed=(task["seed"] << 12) + part)
        total = image if total is None else total + image
        dr.eval(total)
        left, part = left - n, part + 1
    total /= task["samples"]
    dr.sync_thread()
    after = resource.getrusage(resource.RUSAGE_SELF)
    mi.Bitmap(total).write(task["output"])
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def main():
    job = json.loads(pathlib.Path(sys.argv[1]).read_text())
    with tempfile.TemporaryDirectory() as folder:
        scene = make_scene(job, pathlib.Path(folder))
    print("\nPEER " + json.dumps({"version": mi.__version__, "cpuSeconds": [render(scene, task) for task in job["renders"]]}))


main()
