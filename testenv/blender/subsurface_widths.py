"""How far light travels below a surface, in Cycles and here. Runs inside Blender (blender -b -P) or with the module bpy:
run_blender.py --widths starts it.

A shadow's straight edge falls on a half-space. The radiance on its dark side falls off as far as light scatters: the distance from
the edge where it is 25, 10, 3 and 1 % of the lit plateau, in radii, is the width at that level. And slabs are lit from behind.

Arguments: a JSON file with addon and module (folders), out (folder), cases (words that names of cases contain; none: all), samples,
columns, rows. Prints a line "WIDTH {json}" for each case and channel, and "VERSION x" at the end.
"""
import json
import pathlib
import sys

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE))

import bpy  # noqa: E402
import numpy  # noqa: E402

import render_scenes  # noqa: E402
import scenes  # noqa: E402

LEVELS = (0.25, 0.10, 0.03, 0.01)
COLOR = (0.8, 0.5, 0.2)  # an albedo for each channel
FAR = 400.0  # half the size of what stands for infinite, in half widths of the film
FIRST_LOOK = 2.5  # half width of the film in radii, before the width is known


def methods(owner, name):
    """The methods that this Blender offers."""
    return [item.identifier for item in owner.bl_rna.properties[name].enum_items]


def principled(method, anisotropy=0.0, scale=1.0, weight=1.0):
    """Radius 1 is the product of radius and scale, so that a scale that is not read shows."""
    material = scenes.principled("scatter", Base_Color=COLOR, Roughness=1.0, Subsurface=weight,
                                 Subsurface_Radius=(1.0 / scale,) * 3, Subsurface_Anisotropy=anisotropy)
    node = material.node_tree.nodes["Principled BSDF"]
    node.subsurface_method = method
    if scenes.MODERN:
        node.inputs["Subsurface Scale"].default_value = scale
    else:
        node.inputs["Subsurface Color"].default_value = (*COLOR, 1)
    return material


def scattering_node(method, anisotropy=0.0, scale=1.0, ior=1.4):
    material = bpy.data.materials.new("scatter")
    material.use_nodes = True
    nodes = material.node_tree.nodes
    nodes.clear()
    shader, output = nodes.new("ShaderNodeSubsurfaceScattering"), nodes.new("ShaderNodeOutputMaterial")
    shader.falloff = method
    for name, value in {"Color": (*COLOR, 1), "Radius": (1.0 / scale,) * 3, "Scale": scale, "Anisotropy": anisotropy,
                        "IOR": ior}.items():
        if name in shader.inputs:  # Blender hides those that a method has no use for
            shader.inputs[name].default_value = value
    material.node_tree.links.new(shader.outputs[0], output.inputs["Surface"])
    return material


def cases():
    """Makers of materials of radius 1, by name."""
    made = {}
    node = bpy.types.ShaderNodeBsdfPrincipled
    for method in methods(node, "subsurface_method"):
        made[f"Principled {method}"] = lambda m=method: principled(m)
    for method in methods(bpy.types.ShaderNodeSubsurfaceScattering, "falloff"):
        made[f"Subsurface Scattering {method}"] = lambda m=method: scattering_node(m)
    default = "RANDOM_WALK" if scenes.MODERN else "RANDOM_WALK_FIXED_RADIUS"
    skin = "RANDOM_WALK_SKIN" if scenes.MODERN else "RANDOM_WALK"
    if scenes.MODERN:
        made[f"Principled {default}, scale 0.25"] = lambda: principled(default, scale=0.25)
    made[f"Subsurface Scattering {default}, scale 0.25"] = lambda: scattering_node(default, scale=0.25)
    made[f"Subsurface Scattering {skin}, IOR 1.2"] = lambda: scattering_node(skin, ior=1.2)
    for method in methods(node, "subsurface_method"):
        if method != "BURLEY":
            made[f"Principled {method}, anisotropy 0.8"] = lambda m=method: principled(m, anisotropy=0.8)
    return made


def box(material, size, depth):
    """A box below z = 0."""
    points = [(x * size, y * size, (z - 1) * 0.5 * depth) for x, y, z in scenes.CUBE_POINTS]
    return scenes.mesh("body", points, scenes.CUBE_FACES, material)


def stage(make, half, depth, behind):
    """A parallel camera above z = 0 sees -half .. half of x. The sun comes from above and leaves x < 0 in shadow, or from below."""
    render_scenes.empty()
    far = FAR * half
    box(make(), far, depth)
    eye = scenes.camera((0, 0, half), (0, 0, 0))
    eye.rotation_euler = (0, 0, 0)
    eye.data.type, eye.data.ortho_scale = "ORTHO", 2 * half
    eye.data.clip_start, eye.data.clip_end = 0.01 * half, 100 * half
    # Along the edge, so that the edge stays at x = 0 and no reflection meets the camera.
    scenes.light("SUN", 3.0, (0, -half, -half if behind else half), (0, 0, 0), angle=0.0)
    if not behind:
        z = 2 * half
        scenes.mesh("shade", [(-far, -far, z), (0, -far, z), (0, far, z), (-far, far, z)], [(0, 1, 2, 3)], scenes.diffuse("black", (0, 0, 0)))


def profile(job, engine, name, samples):
    """Radiance by column, from x = -half to half."""
    pixels, _ = render_scenes.picture({**job, "width": job["columns"], "height": job["rows"], "samples": samples}, name, engine)
    return pixels[..., :3].astype(numpy.float64).mean(axis=0)


def widths(column, half):
    """For each channel, the distances from the edge where the dark side falls to the LEVELS; and the plateau."""
    count = len(column)
    x = (numpy.arange(count) + 0.5) / count * 2 * half - half
    plateau = column[int(0.9 * count):].mean(axis=0)
    found = []
    for channel in range(3):
        level = column[x < 0, channel][::-1] / plateau[channel]
        away = -x[x < 0][::-1]
        found.append([crossing(away, level, wanted) for wanted in LEVELS])
    return found, plateau


def crossing(away, level, wanted):
    """Where the level falls below `wanted`, between columns by its logarithm. None: beyond the film; 0: within the first column."""
    below = numpy.flatnonzero(level < wanted)
    if not len(below) or below[0] == 0:
        return 0.0 if len(below) else None
    i = below[0]
    high, low = numpy.log(max(level[i - 1], 1e-9)), numpy.log(max(level[i], 1e-9))
    share = (high - numpy.log(wanted)) / max(high - low, 1e-9)
    return float(away[i - 1] + share * (away[i] - away[i - 1]))


def fitting(job, make):
    """A half width of the film that holds the levels of every channel, found by a coarse look."""
    half = FIRST_LOOK
    for _ in range(6):
        stage(make, half, 2 * FAR * half, False)
        found, _ = widths(profile(job, "CYCLES", "look", max(job["samples"] // 8, 16)), half)
        tens = [one[1] for one in found]
        if None in tens:
            half *= 3
        elif max(tens) < 0.1 * half:
            half = max(6 * max(tens), 0.2 * half)
        else:
            return 5.5 * max(tens)
    return half


def measure(job, name, make):
    """A row for each channel: widths, plateau and light from behind, of both engines."""
    half = fitting(job, make)
    rows = [{"case": name, "channel": channel, "albedo": COLOR[channel], "half": half} for channel in range(3)]
    for engine in ("CYCLES", "ALABASTER"):
        stage(make, half, 2 * FAR * half, False)
        found, plateau = widths(profile(job, engine, "edge", job["samples"]), half)
        behind = []
        for thickness in (0.3 * half, 0.6 * half):
            stage(make, half, thickness, True)
            behind.append(profile(job, engine, "behind", max(job["samples"] // 16, 4)).mean(axis=0) / plateau)  # every pixel is alike
        for channel, row in enumerate(rows):
            row[engine] = {"widths": found[channel], "plateau": float(plateau[channel]), "behind": [float(one[channel]) for one in behind]}
    return rows


def main():
    arguments = sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else sys.argv[1:]
    job = json.loads(pathlib.Path(arguments[0]).read_text())
    sys.path[:0] = [job["addon"], job["module"]]
    render_scenes.empty()
    import alabaster_render
    alabaster_render.register()
    for name, make in cases().items():
        if not job["cases"] or any(word in name for word in job["cases"]):
            for row in measure(job, name, make):
                print("\nWIDTH " + json.dumps(row), flush=True)
    alabaster_render.unregister()
    print("\nVERSION " + bpy.app.version_string, flush=True)


if __name__ == "__main__":
    main()
