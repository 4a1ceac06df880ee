"""Every pass of one scene of Blender, ours beside Cycles 5.0.1's, as a labelled sheet: pass_sheet.py BUILD.

Both render the scene in Blender's Python: ours what the add-on makes of it, for a pass what its row in PASSES says. Under each
pair stand the means of both and the RMS difference of blocks of 8 x 8 pixels over the mean of Cycles. Windows of the sheet are shown
at 400 per cent: edges of ids without and with motion blur and lens, motion, and the floor as a shadow catcher. AOVs that this build
lacks are left out, and named.
"""
import argparse
import json
import pathlib
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[2]
FONT = "/usr/share/fonts/truetype/dejavu/DejaVuSans.ttf"
GROUPS = ["warm", "screens", "sky"]
MOST_LETTERS = 72  # of a label
FAR = 1e9  # Cycles' depth where there is nothing is 1e10

# Our pass, Cycles' by an expression of its passes (1 is white), and how both are shown. A sum of ours is written with +. The scene
# is drawn sharp, blurred by motion and lens, and with a floor that catches shadows before nothing.
SHARP, BLURRED, CAUGHT = "", ", motion blur and lens", ", on a floor that is a shadow catcher"
PASSES = [
    ("color", "Combined", "light"), ("alpha", "Alpha", "number"),
    ("directDiffuse+directSubsurface", "Diffuse Direct*Diffuse Color", "light"), ("indirectDiffuse+indirectSubsurface", "Diffuse Indirect*Diffuse Color", "light"),
    ("directSpecular", "Glossy Direct*Glossy Color", "light"), ("indirectSpecular", "Glossy Indirect*Glossy Color", "light"),
    ("transmission", "Transmission Direct*Transmission Color+Transmission Indirect*Transmission Color", "light"), ("emission", "Emission+Environment", "light"),
    ("directSubsurface", "", "light"), ("indirectSubsurface", "", "light"), ("subsurfaceSingle", "", "light"),
    ("subsurfaceMultiple", "", "light"), ("subsurfaceUnscattered", "", "light"),
    *((f"lightGroup:{name}", f"Combined_{name}", "light") for name in GROUPS), ("lightGroup:", "Combined-" + "-".join(f"Combined_{name}" for name in GROUPS), "light"),
    ("albedo", "Denoising Albedo", "light"), ("normal", "Normal", "signed"), ("cameraDepth", "Depth", "distance"),
    ("position", "Position", "signed"), ("uv", "UV", "signed"), ("motion", "-Vector", "motion"), ("Peye", "", "signed"), ("Neye", "", "signed"),
    ("ambientOcclusion", "Ambient Occlusion", "number"),
    ("primId", "Object Index", "id"), ("materialId", "Material Index", "id"), ("instanceId", "", "id"), ("elementId", "", "id"),
    ("cryptoObject", "CryptoObject", "crypto"), ("cryptoMaterial", "CryptoMaterial", "crypto"), ("cryptoAsset", "CryptoAsset", "crypto"),
    ("sampleCount", "", "number"), ("error", "", "number"), ("denoised", "", "light"),
]
BLURRED_PASSES = [one for one in PASSES if one[0] in ("color", "cryptoObject", "cryptoMaterial")]
CAUGHT_PASSES = [("color", "Combined", "light"), ("alpha", "Alpha", "number"), ("shadow", "1-Shadow Catcher", "light")]
# Of those rows, at 400 per cent: the row, the window's middle in parts of the picture, and what is blurred.
CLOSE = [("cryptoObject", (0.36, 0.47), SHARP), ("cryptoMaterial", (0.36, 0.47), SHARP), ("cryptoObject", (0.79, 0.6), BLURRED),
         ("color", (0.79, 0.6), BLURRED), ("motion", (0.79, 0.6), SHARP), ("primId", (0.36, 0.47), SHARP),
         ("shadow", (0.45, 0.8), CAUGHT), ("alpha", (0.45, 0.8), CAUGHT)]


# In Blender's Python ---------------------------------------------------------------------------------
def make_scene(job, how):
    """A wax ball, a metal one and a glass one, an image on the floor, a cube that moves, a glowing screen, two lamps, a sky."""
    import bpy
    import scenes

    bpy.ops.wm.read_factory_settings(use_empty=True)
    scene, layer = bpy.context.scene, bpy.context.view_layer
    tiles = scenes.picture("tiles", 64, 64, lambda u, v: (0.7, 0.6, 0.5) if (int(u * 8) + int(v * 8)) % 2 else (0.2, 0.25, 0.3))
    floor = scenes.floor(scenes.principled("floor", Roughness=0.6, Specular=0.3))
    nodes = floor.data.materials[0].node_tree
    texture = nodes.nodes.new("ShaderNodeTexImage")
    texture.image = tiles
    nodes.links.new(texture.outputs["Color"], next(n for n in nodes.nodes if n.type == "BSDF_PRINCIPLED").inputs["Base Color"])
    uv = floor.data.uv_layers.new(name="UVMap")
    for loop, place in zip(uv.data, ((0, 0), (1, 0), (1, 1), (0, 1))):
        loop.uv = place
    wax = scenes.ball(scenes.principled("wax", Base_Color=(0.85, 0.6, 0.4), Subsurface=1.0, Subsurface_Radius=(0.3, 0.15, 0.08), Roughness=0.35,
                                        Specular=0.5), (-1.0, 0, 0.8), 0.8, name="wax ball")
    metal = scenes.ball(scenes.principled("metal", Base_Color=(0.9, 0.8, 0.5), Metallic=1.0, Roughness=0.25, Specular=0.5), (0.55, 0.5, 0.6), 0.6, name="metal ball")
    glass = scenes.ball(scenes.principled("glass", Base_Color=(1.0, 1.0, 1.0), Transmission=1.0, IOR=1.45, Roughness=0.0, Specular=0.5), (0.15, -1.1, 0.4), 0.4,
                        name="glass ball")
    cube = scenes.mesh("cube", [(0.35 * x, 0.35 * y, 0.35 * z) for x, y, z in scenes.CUBE_POINTS], scenes.CUBE_FACES,
                       scenes.principled("paint", Base_Color=(0.1, 0.3, 0.7), Roughness=0.5, Specular=0.5), (1.6, -0.4, 0.5))
    for frame, place in ((0, 1.2), (2, 2.0)):
        cube.location.x = place
        cube.rotation_euler.z = 0.4 * frame
        cube.keyframe_insert("location", frame=frame)
        cube.keyframe_insert("rotation_euler", frame=frame)
    screen = scenes.mesh("screen", [(-0.7, 0, -0.4), (0.7, 0, -0.4), (0.7, 0, 0.4), (-0.7, 0, 0.4)], [(0, 1, 2, 3)], glow(scenes), (-0.9, 2.2, 1.6))
    screen.lightgroup = "screens"
    group = bpy.data.objects.new("table ware", None)
    scene.collection.objects.link(group)
    metal.parent = glass.parent = group
    lamp = scenes.light("AREA", 120, (-2.5, -2.5, 3.5), (0, 0, 0.5), size=0.8, color=(1, 0.75, 0.5))
    lamp.lightgroup = "warm"
    scenes.light("POINT", 40, (3, -1.5, 2.5), shadow_soft_size=0.2, color=(0.6, 1, 0.7))
    world, _ = scenes.sky((0.5, 0.65, 1.0), 0.35)
    world.lightgroup = "sky"
    for name in GROUPS:
        layer.lightgroups.add(name=name)
    eye = scenes.camera((0.2, -5.2, 2.3), (0.25, 0, 0.7), 42)
    blurred = how == BLURRED
    floor.is_shadow_catcher = scene.render.film_transparent = how == CAUGHT
    if blurred:
        eye.data.dof.use_dof, eye.data.dof.focus_distance, eye.data.dof.aperture_fstop = True, 5.0, 1.4
    for number, ob in enumerate((floor, wax, metal, glass, cube, screen), 1):
        ob.pass_index = number
        ob.data.materials[0].pass_index = number
    scene.frame_set(1)
    view = scene.render
    view.use_motion_blur, view.motion_blur_shutter = blurred, 1.0
    view.resolution_x, view.resolution_y, view.resolution_percentage = job["width"], job["height"], 100
    scene.alabaster.samples, scene.alabaster.filter, scene.alabaster.maxDepth = job["samples"], "box", 8
    return scene, layer


def glow(scenes):
    material = scenes.diffuse("glow")
    tree = material.node_tree
    shader = tree.nodes.new("ShaderNodeEmission")
    shader.inputs["Color"].default_value, shader.inputs["Strength"].default_value = (0.2, 0.5, 1, 1), 3.0
    tree.links.new(shader.outputs[0], next(n for n in tree.nodes if n.type == "OUTPUT_MATERIAL").inputs["Surface"])
    return material


def of_cycles(job, scene, layer, how):
    """Each pass by name: an array (height, width, channels), rows from the top."""
    import bpy

    scene.render.engine = "CYCLES"
    cycles = scene.cycles
    cycles.device, cycles.samples, cycles.use_denoising, cycles.use_adaptive_sampling = "CPU", job["samples"], False, False
    cycles.pixel_filter_type = "BOX"
    cycles.sample_clamp_direct = cycles.sample_clamp_indirect = cycles.blur_glossy = 0.0
    cycles.max_bounces = cycles.diffuse_bounces = cycles.glossy_bounces = cycles.transmission_bounces = 8
    for name in ("z", "normal", "position", "uv", "object_index", "material_index", "emit", "environment", "ambient_occlusion",
                 *(f"{kind}_{part}" for kind in ("diffuse", "glossy", "transmission") for part in ("direct", "indirect", "color")),
                 "cryptomatte_object", "cryptomatte_material", "cryptomatte_asset"):
        setattr(layer, "use_pass_" + name, True)
    layer.use_pass_vector = how != BLURRED
    layer.cycles.denoising_store_passes = layer.cycles.use_pass_shadow_catcher = True
    settings = scene.render.image_settings
    if hasattr(settings, "media_type"):
        settings.media_type = "MULTI_LAYER_IMAGE"
    settings.file_format, settings.color_depth, settings.exr_codec = "OPEN_EXR_MULTILAYER", "32", "ZIP"
    if hasattr(settings, "use_exr_interleave"):
        settings.use_exr_interleave = True
    file = scene.render.filepath = f"{job['work']}/cycles{(SHARP, BLURRED, CAUGHT).index(how)}.exr"
    bpy.ops.render.render(write_still=True)
    return layers_of(job, file)


def layers_of(job, file):
    """The layers of an EXR, rows from the top."""
    import numpy
    from pictures import read_layers

    by_layer = {}
    for name, numbers in read_layers(file).items():
        layer, _, letter = name.removeprefix("ViewLayer.").rpartition(".")
        by_layer.setdefault(layer, {})[letter.upper()] = numpy.array(numbers, numpy.float32).reshape(job["height"], job["width"])
    order = "RXUGYVBZAW"
    found = {layer: numpy.stack([planes[letter] for letter in sorted(planes, key=order.find)], -1) for layer, planes in by_layer.items()}
    found["Alpha"], found["Combined"] = found["Combined"][..., 3:], found["Combined"][..., :3]
    found["1"] = numpy.ones_like(found["Combined"])
    if "Vector" in found:  # the frame before less this one, and this one less the next
        found["Vector"] = found["Vector"][..., 2:]
    return found


def of_ours(job, scene, how, names):
    """The same of our AOVs; those that this build lacks are left out."""
    import bpy
    import hdalabaster
    import numpy
    from alabaster_render import engine, motion, settings, sync

    scene.render.engine = "ALABASTER"
    depsgraph = bpy.context.evaluated_depsgraph_get()
    held = hdalabaster.Scene(report=lambda *told: print("ours:", *told))
    exporter = sync.SceneSync(held, False, lambda text: print("note:", text))
    shutter = motion.Shutter(depsgraph.scene_eval, how != BLURRED)  # as for pass Vector
    motion.sample(types_of_engine(scene), depsgraph, shutter, exporter)
    exporter.sync(depsgraph)
    frame = engine.AlabasterRenderEngine.frame_of(types_of_engine(scene), depsgraph, shutter, exporter)
    renderer = hdalabaster.Renderer(held, report=lambda *told: print("ours:", *told), **settings.delegate_settings(scene, False))
    wanted = sorted({one for name in names for one in name.split("+")})
    found, absent = {}, []
    for aov in list(wanted):
        try:
            renderer.start(aovs=["color", aov], **frame)
        except hdalabaster.Error as error:
            absent.append(f"{aov}: {str(error).splitlines()[0]}")
            wanted.remove(aov)
    render = renderer.render(aovs=["color", *(one for one in wanted if one != "color")], **frame)
    for aov in wanted:
        pixels = numpy.array(render[aov].numpy(), numpy.float32 if "Id" not in aov else None)
        found[aov] = pixels.reshape(pixels.shape[0], pixels.shape[1], -1).copy()
    found["color"] = found["color"][..., :3]
    return found, absent


def types_of_engine(scene):
    """What the add-on's engine is to motion.sample and frame_of: it sets the frame."""
    import types

    return types.SimpleNamespace(frame_set=lambda frame, subframe: scene.frame_set(frame, subframe=subframe))


def value_of(expression, layers):
    """Sums, differences and products of layers; None where one of them is missing."""
    import re

    import numpy

    total, sign = None, 1
    for part in re.split(r"([+-])", expression):
        if part in "+-":
            sign = 1 if part == "+" else -1
            continue
        factors = [layers.get(name) for name in part.split("*")]
        if any(one is None for one in factors):
            return None
        least = min(one.shape[-1] for one in factors)
        product = numpy.prod([one[..., :least] for one in factors], axis=0)
        total = sign * product if total is None else total + sign * product
    return total


def shown(pixels, how, scale, first):
    """As 8 bits of sRGB. first: the least number of an id."""
    import numpy

    height, width = pixels.shape[:2]
    if how == "light":
        return encoded(numpy.clip(pixels[..., :3], 0, None))
    if how == "crypto":
        out = numpy.zeros((height, width, 3))
        for rank in range(pixels.shape[-1] // 2):
            ids, coverage = numpy.ascontiguousarray(pixels[..., 2 * rank], numpy.float32).view(numpy.uint32), pixels[..., 2 * rank + 1:2 * rank + 2]
            out += coverage * of_ids(ids)
        return out
    if how == "id":
        return of_ids(pixels[..., 0].astype(numpy.int64) + 7 - first) * (pixels[..., :1] >= first)
    if how == "number":
        return numpy.repeat(numpy.clip(pixels[..., :1] / scale, 0, 1), 3, -1)
    if how == "distance":
        near = numpy.where((pixels[..., :1] > 0) & (pixels[..., :1] < FAR), 1 - pixels[..., :1] / scale, 0)
        return numpy.repeat(numpy.clip(near, 0, 1), 3, -1)
    signed = numpy.zeros((height, width, 3))
    count = 2 if how == "motion" else min(3, pixels.shape[-1])
    signed[..., :count] = pixels[..., :count] / scale
    return numpy.clip(0.5 + 0.5 * signed, 0, 1)


def encoded(linear):
    import numpy

    return numpy.clip(numpy.where(linear <= 0.0031308, 12.92 * linear, 1.055 * numpy.power(numpy.maximum(linear, 0.0031308), 1 / 2.4) - 0.055), 0, 1)


def of_ids(ids):
    """A colour for each number."""
    import numpy

    mixed = (ids.astype(numpy.uint64) * numpy.uint64(2654435761)) % numpy.uint64(1 << 32)
    return numpy.stack([((mixed >> numpy.uint64(shift)) % numpy.uint64(200) + numpy.uint64(40)) / 255.0 for shift in (3, 11, 19)], -1) * (ids != 0)[..., None]


def scale_of(how, pictures):
    import numpy

    one = [p[numpy.isfinite(p) & (numpy.abs(p) < FAR)] for p in pictures]
    return max(1e-6, *(float(numpy.percentile(numpy.abs(values), 99.5)) for values in one if values.size)) if how not in ("light", "crypto", "id") else 1


def words_of(how, ours, theirs):
    """What stands under a pair."""
    import numpy

    if theirs is None:
        return "no counterpart"
    if how in ("id", "crypto"):
        return f"{parts_of(how, ours, 0)} and {parts_of(how, theirs, 1)} names"
    least = min(ours.shape[-1], theirs.shape[-1]) if how != "motion" else 2
    a, b = (numpy.where(numpy.abs(p[..., :least]) < FAR, p[..., :least], 0).astype(float) for p in (ours, theirs))
    height, width = (n // 8 * 8 for n in a.shape[:2])
    blocks = [p[:height, :width].reshape(height // 8, 8, width // 8, 8, -1).mean(axis=(1, 3)) for p in (a, b)]
    off = numpy.sqrt(((blocks[0] - blocks[1]) ** 2).mean()) / max(1e-9, numpy.abs(blocks[1]).mean())
    return f"{a.mean():.4g} and {b.mean():.4g}, blocks {100 * off:.1f} %"


def parts_of(how, pixels, first):
    """Our numbers begin with 0, Cycles' with 1."""
    import numpy

    return len(numpy.unique(pixels[..., 0][pixels[..., 0] >= first if how == "id" else pixels[..., 0] != 0]))


def cropped(pixels, middle, width):
    """A window at 400 per cent, its pixels as squares."""
    import numpy

    side_x, side_y = width // 4, pixels.shape[0] * width // pixels.shape[1] // 4
    left = min(max(int(middle[0] * pixels.shape[1]) - side_x // 2, 0), pixels.shape[1] - side_x)
    top = min(max(int(middle[1] * pixels.shape[0]) - side_y // 2, 0), pixels.shape[0] - side_y)
    return numpy.repeat(numpy.repeat(pixels[top:top + side_y, left:left + side_x], 4, 0), 4, 1)


def write_picture(file, pixels):
    import numpy

    if pixels is None:
        return None
    with open(file, "wb") as out:
        out.write(b"P6 %d %d 255\n" % (pixels.shape[1], pixels.shape[0]))
        out.write((numpy.clip(pixels, 0, 1) * 255 + 0.5).astype(numpy.uint8).tobytes())
    return file


def in_blender(job):
    sys.path[:0] = [str(ROOT / part) for part in ("testenv/blender", "testenv/statistical/calibration", "delegate/blender")] + [job["module"]]
    import bpy
    import numpy

    import alabaster_render

    alabaster_render.register()
    rows, pairs, absent = [], {}, []
    for how, passes in ((SHARP, PASSES), (BLURRED, BLURRED_PASSES), (CAUGHT, CAUGHT_PASSES)):
        scene, layer = make_scene(job, how)
        theirs = of_cycles(job, scene, layer, how)
        scene, layer = make_scene(job, how)
        ours, absent_now = of_ours(job, scene, how, [name for name, *_ in passes])
        absent += absent_now
        for kind in ("CryptoObject", "CryptoMaterial", "CryptoAsset"):
            ranks = [theirs[f"{kind}{rank:02}"] for rank in range(3) if f"{kind}{rank:02}" in theirs]
            if ranks:
                theirs[kind] = numpy.concatenate(ranks, -1)
        for name, expression, kind in passes:
            one, other = value_of(name, ours), value_of(expression, theirs) if expression else None
            if one is None:
                continue
            scale = scale_of(kind, [p for p in (one, other) if p is not None])
            pairs[name, how] = [shown(p, kind, scale, first) if p is not None else None for first, p in enumerate((one, other))]
            if how == BLURRED:
                continue
            rows.append({"label": name + (f"  |  {expression}" if expression else "") + how, "words": words_of(kind, one, other), "files": [
                write_picture(f"{job['work']}/pass{len(rows)}_{side}.ppm", p) for side, p in enumerate(pairs[name, how])]})
            print(f"{name:38} {rows[-1]['words']}")
    for name, middle, how in CLOSE:
        if (name, how) in pairs:
            files = [write_picture(f"{job['work']}/close{len(rows)}_{side}.ppm", cropped(p, middle, job["width"])) if p is not None else None
                     for side, p in enumerate(pairs[name, how])]
            rows.append({"label": f"{name} at 400 %{how}", "words": "", "files": files})
    print("\nPEER " + json.dumps({"cpuSeconds": [0], "version": bpy.app.version_string, "rows": rows, "absent": absent}), flush=True)


# Outside ---------------------------------------------------------------------------------------------
def write_sheet(rows, width, height, version, file):
    """Three pairs a row, ours on the left of each."""
    caption, pad, columns = 34, 8, 3
    cell_width, cell_height = 2 * width + pad + 2, height + caption + pad
    lines = -(-len(rows) // columns)
    words = ["oiiotool", "--create", f"{columns * cell_width + pad}x{lines * cell_height + 30}", "3", "--fill:color=0.1,0.1,0.1",
             f"{columns * cell_width + pad}x{lines * cell_height + 30}"]
    text = lambda x, y, size, said: [f"--text:x={x}:y={y}:size={size}:font={FONT}:color=0.9,0.9,0.9", said]
    words += text(pad, 20, 15, f"Each pair: ours on the left, Cycles {version} on the right. Numbers: both means; RMS difference of blocks of 8 x 8 pixels over Cycles' mean.")
    for number, row in enumerate(rows):
        x, y = pad + number % columns * cell_width, 30 + number // columns * cell_height
        label = row["label"] if len(row["label"]) <= MOST_LETTERS else row["label"][:MOST_LETTERS - 3] + "..."
        words += text(x, y + 13, 12, label) + text(x, y + 28, 11, row["words"])
        for side, picture in enumerate(row["files"]):
            if picture:
                words += [picture, "--swap", "--paste", f"+{x + side * (width + 2)}+{y + caption}"]
    subprocess.run([*words, "--compression", "jpeg:88", "--nosoftwareattrib", "--eraseattrib", ".*", "-o", file], check=True)


def main():
    if len(sys.argv) == 2 and sys.argv[1].endswith(".job.json"):
        return in_blender(json.loads(pathlib.Path(sys.argv[1]).read_text()))
    import peers

    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("build", type=pathlib.Path)
    parser.add_argument("--size", default="240x160")
    parser.add_argument("--samples", type=int, default=128)
    parser.add_argument("--work", type=pathlib.Path, default=peers.ROOT / "build" / "peers")
    parser.add_argument("--out", type=pathlib.Path, default=peers.ROOT / "testenv" / "benchmark" / "results" / "passes.jpg")
    options = parser.parse_args()
    width, height = map(int, options.size.split("x"))
    work = options.work.resolve() / "passes"
    work.mkdir(parents=True, exist_ok=True)
    job = work / "passes.job.json"
    job.write_text(json.dumps({"width": width, "height": height, "samples": options.samples, "work": str(work),
                               "module": str((options.build / "python").resolve())}))
    done = subprocess.run([peers.python_with_peers(options.work.resolve()), HERE / "pass_sheet.py", job], capture_output=True, text=True)
    (work / "log.txt").write_text(done.stdout + done.stderr)
    lines = [line for line in done.stdout.splitlines() if line.startswith("PEER ")]
    if done.returncode != 0 or not lines:
        sys.exit(f"Blender's Python failed: {(done.stderr or done.stdout).strip()[-2000:]}")
    told = json.loads(lines[-1][5:])
    for row in told["rows"]:
        print(f"{row['label']:70} {row['words']}")
    for line in told["absent"]:
        print("left out:", line)
    write_sheet(told["rows"], width, height, told["version"], options.out)
    return None


if __name__ == "__main__":
    main()
