"""Stages whose products have many layers, written by the plug-in and by the program."""
from stage_text import HEAD, BINDS, bound, camera, clay, floor, glow, moved, octahedron, prim, quad, sun, wax

CASES = {}


def case(function):
    CASES[function.__name__] = function
    return function


def layer(name, source, *lines, kind="raw", data="color3f"):
    return prim("RenderVar", name, f'uniform token dataType = "{data}"', f'uniform string sourceName = "{source}"', f'uniform token sourceType = "{kind}"', *lines)


def product(folder, name, *layers, settings=()):
    """Settings with one product, and its layers: text of prims by `layer`."""
    names = ", ".join(f"</Render/{text.split(chr(34))[1]}>" for text in layers)
    of = prim("RenderProduct", "frame", f'token productName = "{folder}/{name}"', f"rel orderedVars = [{names}]")
    given = ["rel products = [</Render/frame>]", "rel camera = </camera>", "uniform int2 resolution = (64, 48)", "int alabaster:samples = 16",
             'string alabaster:filter = "box"', *settings]
    return prim("Scope", "Render", *layers, of, prim("RenderSettings", "settings", *given))


def lamp(*lines):
    return prim("SphereLight", "lamp", "float inputs:radius = 0.3", "float inputs:intensity = 20", *lines, moved(0.5, 1.5, 1.5))


def scene(*more):
    return HEAD + "".join([wax(), clay(), octahedron("body", bound("/wax")), floor(bound("/clay")), *more])


def rgb(layer):
    return [f"{layer}.{c}" for c in "RGB"] if layer else list("RGB")


@case
def layers_of_light_paths(folder):
    """An expression shows what the AOV does. Several layers may show one; one that nobody shows is left out."""
    layers = [layer("beauty", "C.*", kind="lpe"), layer("direct", "C<RD>L", kind="lpe"), layer("straight", "lpe:C<RD>[<L.>O]"), layer("named", "directDiffuse"),
              layer("theirs", "directDiffuse", 'string driver:parameters:aov:name = "dd"'), layer("inside", "C<TD>.*", kind="lpe"), layer("body", "subsurface"),
              layer("odd", "C<RS>D<L.>", kind="lpe"), layer("shadow", "shadowMask"), layer("Ci", "Ci", data="color4f"),
              layer("keyed", "C.*<L.'key'>", kind="lpe"), layer("key", "lightGroup:key")]
    pairs = [*(("directDiffuse", one) for one in ("direct", "straight", "dd")), ("subsurface", "inside"), ("lightGroup_key", "keyed"), ("", "beauty")]
    names = [*"RGBA", "beauty.A", *(c for one in ("beauty", "dd", "direct", "directDiffuse", "inside", "keyed", "lightGroup_key", "straight", "subsurface") for c in rgb(one))]
    stage = scene(camera(), sun(), lamp('string inputs:ri:light:lightGroup = "key"'), product(folder, "paths.exr", *layers))
    return {"stage": stage, "program": {"paths.exr": {"same": [(rgb(a), rgb(b)) for a, b in pairs], "unlike": (rgb("direct"), rgb("inside")), "names": names}},
            "both": ["layer odd is not written: no AOV shows the light paths 'C<RS>D<L.>'; the expressions that are known are in the table"],
            "warns": "layer shadowMask is not written: there is no AOV 'shadowMask'"}


@case
def layers_of_groups(folder):
    """Light groups of lights and of meshes, as Arnold and we name them: with the rest they are the picture."""
    layers = [layer("c", "color", data="color4f"), *(layer(f"g{i}", f"lightGroup:{name}") for i, name in enumerate(("key", "panel", "")))]
    panel = quad("panel", bound("/glowing"), 'string primvars:lightGroup = "panel"', x=-1.2, y=0.6, half=0.3)
    stage = scene(camera(), sun(), glow("glowing", (4, 2, 1)), panel, lamp('string primvars:arnold:aov = "key"'), product(folder, "groups.exr", *layers))
    names = [*"RGBA", *rgb("lightGroup"), *rgb("lightGroup_key"), *rgb("lightGroup_panel")]
    return {"stage": stage, "program": {"groups.exr": {"same": [], "unlike": (rgb("lightGroup_key"), rgb("lightGroup_panel")), "names": names,
                                                       "sum": (list("RGB"), [rgb("lightGroup"), rgb("lightGroup_key"), rgb("lightGroup_panel")])}}}


@case
def layers_of_mattes(folder):
    """Cryptomatte has the names and ranks of the program's, and its manifests; a layer may have another name."""
    layers = [layer("o", "cryptoObject", data="color4f"), layer("m", "cryptoMaterial", 'string driver:parameters:aov:name = "mattes"', data="color4f"),
              layer("a", "cryptoAsset", data="color4f")]
    ranks = [f"{name}{i:02}.{c}" for name in ("CryptoAsset", "CryptoObject", "mattes") for i in range(2) for c in "RGBA"]
    corners = [("/green", -1, -1), ("/clay", 1, -1), ("/red", -1, 1), ("/blue", 1, 1)]  # four quads meet in a pixel
    boards = [quad(f"board{i}", bound(to), x=-1.02 + 0.15 * x, y=0.62 + 0.15 * y, z=1, half=0.15) for i, (to, x, y) in enumerate(corners)]
    stage = scene(camera(), sun(), *(glow(name, color) for name, color in zip(("red", "green", "blue"), ((1, 0, 0), (0, 1, 0), (0, 0, 1)))), *boards, product(folder, "mattes.exr", *layers, settings=["int alabaster:cryptoRanks = 4"]))
    return {"stage": stage, "program": {"mattes.exr": {"same": [], "unlike": (["CryptoObject00.R"], ["mattes00.R"]), "names": ranks, "attributes": ["cryptomatte/"]}}}


@case
def layers_of_places(folder):
    """Position, texture coordinates, occlusion, primvars and motion. The host samples its shutter alone, so motion is the camera's."""
    layers = [layer("p", "position", data="point3f"), layer("st", "st", kind="primvar", data="float2"), layer("uv", "uv", data="float2"),
              layer("ao", "ambientOcclusion", data="float"), layer("v", "motion", data="float2"), layer("z", "cameraDistance", data="float"),
              layer("n", "normal", data="normal3f")]
    moving = prim("Xform", "moving", quad("strip", bound("/clay"), x=-0.9, y=0.4), "double3 xformOp:translate.timeSamples = { 1: (0, 0, 0), 2: (1, 0.5, 0) }",
                  'uniform token[] xformOpOrder = ["xformOp:translate"]')
    stage = scene(camera("double shutter:open = 0", "double shutter:close = 0.5"), sun(), moving,
                  product(folder, "places.exr", *layers, settings=['string alabaster:motionShutter = "camera"', "float alabaster:ambientOcclusionDistance = 1"]))
    names = [*(f"P.{c}" for c in "XYZ"), *(f"N.{c}" for c in "XYZ"), *(f"primvars:st.{c}" for c in "XYZ"), "uv.U", "uv.V", "ambientOcclusion.X", "motion.X", "motion.Y",
             "cameraDistance.Z"]
    return {"stage": stage, "program": {"places.exr": {"same": [(["primvars:st.X", "primvars:st.Y"], ["uv.U", "uv.V"])], "unlike": (["motion.X"], ["motion.Y"]), "names": names, "zero": ["primvars:st.Z"]}}}
