"""Text of small USD stages: prims, meshes, materials and images for the tests of the plug-in."""
import struct

HEAD = '#usda 1.0\n(\n    upAxis = "Y"\n    startTimeCode = 1\n    endTimeCode = 2\n)\n'
CUBE_POINTS = [(x, y, z) for z in (-0.8, 0.8) for y in (-0.8, 0.8) for x in (-0.8, 0.8)]
CUBE_FACES = [(0, 2, 3, 1), (4, 5, 7, 6), (0, 1, 5, 4), (2, 6, 7, 3), (0, 4, 6, 2), (1, 3, 7, 5)]


def prim(kind, name, *lines, about=""):
    """A prim, or with kind "over X" and the like any specifier; `about`: metadata."""
    head = f"{kind} " if kind.startswith(("over", "class")) else f"def {kind} "
    body = "\n".join(lines)
    return f'{head}"{name}"{f" ({about})" if about else ""}\n{{\n{body}\n}}\n'


def vectors(values):
    return "[" + ", ".join("(" + ", ".join(f"{c:g}" for c in v) + ")" for v in values) + "]"


def numbers(values):
    return "[" + ", ".join(f"{v:g}" for v in values) + "]"


def moved(x=0.0, y=0.0, z=0.0, turn=(0, 0, 0), grow=1.0):
    return (f"double3 xformOp:translate = ({x:g}, {y:g}, {z:g})\nfloat3 xformOp:rotateXYZ = ({turn[0]:g}, {turn[1]:g}, {turn[2]:g})\n"
            f"float3 xformOp:scale = ({grow:g}, {grow:g}, {grow:g})\n"
            'uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:rotateXYZ", "xformOp:scale"]')


def mesh(name, points, faces, *lines, scheme="none", about=""):
    return prim("Mesh", name, f"point3f[] points = {vectors(points)}", f"int[] faceVertexCounts = {numbers([len(f) for f in faces])}",
                f"int[] faceVertexIndices = {numbers([i for f in faces for i in f])}", f'uniform token subdivisionScheme = "{scheme}"', *lines, about=about)


def bound(material):
    return f"rel material:binding = <{material}>"


BINDS = 'prepend apiSchemas = ["MaterialBindingAPI"]'


def quad(name, *lines, x=0.0, y=0.0, z=0.0, half=0.5, about=BINDS):
    """Faces the camera, with st from its lower left corner."""
    points = [(x - half, y - half, z), (x + half, y - half, z), (x + half, y + half, z), (x - half, y + half, z)]
    st = 'texCoord2f[] primvars:st = [(0, 0), (1, 0), (1, 1), (0, 1)] (interpolation = "vertex")'
    return mesh(name, points, [(0, 1, 2, 3)], st, *lines, about=about)


def camera(*lines, z=5.0):
    """Sees x from -2 to 2 and y from -1.5 to 1.5 at z = 0."""
    return prim("Camera", "camera", "float focalLength = 25", "float horizontalAperture = 20", "float verticalAperture = 15",
                "float2 clippingRange = (0.01, 1000)", *lines, *([moved(z=z)] if z is not None else []))


def shader(name, kind, *lines):
    return prim("Shader", name, f'uniform token info:id = "{kind}"', *lines)


def material(name, surface, *nodes, terminal="surface"):
    """Nodes in a material whose terminal is the node called `surface`."""
    return prim("Material", name, f"token outputs:{terminal}.connect = </{name}/{surface}.outputs:surface>", *nodes)


def standard(name, *lines):
    """Standard Surface of MaterialX."""
    return material(name, "s", shader("s", "ND_standard_surface_surfaceshader", *lines, "token outputs:surface"), terminal="mtlx:surface")


def glow(name, color):
    """Gives light and reflects none."""
    return standard(name, "float inputs:base = 0", "float inputs:specular = 0", "float inputs:emission = 1",
                    f"color3f inputs:emission_color = ({color[0]:g}, {color[1]:g}, {color[2]:g})")


def wax(name="wax"):
    return standard(name, "float inputs:subsurface = 1", "color3f inputs:subsurface_color = (0.8, 0.5, 0.4)",
                    "color3f inputs:subsurface_radius = (0.2, 0.1, 0.05)", "float inputs:specular_roughness = 0.4")


def clay(name="clay"):
    return standard(name, "color3f inputs:base_color = (0.6, 0.6, 0.6)", "float inputs:specular = 0.2")


def sun(*lines, intensity=3000.0, turn=(-40, 25, 0)):
    return prim("DistantLight", "sun", f"float inputs:intensity = {intensity:g}", "float inputs:angle = 2", *lines, moved(turn=turn))


def triangles(faces):
    return [(f[0], f[i], f[i + 1]) for f in faces for i in range(1, len(f) - 1)]


def octahedron(name, *lines, radius=0.8, about=BINDS):
    r = radius
    points = [(r, 0, 0), (-r, 0, 0), (0, r, 0), (0, -r, 0), (0, 0, r), (0, 0, -r)]
    faces = [(0, 2, 4), (2, 1, 4), (1, 3, 4), (3, 0, 4), (2, 0, 5), (1, 2, 5), (3, 1, 5), (0, 3, 5)]
    return mesh(name, points, faces, *lines, about=about)


def floor(*lines, y=-0.9, half=3.0):
    points = [(-half, y, -half), (half, y, -half), (half, y, half), (-half, y, half)]
    return mesh("floor", points, [(0, 2, 1), (0, 3, 2)], *lines, about=BINDS)


def spread(points, by):
    """Points moved by a vector."""
    return [tuple(p + b for p, b in zip(point, by)) for point in points]


def picture(file, rows):
    """A TGA of 8 bits from rows of colours 0..255, the uppermost first."""
    head = struct.pack("<BBBHHBHHHHBB", 0, 0, 2, 0, 0, 0, 0, 0, len(rows[0]), len(rows), 24, 0x20)
    file.write_bytes(head + b"".join(bytes(color[::-1]) for row in rows for color in row))
