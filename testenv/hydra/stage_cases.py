"""Stages that the plug-in is tested with, each with an expectation.

A case is a function of a folder that it may write files to. It gives a dictionary: stage (its text); and one of
  equals    the text of another stage that shows the same; `within`: the mean difference that is allowed (default none);
            `control`: the text of a third one, which must differ by more than half of the light
  written   True: the program renders the same from the scene that the plug-in writes
  check     a function of the pictures (arrays of rows from the top down) that gives a fault, or nothing
            `materials`: parameters by name of material that this scene must have
  program   names of files of products, which `alabaster render` of the same stage writes, too: each with pairs of channels
            that show the same, a pair that does not, the names of all channels, of those that may be 0 everywhere (`zero`), and
            beginnings of attributes that are the same; `both`: texts that both warn of
  nodes     names of nodes that the registry of shaders must know; check is a function of what it knows
  files     names of files that usdrecord's recorder or the renderer writes, each with its window of the picture that the
            engine shows with the options `show`
besides options of record_stage, and frames, a list of {time, settings}; `equals` and `written` are about the last picture.
"""
import capture_cases
import light_cases
import node_cases
import product_cases
from stage_text import *  # noqa: F403

CASES = {}


def case(function):
    CASES[function.__name__] = function
    return function


def lit_by(*lights):
    return HEAD + "".join([camera(), wax(), clay(), octahedron("body", bound("/wax")), floor(bound("/clay")), *lights])


def light(kind, *lines, turn=(0, 0, 0), x=0.5, y=1.5, z=1.5):
    return prim(kind, "light", *lines, moved(x, y, z, turn))


LIGHTS = {
    "sphere": light("SphereLight", "float inputs:radius = 0.3", "float inputs:intensity = 20"),
    "point": light("SphereLight", "float inputs:radius = 0.3", "bool treatAsPoint = 1", "float inputs:intensity = 30", "bool inputs:normalize = 1"),
    "disk": light("DiskLight", "float inputs:radius = 0.5", "float inputs:intensity = 20", turn=(-50, 0, 0)),
    "rect": light("RectLight", "float inputs:width = 2", "float inputs:height = 0.5", "float inputs:intensity = 20", "float inputs:exposure = 0.5", turn=(-50, 0, 0)),
    "cylinder": light("CylinderLight", "float inputs:length = 2", "float inputs:radius = 0.1", "float inputs:intensity = 20", "color3f inputs:color = (1, 0.6, 0.2)"),
    "spot": prim("SphereLight", "light", "float inputs:radius = 0.05", "float inputs:intensity = 3000", "float inputs:shaping:cone:angle = 25",
                 "float inputs:shaping:cone:softness = 0.3", "float inputs:shaping:focus = 2", moved(0, 2, 2, (-50, 0, 0)),
                 about='prepend apiSchemas = ["ShapingAPI"]'),
    "distant": light("DistantLight", "float inputs:intensity = 50", "float inputs:angle = 8", "bool inputs:enableColorTemperature = 1",
                     "float inputs:colorTemperature = 3000", turn=(-40, 20, 0)),
    "dome": light("DomeLight", "float inputs:intensity = 0.7", "color3f inputs:color = (0.3, 0.6, 1)"),
}


def a_light(kind):
    return lambda _: {"stage": lit_by(LIGHTS[kind]), "written": True}


for kind in LIGHTS:
    CASES["light_" + kind] = a_light(kind)
for cases in (light_cases, node_cases, capture_cases, product_cases):
    CASES.update(cases.CASES)


@case
def standard_surface(_):
    paint = standard("paint", "color3f inputs:base_color = (0.2, 0.5, 0.8)", "float inputs:specular_roughness = 0.3", "float inputs:subsurface = 0.5",
                     "color3f inputs:subsurface_color = (0.9, 0.3, 0.2)", "color3f inputs:subsurface_radius = (0.3, 0.2, 0.1)", "float inputs:coat = 0.5")
    return {"stage": HEAD + camera() + sun() + paint + octahedron("body", bound("/paint")), "written": True}


SKELETON = '''def SkelRoot "model" (prepend apiSchemas = ["SkelBindingAPI"])
{
    def Skeleton "bones" (prepend apiSchemas = ["SkelBindingAPI"])
    {
        uniform token[] joints = ["root", "root/tip"]
        uniform matrix4d[] bindTransforms = [((1,0,0,0),(0,1,0,0),(0,0,1,0),(0,0,0,1)), ((1,0,0,0),(0,1,0,0),(0,0,1,0),(0,0,0,1))]
        uniform matrix4d[] restTransforms = [((1,0,0,0),(0,1,0,0),(0,0,1,0),(0,0,0,1)), ((1,0,0,0),(0,1,0,0),(0,0,1,0),(0,0,0,1))]
        rel skel:animationSource = </model/bones/walk>
        def SkelAnimation "walk"
        {
            uniform token[] joints = ["root", "root/tip"]
            float3[] translations.timeSamples = { 1: [(0,0,0), (0,0,0)], 2: [(0,0,0), (1,0.5,0)] }
            quatf[] rotations = [(1,0,0,0), (1,0,0,0)]
            half3[] scales = [(1,1,1), (1,1,1)]
        }
    }
%s}
'''


def skinned(points, weights, tips):
    """A triangle-faced cube whose joints are 0, or 1 where `tips`; and the same mesh with points of its own."""
    indices = ", ".join(str(int(tip)) for tip in tips)
    skin = ['prepend rel skel:skeleton = </model/bones>',
            f'int[] primvars:skel:jointIndices = [{indices}] (elementSize = 1; interpolation = "vertex")',
            f'float[] primvars:skel:jointWeights = [{", ".join(str(w) for w in weights)}] (elementSize = 1; interpolation = "vertex")']
    about = 'prepend apiSchemas = ["MaterialBindingAPI", "SkelBindingAPI"]'
    return mesh("body", points, triangles(CUBE_FACES), bound("/wax"), *skin, about=about)


@case
def skinning(_):
    """Points that the host computes are those that the joints give, at any time."""
    tips = [y > 0 for _, y, _ in CUBE_POINTS]
    there = [(x + 1, y + 0.5, z) if tip else (x, y, z) for (x, y, z), tip in zip(CUBE_POINTS, tips)]
    scene = HEAD + camera() + wax() + sun()
    return {"stage": scene + SKELETON % skinned(CUBE_POINTS, [1] * 8, tips), "frames": [{"time": 1}, {"time": 2}],
            "equals": scene + prim("Xform", "model", mesh("body", there, triangles(CUBE_FACES), bound("/wax"), about=BINDS)), "within": 1e-5}


@case
def skinning_blur(_):
    """Within an open shutter, points that the host computes move as authored ones do."""
    tips = [y > 0 for _, y, _ in CUBE_POINTS]
    there = [(x + 1, y + 0.5, z) if tip else (x, y, z) for (x, y, z), tip in zip(CUBE_POINTS, tips)]
    scene = HEAD + camera("double shutter:open = 0", "double shutter:close = 0.5") + wax() + sun()
    moving = f"point3f[] points.timeSamples = {{ 1: {vectors(CUBE_POINTS)}, 2: {vectors(there)} }}"
    return {"stage": scene + SKELETON % skinned(CUBE_POINTS, [1] * 8, tips), "frames": [{"time": 1}],
            "equals": scene + prim("Xform", "model", mesh("body", CUBE_POINTS, triangles(CUBE_FACES), moving, bound("/wax"), about=BINDS)), "within": 1e-5}


# Pictures of glowing quads, whose colour at a place is known. Rows of the picture go down, 16 pixels to a unit at z = 0.
def seen(picture, x, y):
    return picture["color"][int(24 - 16 * y), int(32 + 16 * x), :3]


def expect(picture, places, within=1e-5):
    """A fault if a place does not show its colour."""
    for (x, y), color in places.items():
        found = seen(picture, x, y)
        if max(abs(float(f) - c) for f, c in zip(found, color)) > within * max(1.0, *color):
            return f"({x}, {y}) shows {found.tolist()}, not {color}"
    return ""


RED, BLACK = (2.0, 0.0, 0.0), (0.0, 0.0, 0.0)


@case
def purposes(_):
    """The pass draws the purposes that the application asks for, and nothing invisible."""
    quads = [quad("a", bound("/red"), 'uniform token purpose = "render"', x=-1.2), quad("b", bound("/red"), 'uniform token purpose = "proxy"', x=0),
             quad("c", bound("/red"), 'uniform token purpose = "guide"', x=1.2), quad("d", bound("/red"), 'token visibility = "invisible"', x=-1.2, y=1),
             quad("e", bound("/red"), x=0, y=1, half=0.4), prim("Xform", "hidden", 'token visibility = "invisible"', quad("f", bound("/red"), x=1.2, y=1))]
    return {"stage": HEAD + camera() + glow("red", RED) + "".join(quads), "purposes": ["render"],
            "check": lambda p: expect(p[0], {(-1.2, 0): RED, (0, 0): BLACK, (1.2, 0): BLACK, (-1.2, 1): BLACK, (0, 1): RED, (1.2, 1): BLACK})}


@case
def sides(_):
    """A mesh that is not double-sided has no back, and a left-handed one faces the other way."""
    quads = [quad("a", bound("/red"), x=-1.2), prim("Xform", "turned", quad("b", bound("/red"), 'uniform bool doubleSided = 0'), moved(turn=(0, 180, 0))),
             prim("Xform", "both", quad("c", bound("/red"), "uniform bool doubleSided = 1"), moved(x=1.2, turn=(0, 180, 0))),
             quad("d", bound("/red"), 'uniform token orientation = "leftHanded"', x=-1.2, y=1)]
    return {"stage": HEAD + camera() + glow("red", RED) + "".join(quads),
            "check": lambda p: expect(p[0], {(-1.2, 0): RED, (0, 0): BLACK, (1.2, 0): RED, (-1.2, 1): BLACK})}


COPIES = {"a": (-1.2, 0.4, 0), "b": (0.2, -0.3, 0.5), "c": (1.1, 0.6, -1)}


def copies(body):
    return "".join(prim("Xform", f"copy_{name}", body, moved(*at)) for name, at in COPIES.items())


def small():
    return octahedron("body", bound("/wax"), radius=0.5)


@case
def native_instances(_):
    model = prim("class Xform", "_model", small())
    instances = "".join(prim("Xform", f"copy_{name}", moved(*at), about="instanceable = true; prepend inherits = </_model>") for name, at in COPIES.items())
    scene = HEAD + camera() + wax() + sun()
    return {"stage": scene + model + instances, "equals": scene + copies(small()), "within": 1e-3}


def point_instancer(name, prototype, positions, *lines, kind="PointInstancer"):
    return prim(kind, name, f"rel prototypes = [<{prototype}>]", f"int[] protoIndices = {[0] * len(positions)}", f"point3f[] positions = {vectors(positions)}", *lines)


@case
def point_instances(_):
    """The prototype is below the instancer, and one instance is left out by its id."""
    scene = HEAD + camera() + wax() + sun()
    places = [*COPIES.values(), (0, 1.2, 0)]
    many = point_instancer("many", "/many/body", places, "int64[] invisibleIds = [3]", small())
    return {"stage": scene + many, "equals": scene + copies(small()), "within": 1e-3}


@case
def nested_instances(_):
    """An instancer of instancers: pairs along x, turned and scaled, three of them."""
    scene = HEAD + camera() + wax() + sun()
    pair = point_instancer("pair", "/many/pair/body", [(-0.4, 0, 0), (0.4, 0, 0)], "float3[] scales = [(0.5, 0.5, 0.5), (0.3, 0.3, 0.3)]", small())
    many = point_instancer("many", "/many/pair", list(COPIES.values()), "quath[] orientations = [(1, 0, 0, 0), (0.70710678, 0, 0, 0.70710678), (1, 0, 0, 0)]", pair)
    by_hand = ""
    for number, (name, at) in enumerate(COPIES.items()):
        halves = prim("Xform", "left", small(), moved(x=-0.4, grow=0.5)) + prim("Xform", "right", small(), moved(x=0.4, grow=0.3))
        by_hand += prim("Xform", f"copy_{name}", halves, moved(*at, turn=(0, 0, 90 if number == 1 else 0)))
    return {"stage": scene + many, "equals": scene + by_hand, "within": 2e-3}


@case
def instances_of_instances(_):
    """A native instance of a model that holds a point instancer."""
    scene = HEAD + camera() + wax() + sun()
    model = prim("class Xform", "_model", point_instancer("pair", "/_model/pair/body", [(-0.4, 0, 0), (0.4, 0, 0)], "float3[] scales = [(0.5, 0.5, 0.5), (0.5, 0.5, 0.5)]", small()))
    instances = "".join(prim("Xform", f"copy_{name}", moved(*at), about="instanceable = true; prepend inherits = </_model>") for name, at in COPIES.items())
    halves = prim("Xform", "left", small(), moved(x=-0.4, grow=0.5)) + prim("Xform", "right", small(), moved(x=0.4, grow=0.5))
    return {"stage": scene + model + instances, "equals": scene + copies(halves), "within": 2e-3}


def cube(*lines, scheme="catmullClark", faces=CUBE_FACES):
    return prim("Xform", "tilted", mesh("cube", CUBE_POINTS, faces, *lines, bound("/clay"), scheme=scheme, about=BINDS), moved(turn=(20, 30, 0)))


EDGES = sorted({tuple(sorted((f[i], f[(i + 1) % 4]))) for f in CUBE_FACES for i in range(4)})
CREASES = [f"int[] creaseIndices = {[v for edge in EDGES for v in edge]}", f"int[] creaseLengths = {[2] * len(EDGES)}", f"float[] creaseSharpnesses = {[10] * len(EDGES)}"]


@case
def creases(_):
    """A cube that is sharp at every edge stays a cube when it is refined."""
    scene = HEAD + camera() + clay() + sun()
    return {"stage": scene + cube(*CREASES), "complexity": 1.3, "equals": scene + cube(scheme="none"), "within": 1e-3}


@case
def holes(_):
    """A hole is a face that is not there."""
    scene = HEAD + camera() + clay() + sun()
    return {"stage": scene + cube(*CREASES, "int[] holeIndices = [1]", "uniform bool doubleSided = 1"), "complexity": 1.2,
            "equals": scene + cube("uniform bool doubleSided = 1", scheme="none", faces=[f for i, f in enumerate(CUBE_FACES) if i != 1]), "within": 1e-3}


@case
def refinement(_):
    """By complexity a cube becomes a ball, which covers less of the picture than its cage."""
    def check(pictures):
        area = float((pictures[0]["color"][..., 3] > 0.5).mean())
        return "" if 0.2 * CAGE < area < 0.6 * CAGE else f"the refined cube covers {area} of the picture, the cage {CAGE}"
    return {"stage": HEAD + camera() + clay() + sun() + mesh("cube", CUBE_POINTS, CUBE_FACES, bound("/clay"), scheme="catmullClark", about=BINDS),
            "complexity": 1.3, "check": check}


CAGE = (1.6 * 5 / 4.2) ** 2 / 12  # share of the picture that the cube's face nearest the camera covers


@case
def primvars(_):
    """Colours of each interpolation, indexed or not, by a primvar reader."""
    reads = material("shows", "s", shader("s", "UsdPreviewSurface", "color3f inputs:diffuseColor = (0, 0, 0)", "color3f inputs:specularColor = (0, 0, 0)",
                                          "int inputs:useSpecularWorkflow = 1", "color3f inputs:emissiveColor.connect = </shows/r.outputs:result>", "token outputs:surface"),
                     shader("r", "UsdPrimvarReader_float3", 'string inputs:varname = "displayColor"', "float3 outputs:result"))
    half = [(0.5, 0, 0)]
    kinds = [quad("a", bound("/shows"), f'color3f[] primvars:displayColor = {vectors(half)} (interpolation = "constant")', x=-1.2),
             quad("b", bound("/shows"), f'color3f[] primvars:displayColor = {vectors([(0, 0.5, 0)])} (interpolation = "uniform")'),
             quad("c", bound("/shows"), f'color3f[] primvars:displayColor = {vectors([(0, 0, 0.5)] * 4)} (interpolation = "vertex")', x=1.2),
             quad("d", bound("/shows"), f'color3f[] primvars:displayColor = {vectors([(0, 0, 0), (0.5, 0.5, 0)])} (interpolation = "faceVarying")',
                  "int[] primvars:displayColor:indices = [1, 1, 1, 1]", x=-1.2, y=1, half=0.45),
             quad("e", bound("/shows"), f'color3f[] primvars:displayColor = {vectors([(0, 0, 0), (0, 0, 0), (1, 0, 1), (1, 0, 1)])} (interpolation = "varying")', y=1, half=0.45)]
    def check(pictures):
        fault = expect(pictures[0], {(-1.2, 0): (0.5, 0, 0), (0, 0): (0, 0.5, 0), (1.2, 0): (0, 0, 0.5), (-1.2, 1): (0.5, 0.5, 0)}, 1e-4)
        return fault or expect(pictures[0], {(0, 1): (0.5, 0, 0.5)}, 0.06)
    return {"stage": HEAD + camera() + reads + "".join(kinds), "check": check}


def showing(file, *texture, place=()):
    """A material that glows as a texture, which a reader of st or a placement of it looks up."""
    where = "/shows/p.outputs:result" if place else "/shows/r.outputs:result"
    nodes = [shader("s", "UsdPreviewSurface", "color3f inputs:diffuseColor = (0, 0, 0)", "color3f inputs:specularColor = (0, 0, 0)", "int inputs:useSpecularWorkflow = 1",
                    "color3f inputs:emissiveColor.connect = </shows/t.outputs:rgb>", "token outputs:surface"),
             shader("t", "UsdUVTexture", f"asset inputs:file = @{file}@", f"float2 inputs:st.connect = <{where}>", *texture, "float3 outputs:rgb"),
             shader("r", "UsdPrimvarReader_float2", 'string inputs:varname = "st"', "float2 outputs:result")]
    if place:
        nodes.append(shader("p", "UsdTransform2d", "float2 inputs:in.connect = </shows/r.outputs:result>", *place, "float2 outputs:result"))
    return material("shows", "s", *nodes)


def four(folder):
    """Red and green above, blue and grey below; each a quarter of the picture."""
    rows = [[(255, 0, 0)] * 8 + [(0, 255, 0)] * 8] * 8 + [[(0, 0, 255)] * 8 + [(128, 128, 128)] * 8] * 8
    picture(folder / "four.tga", rows)
    return folder / "four.tga"


@case
def texture_raw(folder):
    raw = 128 / 255
    return {"stage": HEAD + camera() + showing(four(folder), 'token inputs:sourceColorSpace = "raw"') + quad("a", bound("/shows"), half=1),
            "check": lambda p: expect(p[0], {(-0.5, 0.5): (1, 0, 0), (0.5, 0.5): (0, 1, 0), (-0.5, -0.5): (0, 0, 1), (0.5, -0.5): (raw, raw, raw)}, 2e-3)}


@case
def texture_srgb(folder):
    grey = 2 * ((128 / 255 + 0.055) / 1.055) ** 2.4 + 0.1
    look = ['token inputs:sourceColorSpace = "sRGB"', "float4 inputs:scale = (2, 2, 2, 1)", "float4 inputs:bias = (0.1, 0.1, 0.1, 0)"]
    return {"stage": HEAD + camera() + showing(four(folder), *look) + quad("a", bound("/shows"), half=1),
            "check": lambda p: expect(p[0], {(-0.5, 0.5): (2.1, 0.1, 0.1), (0.5, -0.5): (grey, grey, grey)}, 2e-3)}


@case
def texture_placed(folder):
    """Half the size, so that the picture is there twice each way: repeated, mirrored, black or clamped beyond."""
    place = ["float2 inputs:scale = (2, 2)", "float2 inputs:translation = (0, 0)"]
    wrap = ['token inputs:sourceColorSpace = "raw"', 'token inputs:wrapS = "repeat"', 'token inputs:wrapT = "mirror"']
    def check(pictures):
        return expect(pictures[0], {(-0.75, -0.75): BLUE_1, (-0.25, -0.75): GREY, (0.25, -0.75): BLUE_1, (-0.75, -0.25): RED_1, (-0.75, 0.25): RED_1, (-0.75, 0.75): BLUE_1}, 2e-3)
    return {"stage": HEAD + camera() + showing(four(folder), *wrap, place=place) + quad("a", bound("/shows"), half=1), "check": check}


RED_1, GREEN_1, BLUE_1, GREY = (1, 0, 0), (0, 1, 0), (0, 0, 1), (128 / 255,) * 3


@case
def texture_turned(folder):
    """A quarter turn of the coordinates against the clock, about their origin, and clamped where they lie outside."""
    place = ["float inputs:rotation = 90", "float2 inputs:translation = (1, 0)"]
    wrap = ['token inputs:sourceColorSpace = "raw"', 'token inputs:wrapS = "clamp"', 'token inputs:wrapT = "black"']
    return {"stage": HEAD + camera() + showing(four(folder), *wrap, place=place) + quad("a", bound("/shows"), half=1),
            "check": lambda p: expect(p[0], {(-0.5, 0.5): BLUE_1, (0.5, 0.5): RED_1, (0.5, -0.5): GREEN_1, (-0.5, -0.5): GREY}, 2e-3)}


@case
def light_links(_):
    """A light with a collection lights its members alone."""
    about = 'prepend apiSchemas = ["CollectionAPI:lightLink"]'
    lamp = prim("DistantLight", "sun", "float inputs:intensity = 30", "float inputs:angle = 5", "uniform bool collection:lightLink:includeRoot = 0",
                "rel collection:lightLink:includes = </a>", about=about)
    scene = HEAD + camera() + clay()
    def check(pictures):
        lit, dark = seen(pictures[0], -1, 0), seen(pictures[0], 1, 0)
        return "" if lit.min() > 0.01 and dark.max() == 0 else f"the linked quad shows {lit}, the other {dark}"
    return {"stage": scene + lamp + quad("a", bound("/clay"), x=-1) + quad("b", bound("/clay"), x=1), "check": check}


@case
def shadow_links(_):
    """A board out of sight, between the light and what is seen, is left out of the collection of those that cast shadows."""
    def scene(*exclude, boards=""):
        about = 'prepend apiSchemas = ["CollectionAPI:shadowLink"]'
        lamp = prim("DistantLight", "sun", "float inputs:intensity = 3000", "float inputs:angle = 2", *exclude, moved(turn=(0, 60, 0)), about=about)
        return HEAD + camera() + clay() + quad("a", bound("/clay"), half=0.4) + lamp + boards
    board = quad("board", bound("/clay"), "uniform bool doubleSided = 1", x=2.77, z=1.6, half=0.9)
    return {"stage": scene("rel collection:shadowLink:excludes = </board>", boards=board), "equals": scene(), "within": 2e-2,
            "control": scene(boards=board)}


@case
def motion_of_xforms(_):
    """A glowing strip crosses the picture while the shutter is open: where it was for half of the time shows half of its light."""
    strip = prim("Xform", "moving", quad("strip", bound("/red")), "double3 xformOp:translate.timeSamples = { 1: (-1, 0, 0), 2: (1, 0, 0) }",
                 'uniform token[] xformOpOrder = ["xformOp:translate"]')
    return blurred(strip)


def blurred(strip):
    # With a shutter from 0 to 1 a strip of width 1 goes from -1.5..-0.5 to 0.5..1.5, and covers a place between for half of it.
    def check(pictures):
        return expect(pictures[0], {(0, 0): (1, 0, 0), (-0.4, 0): (1, 0, 0), (0.4, 0.2): (1, 0, 0), (0, 0.8): BLACK, (1.8, 0): BLACK}, 0.1) or \
            expect(pictures[0], {(-1.0, 0): (0.5, 0, 0), (1.0, 0): (0.5, 0, 0)}, 0.12)
    return {"stage": HEAD + camera("double shutter:open = 0", "double shutter:close = 1") + glow("red", RED) + strip, "frames": [{"time": 1, "settings": {"alabaster:samples": 256}}], "check": check}


@case
def motion_of_points(_):
    far = {1: spread([(-0.5, -0.5, 0), (0.5, -0.5, 0), (0.5, 0.5, 0), (-0.5, 0.5, 0)], (-1, 0, 0)), 2: spread([(-0.5, -0.5, 0), (0.5, -0.5, 0), (0.5, 0.5, 0), (-0.5, 0.5, 0)], (1, 0, 0))}
    samples = ", ".join(f"{time}: {vectors(points)}" for time, points in far.items())
    return blurred(quad("strip", bound("/red"), f"point3f[] points.timeSamples = {{ {samples} }}"))


@case
def motion_of_instances(_):
    return blurred(prim("PointInstancer", "many", "rel prototypes = [</many/strip>]", "int[] protoIndices = [0]",
                        "point3f[] positions.timeSamples = { 1: [(-1, 0, 0)], 2: [(1, 0, 0)] }", quad("strip", bound("/red"))))


@case
def motion_of_the_camera(_):
    moving = ["double3 xformOp:translate.timeSamples = { 1: (1, 0, 5), 2: (-1, 0, 5) }", 'uniform token[] xformOpOrder = ["xformOp:translate"]']
    given = blurred(quad("strip", bound("/red")))
    given["stage"] = HEAD + camera("double shutter:open = 0", "double shutter:close = 1", *moving, z=None) + glow("red", RED) + quad("strip", bound("/red"))
    return given


@case
def dome_seen(_):
    """Setting domeLightCameraVisibility counts for lights that are there already."""
    def check(pictures):
        return expect(pictures[0], {(-1.5, 1): (0.5, 0.5, 0.5)}) or expect(pictures[1], {(-1.5, 1): BLACK}) or expect(pictures[2], {(-1.5, 1): (0.5, 0.5, 0.5)})
    return {"stage": HEAD + camera() + prim("DomeLight", "sky", "float inputs:intensity = 0.5"), "check": check,
            "frames": [{}, {"settings": {"alabaster:domeLightCameraVisibility": False}}, {"settings": {"alabaster:domeLightCameraVisibility": True}}]}


@case
def render_settings(_):
    """The active prim's settings come before the application's: it asks for 16 samples, the prim for 4."""
    prims = prim("Scope", "Render", prim("RenderSettings", "few", "int alabaster:samples = 4", "rel camera = </camera>"))
    return {"stage": lit_by(LIGHTS["sphere"]) + prims, "renderSettings": "/Render/few",
            "equals": lit_by(LIGHTS["sphere"]), "other": {"alabaster:samples": 4}, "unlike": {"alabaster:samples": 16}}


FEW = ("int alabaster:samples = 16", 'string alabaster:filter = "box"', "rel camera = </camera>")


@case
def usdrecord(_):
    """The recorder of usdrecord, with settings that the stage names in its metadata."""
    head = HEAD.replace("startTimeCode", 'renderSettingsPrimPath = "/Render/few"\n    startTimeCode')
    stage = head + lit_by(LIGHTS["rect"])[len(HEAD):] + prim("Scope", "Render", prim("RenderSettings", "few", *FEW))
    return {"stage": stage, "files": {"usdrecord.frame.exr": (0, 0, 64, 48)}}


@case
def render_products(folder):
    """usdrecord --renderSettingsPrimPath, two frames: the renderer writes a frame and a quarter of it, from a camera of their own.

    The camera moves from frame to frame, and the files of the second take the place of the first's.
    """
    color = prim("RenderVar", "color", 'uniform token dataType = "color4f"', 'uniform string sourceName = "color"')
    depth = prim("RenderVar", "depth", 'uniform token dataType = "float"', 'uniform string sourceName = "cameraDepth"')
    product = ["rel orderedVars = [</Render/color>, </Render/depth>]", "uniform int2 resolution = (64, 48)"]
    products = prim("RenderProduct", "whole", f'token productName = "{folder}/whole.exr"', *product) + \
        prim("RenderProduct", "quarter", f'token productName = "{folder}/quarter.exr"', "float4 dataWindowNDC = (0.5, 0.25, 1, 0.75)", *product)
    settings = prim("RenderSettings", "two", "rel products = [</Render/whole>, </Render/quarter>]", *(line.replace("</camera>", "</other>") for line in FEW))
    nearer = ["double3 xformOp:translate.timeSamples = { 1: (0, 0, 5), 2: (0, 0, 4) }", 'uniform token[] xformOpOrder = ["xformOp:translate"]']
    other = camera(*nearer, z=None).replace('"camera"', '"other"')
    stage = lit_by(LIGHTS["rect"]) + other + prim("Scope", "Render", color + depth + products + settings)
    return {"stage": stage, "record": {"renderSettings": "/Render/two"}, "show": {"camera": "/other", "aovs": ["color", "cameraDepth"]},
            "frames": [{"time": 1}, {"time": 2}], "files": {"whole.exr": (0, 0, 64, 48), "quarter.exr": (32, 12, 64, 36)}}


@case
def camera_exposure(_):
    """Each stop doubles the picture, at any time, and leaves depth as it is."""
    def check(pictures):
        fault = expect(pictures[0], {(0, 0): (4, 0, 0), (1, 0): BLACK}) or expect(pictures[1], {(0, 0): (0.5, 0, 0)})
        depths = {float(p["cameraDepth"][24, 32, 0]) for p in pictures}
        return fault or ("" if depths == {5.0} else f"the quad is at {depths}")
    return {"stage": HEAD + camera("float exposure.timeSamples = { 1: 1, 2: -2 }") + glow("red", RED) + quad("a", bound("/red")),
            "aovs": ["color", "cameraDepth"], "frames": [{"time": 1}, {"time": 2}], "check": check}


@case
def camera_exposure_written(_):
    return {"stage": lit_by(LIGHTS["rect"]).replace("float focalLength", "float exposure = 0.7\nfloat focalLength"), "written": True}


@case
def lens_distortion(_):
    """A part of the camera that is not read is reported."""
    return {"stage": HEAD + camera('uniform token lensDistortion:type = "fisheye"') + glow("red", RED) + quad("a", bound("/red")),
            "warns": "lens distortion is not read", "check": lambda p: expect(p[0], {(0, 0): RED})}
