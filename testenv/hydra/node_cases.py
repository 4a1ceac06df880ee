"""Stages whose materials are networks of the renderer's own nodes, which OpenUSD's registry of shaders must know."""
import json
import pathlib

from stage_text import BINDS, HEAD, bound, camera, material, mesh, moved, octahedron, picture, prim, quad, shader, sun

SCHEMAS = pathlib.Path(__file__).resolve().parents[2] / "schemas"
INPUTS = {"AlabasterDisney": ("disney_material", {"normal", "coatNormal", "bump"}), "AlabasterTexture": ("texture_node", set()),
          "AlabasterDisplacement": ("displacement_node", {"displacement"})}
ARRAYS = {2: "float2", 3: "color3f", 4: "float4"}
NODES = ["AlabasterDisney", "AlabasterDisplacement", "AlabasterPrimvar", "AlabasterTexture"]
CASES = {}


def case(function):
    CASES[function.__name__] = function
    return function


def disney(name, *lines, nodes=(), terminal="surface"):
    return material(name, "s", shader("s", "AlabasterDisney", *lines, "token outputs:surface"), *nodes, terminal=terminal)


def texture(name, file, *lines):
    return shader(name, "AlabasterTexture", f"asset inputs:file = @{file}@", *lines, "color3f outputs:rgb", "float outputs:r")


def numbers_of(text):
    """A default as OpenUSD prints it."""
    return [float(word) for word in text.strip("()").split(",")]


def fault_of_input(name, wanted, found):
    plain = wanted.get("anyOf", [wanted])[0]
    single = plain.get("items", plain)
    kinds = {"array": ARRAYS.get(plain.get("minItems")), "number": "float", "integer": "int", "boolean": "bool", "string": "asset" if name == "file" else "token"}
    kind, said = kinds[plain["type"]], found["metadata"]
    if (found["type"], found["help"], found["connectable"]) != (kind, wanted["description"], "anyOf" in wanted or name == "file"):
        return f"{name} is {found}"
    if plain["type"] == "string":
        same = found["default"].strip('"@') == wanted["default"] and found["options"] == wanted.get("enum", [])
    else:
        default = wanted["default"] if plain["type"] == "array" else [wanted["default"]]
        same = all(abs(a - b) <= 1e-6 for a, b in zip(numbers_of(found["default"]), map(float, default), strict=True))
    if not same:
        return f"the default of {name} is {found['default']}, not {wanted['default']}"
    if said.get("unit", "none") != wanted["unit"]:
        return f"the unit of {name} is {said.get('unit')}"
    if any(float(said.get(bound, "nan")) != single[bound] if bound in single else bound in said for bound in ("minimum", "maximum")):
        return f"the range of {name} is {said}"
    return ""


@case
def shader_registry(_):
    """Inputs are those of the schemas, with type, default, range, unit and sentence, and those that are only connected."""
    def check(nodes):
        if sorted(nodes) != NODES or any(not node["help"] or not node["outputs"] for node in nodes.values()):
            return f"the registry has {nodes}"
        for node, (name, connected) in INPUTS.items():
            schema, inputs = json.loads((SCHEMAS / f"{name}.json").read_text())["properties"], nodes[node]["inputs"]
            if set(inputs) != set(schema) | connected:
                return f"the inputs of {node} are {sorted(inputs)}"
            for fault in (fault_of_input(one, wanted, inputs[one]) for one, wanted in schema.items()):
                if fault:
                    return fault
        return ""
    return {"nodes": NODES, "check": check}


CHECKS = [[(230, 60, 60)] * 8 + [(60, 230, 60)] * 8] * 8 + [[(60, 60, 230)] * 8 + [(200, 200, 200)] * 8] * 8


@case
def own_nodes(folder):
    """Scattering that no other node gives without loss, and a surface with a texture: pixels of the program for the same parameters."""
    picture(folder / "checks.tga", CHECKS)
    soft = disney("soft", "color3f inputs:baseColor = (0.9, 0.6, 0.4)", "color3f inputs:scatterDistance = (0.3, 0.15, 0.08)", "float inputs:scatterAnisotropy = 0.4",
                  "float inputs:roughness = 0.35", "float inputs:coat = 0.5", "float inputs:ior = 1.4")
    painted = disney("painted", "color3f inputs:baseColor.connect = </painted/t.outputs:rgb>", "float inputs:roughness = 0.6", "float inputs:sheen = 0.7", "bool inputs:thin = 1",
                     "int inputs:priority = 3", nodes=[texture("t", folder / "checks.tga", 'token inputs:wrapS = "clamp"', 'token inputs:wrapT = "clamp"')])
    body = octahedron("body", bound("/soft"), radius=0.7)
    board = quad("board", bound("/painted"), x=-1.1, z=0.2, half=0.6).replace("[4]", "[3, 3]").replace("[0, 1, 2, 3]", "[0, 1, 2, 0, 2, 3]")
    return {"stage": HEAD + camera() + sun() + soft + painted + body + board, "written": True,
            "materials": {"/soft": {"baseColor": [0.9, 0.6, 0.4], "scatterDistance": [0.3, 0.15, 0.08], "scatterAnisotropy": 0.4, "roughness": 0.35, "coat": 0.5, "ior": 1.4},
                          "/painted": {"wrapS": "clamp", "roughness": 0.6, "sheen": 0.7, "thin": True, "priority": 3}}}


def colors_at(picture_of, places):
    for (x, y), color in places.items():
        found = picture_of["color"][int(24 - 16 * y), int(32 + 16 * x), :3]
        if max(abs(float(f) - c) for f, c in zip(found, color)) > 2e-3:
            return f"({x}, {y}) shows {found.tolist()}, not {color}"
    return ""


DARK = ("color3f inputs:baseColor = (0, 0, 0)", "float inputs:specular = 0")


@case
def own_texture(folder):
    """Each input of AlabasterTexture: half the size, in the right half of the board, black beside it and mirrored below; twice the texel and 0.1."""
    picture(folder / "checks.tga", CHECKS)
    place = ['token inputs:sourceColorSpace = "raw"', 'token inputs:wrapS = "black"', 'token inputs:wrapT = "mirror"', 'token inputs:filter = "nearest"', 'token inputs:st = "uv"',
             "float2 inputs:stScale = (2, 2)", "float2 inputs:stOffset = (-1, 0)", "float4 inputs:scale = (2, 2, 2, 1)", "float4 inputs:bias = (0.1, 0.1, 0.1, 0)"]
    shows = disney("shows", *DARK, "color3f inputs:emission.connect = </shows/t.outputs:rgb>", nodes=[texture("t", folder / "checks.tga", *place)])
    board = quad("board", bound("/shows"), half=1).replace("primvars:st", "primvars:uv")
    red, green, blue, grey = (tuple(2 * byte / 255 + 0.1 for byte in CHECKS[row][column]) for row in (0, 8) for column in (0, 8))
    return {"stage": HEAD + camera() + shows + board,
            "check": lambda p: colors_at(p[0], {(0.25, 0.75): red, (0.75, 0.75): green, (0.25, 0.25): blue, (0.75, 0.25): grey, (0.25, -0.25): blue,
                                                (0.25, -0.75): red, (0.75, -0.75): green, (-0.5, 0.5): (0.1, 0.1, 0.1)})}


@case
def own_primvar(_):
    shows = disney("shows", *DARK, "color3f inputs:emission.connect = </shows/p.outputs:rgb>", nodes=[shader("p", "AlabasterPrimvar", "color3f outputs:rgb")])
    board = quad("board", bound("/shows"), 'color3f[] primvars:displayColor = [(0.5, 0.25, 0.75)] (interpolation = "constant")', half=1)
    return {"stage": HEAD + camera() + shows + board, "check": lambda p: colors_at(p[0], {(0.5, 0.5): (0.5, 0.25, 0.75)})}


@case
def own_displacement(folder):
    """A refined plane whose height is 1 everywhere, times 0.6 less a midlevel of 0.5, is the plane moved by 0.3."""
    picture(folder / "white.tga", [[(255, 255, 255)] * 4] * 4)
    nodes = [shader("d", "AlabasterDisplacement", "color3f inputs:displacement.connect = </clay/t.outputs:r>", "float inputs:scale = 0.6", "float inputs:midlevel = 0.5",
                    "token outputs:displacement"), texture("t", folder / "white.tga")]
    grey = "color3f inputs:baseColor = (0.5, 0.5, 0.5)"
    rises = disney("clay", grey, nodes=nodes).replace("token outputs:surface.connect", "token outputs:displacement.connect = </clay/d.outputs:displacement>\ntoken outputs:surface.connect", 1)
    def scene(look, z):
        points = [(x, y, 0) for y in (-1, 0, 1) for x in (-1, 0, 1)]
        faces = [(0, 1, 4, 3), (1, 2, 5, 4), (3, 4, 7, 6), (4, 5, 8, 7)]
        st = f'texCoord2f[] primvars:st = [{", ".join(f"({(x + 1) / 2}, {(y + 1) / 2})" for x, y, _ in points)}] (interpolation = "vertex")'
        plane = mesh("plane", points, faces, bound("/clay"), st, "int[] cornerIndices = [0, 2, 6, 8]", "float[] cornerSharpnesses = [10, 10, 10, 10]", scheme="catmullClark", about=BINDS)
        return HEAD + camera() + sun() + look + prim("Xform", "lifted", plane, moved(z=z))
    return {"stage": scene(rises, 0), "complexity": 1.2, "equals": scene(disney("clay", grey), 0.3), "within": 1e-4, "control": scene(disney("clay", grey), -3)}


@case
def own_context(_):
    """A material may say more to this renderer than to others: terminal alabaster:surface comes before MaterialX's and the one for all."""
    def colored(terminal, color):
        return f"token outputs:{terminal}.connect = </many/{color}.outputs:surface>"
    def node(name, kind, *lines):
        return shader(name, kind, *lines, "token outputs:surface")
    many = prim("Material", "many", colored("alabaster:surface", "ours"), colored("mtlx:surface", "theirs"), colored("surface", "all"),
                node("ours", "AlabasterDisney", *DARK, "color3f inputs:emission = (0, 1, 0)"),
                node("theirs", "ND_standard_surface_surfaceshader", "float inputs:emission = 1", "color3f inputs:emission_color = (1, 0, 0)"),
                node("all", "UsdPreviewSurface", "color3f inputs:emissiveColor = (0, 0, 1)"))
    return {"stage": HEAD + camera() + many + quad("board", bound("/many"), half=1), "check": lambda p: colors_at(p[0], {(0.5, 0.5): (0, 1, 0)})}
