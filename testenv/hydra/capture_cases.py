"""Stages that are translated on their way into the files of a captured scene, which the program renders to the same pixels."""
from stage_text import BINDS, CUBE_FACES, CUBE_POINTS, HEAD, bound, camera, clay, floor, material, mesh, octahedron, picture, quad, shader, sun, vectors, wax

CASES = {}


def case(function):
    CASES[function.__name__] = function
    return function


@case
def polygons_written(_):
    """Faces of four and five corners, flat and bent, are cut as the renderer cuts them."""
    bent = [(x, y, z + 0.2 * x * y) for x, y, z in CUBE_POINTS]
    house = [(-1.8, 0.3, 0), (-1.0, 0.3, 0), (-1.0, 1.0, 0), (-1.3, 1.4, 0), (-1.7, 1.1, 0.1)]
    normals = f'normal3f[] normals = {vectors([(0, 0, 1), (0.3, 0, 1), (0, 0.4, 1), (0, 0, 1), (0, 0.2, 1)])} (interpolation = "vertex")'
    ground = [(-3, -0.9, -3), (-3, -0.9, 3), (3, -0.9, 3), (3, -0.9, -3)]
    return {"stage": HEAD + camera() + sun() + wax() + clay() + mesh("body", bent, CUBE_FACES, bound("/wax"), about=BINDS)
            + mesh("house", house, [(0, 1, 2, 3, 4)], normals, bound("/clay"), about=BINDS) + mesh("floor", ground, [(0, 1, 2, 3)], bound("/clay"), about=BINDS),
            "written": True}


@case
def preview_surface_written(folder):
    """The archive holds UsdPreviewSurface as it is."""
    picture(folder / "checks.tga", [[(230, 90, 40), (40, 120, 220)] * 2, [(40, 120, 220), (230, 90, 40)] * 2] * 2)
    paint = material("paint", "s", shader("s", "UsdPreviewSurface", "color3f inputs:diffuseColor.connect = </paint/t.outputs:rgb>", "float inputs:roughness = 0.3",
                                          "float inputs:clearcoat = 0.5", "token outputs:surface"),
                     shader("t", "UsdUVTexture", f"asset inputs:file = @{folder}/checks.tga@", "float2 inputs:st.connect = </paint/r.outputs:result>",
                            'token inputs:wrapS = "repeat"', 'token inputs:wrapT = "repeat"', "float3 outputs:rgb"),
                     shader("r", "UsdPrimvarReader_float2", 'string inputs:varname = "st"', "float2 outputs:result"))
    metal = material("metal", "s", shader("s", "UsdPreviewSurface", "color3f inputs:diffuseColor = (0.9, 0.6, 0.3)", "float inputs:metallic = 1", "token outputs:surface"))
    return {"stage": HEAD + camera() + sun() + paint + metal + quad("board", bound("/paint"), x=-0.9, half=0.8) + octahedron("body", bound("/metal"))
            + floor(bound("/metal")), "written": True, "materials": {"/metal": {"metallic": 1, "diffuseColor": [0.9, 0.6, 0.3]}, "/paint": {"clearcoat": 0.5, "roughness": 0.3}}}
