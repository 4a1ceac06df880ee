"""Scenes of the matrix: a body, and the features that it has. A feature is a function that changes a Draft; a scene is made of
a draft and a Look, which is chosen by the check (white or coloured, smooth or rough glass, how far light scatters)."""
import functools
import math
import pathlib
import sys
import tempfile
from typing import NamedTuple

import hdalabaster
import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "scenes"))
from gltf_writer import png  # noqa: E402
from shapes import cube_sphere  # noqa: E402

VIEW = (0.25, 0.35, 1.0)  # sees the main body with what touches it
SIDE = (0.3, 0.2, 1.0)  # 20 degrees from z: where key lights are
FILM = 2.2  # width of the film; the main body is 2 wide
MAIN, SECOND, WITHIN = "/main", "/second", "/within"


class Look(NamedTuple):
    white: bool = True
    distance: float = 0.1  # scatterDistance of the first channel
    clear_roughness: float = 0.0
    mask: bool = False  # opaque bodies of the same opacity, to measure what rays meet
    flat: bool = False  # all bodies squashed along z: a ball hides what is not reciprocal from sums over its surface
    way: str = "as is"  # one of WAYS: how the scene is written down
    within: str = "ball"  # of "ball within": a mesh of its own, "faces" of the main one, of its "same" material, or "none"


class Body:
    def __init__(self, kind, place=None, path=MAIN, ior=1.5, material=None):
        self.kind, self.path, self.ior = kind, path, ior
        self.place = np.eye(4) if place is None else place
        self.material = {} if material is None else material  # shared by bodies of one look
        self.shape, self.hollow, self.displaced, self.bumped, self.set = "ball", False, False, False, None
        self.labelled = self.weighted = self.stained = False
        self.inner = None  # place of an opaque ball that is faces of this mesh


class Draft:
    def __init__(self, kind):
        self.bodies = [Body(kind)]
        self.near = None  # cut of the camera, from the eye
        self.inside = False
        self.shear = self.moves = False

    @property
    def main(self):
        return self.bodies[0]


SQUASH = np.diag([1.0, 1.0, 0.3, 1.0])


def moved(x, y, z, scale=1.0):
    return np.array([[scale, 0, 0, 0], [0, scale, 0, 0], [0, 0, scale, 0], [x, y, z, 1]], float)


SHEAR = np.array([[1.05, 0, 0, 0], [0.35, 0.95, 0, 0], [0, 0.25, 0.9, 0], [0, 0, 0, 1]], float)


MIRROR = np.diag([-1.0, 1.0, 1.0, 1.0])


def turn():
    """By 74 degrees about (1, 2, 3), and moved."""
    axis = np.array((1.0, 2.0, 3.0)) / math.sqrt(14)
    k, m = np.cross(np.eye(3), axis), moved(3.0, -2.0, 5.0)
    m[:3, :3] = np.eye(3) + math.sin(1.3) * k + (1 - math.cos(1.3)) * k @ k
    return m


WAYS = {  # of writing down a scene, so that it shows the same picture: the matrix that all of it is multiplied by
    "as is": np.eye(4),
    "turned": turn(),
    "mirrored": MIRROR,  # as is the picture
    "reordered": np.eye(4),  # other names, in another order, with others in between
    "array": np.eye(4),  # each body is one of an array
    "copies": np.eye(4),  # placements are in the points
}
ARRAY = 8192  # instances from which on they are an array (delegate/prims/scene_translation.cpp)


def placed(transform, way):
    """A camera or a light in a scene that is written down so. What is mirrored keeps its handedness by a mirror of its own."""
    m = transform @ WAYS[way]
    return MIRROR @ m if way == "mirrored" else m


def look_at(direction, distance=8.0, centre=(0, 0, 0)):
    z = np.array(direction, float)
    z /= np.linalg.norm(z)
    up = (0, 1, 0) if abs(z[1]) < 0.9 else (1, 0, 0)
    x = np.cross(up, z)
    x /= np.linalg.norm(x)
    m = np.eye(4)
    m[0, :3], m[1, :3], m[2, :3], m[3, :3] = x, np.cross(z, x), z, np.array(centre, float) + z * distance
    return m


def second_of(kind):
    """A second body of another kind, half sunk into the main one."""
    def change(draft):
        draft.bodies.append(Body(kind, moved(0.55, 0.35, 0.65, 0.55), SECOND))
    return change


def union(draft):
    other = Body(draft.main.kind, moved(-0.5, -0.45, 0.55, 0.6), "/member", material=draft.main.material)
    other.set = draft.main.set = "set"
    draft.bodies.append(other)


def touching(draft):
    """A drop of water that is half sunk into the main body."""
    draft.bodies.append(Body("glass", moved(0.25, 0.55, 0.8, 0.4), "/drop", ior=1.33))


def ball_within(draft):
    """An opaque ball wholly in the main body: white in white scenes, else black."""
    draft.bodies.append(Body("matt", moved(0.2, 0.1, 0.15, 0.4), WITHIN))


def face_to_face(draft):
    """A box, and its like on the other side of one of its faces."""
    draft.main.shape = "box"
    other = Body(draft.main.kind, moved(0.7, 0, 0), "/neighbour", material=draft.main.material)
    other.shape, draft.main.place = "box", moved(-0.7, 0, 0)
    draft.bodies.append(other)


def glass_on_its_face(draft):
    """A box, and a box of glass on its front."""
    put_glass(draft, 0.6)


def below_glass(draft):
    """A box of glass that is sunk a little into the front of the main one, so that no faces coincide."""
    put_glass(draft, 0.59, 0.97)


def put_glass(draft, z, size=1.0):
    draft.main.shape, draft.main.place = "box", moved(0, 0, -0.6)
    slab = Body("glass", np.diag([size, size, 1.0, 1.0]) @ moved(0, 0, z), "/slab")
    slab.shape = "box"
    draft.bodies.append(slab)


def pane(draft):
    """A sheet of clear glass before the main body, as the light and the camera see it."""
    sheet = Body("pane", look_at(SIDE, 1.8), "/pane")
    sheet.shape = "pane"
    draft.bodies.append(sheet)


def pyramid(draft):
    """The main body has no centre of symmetry."""
    draft.main.shape = "pyramid"


def sets(**values):
    return lambda draft: draft.main.material.update(values)


def has(name, value=True):
    return lambda draft: setattr(draft, name, value)


def main_has(name):
    return lambda draft: setattr(draft.main, name, True)


BY_FREE_PATH = "by free path"  # the body's scatterDistance is given as meanFreePath
KINDS = ("opaque body", "cloudy body", "glass")
FEATURES = {  # in the order of the issue
    "opacity": sets(opacity=0.5),
    "coat": sets(coat=1.0, coatRoughness=0.3),
    "fibre sheen": sets(sheen=1.0, sheenRoughness=0.5),
    "clearcoat": sets(clearcoat=1.0, clearcoatGloss=0.3),
    "rough specular": sets(specular=1.0, roughness=0.4),
    "normal map": main_has("bumped"),
    "displacement": main_has("displaced"),
    "inner shell": main_has("hollow"),
    "union": union,
    "touching": touching,
    "cut": has("near", 7.6),
    "camera inside": has("inside"),
    "shear": has("shear"),
    "motion": has("moves"),
    "face to face": face_to_face,  # other ways to touch
    "below glass": below_glass,
    "glass on its face": glass_on_its_face,
    "pyramid": pyramid,
    "label": main_has("labelled"),  # some of the faces have a material of their own, which is opaque
    "pane": pane,
    "ball within": ball_within,
    "weight": sets(subsurfaceWeight=0.4, subsurfaceColor=(1.0,) * 3),
    "weight map": main_has("weighted"),  # of 0 and 1
    "stained coat": main_has("stained"),
    "mean free path": sets(**{BY_FREE_PATH: True}),
}
LAYERS = ("coat", "stained coat", "fibre sheen", "clearcoat", "rough specular")


class Scenery(NamedTuple):
    """The name of a row's scene, and what it is made of: the kind of the main body, and features or kinds of second bodies."""
    kind: str
    features: tuple

    @property
    def name(self):
        return " + ".join((self.kind,) + self.features)

    @property
    def kinds(self):
        return (self.kind,) + tuple(f for f in self.features if f in KINDS)

    @property
    def clear(self):
        """True if light passes a clear boundary somewhere."""
        return any(k != "opaque body" for k in self.kinds) or self.any("touching", "below glass", "glass on its face")

    def draft(self):
        draft = Draft(self.kind)
        for feature in self.features:
            (second_of(feature) if feature in KINDS else FEATURES[feature])(draft)
        return draft

    def any(self, *features):
        return any(f in self.features for f in features)


@functools.lru_cache(maxsize=None)
def ball(n, hollow):
    mesh = cube_sphere(n, lambda p: p)
    points, quads = np.float32(mesh.points), np.int32(mesh.quads)
    uvs = np.float32(mesh.uvs).reshape(-1, 2)
    normals = points
    if hollow:  # a second wall that faces the middle
        points = np.concatenate([points, points * np.float32(0.45)])
        normals = np.concatenate([normals, -normals])
        quads = np.concatenate([quads, quads[:, ::-1] + len(mesh.points)])
        uvs = np.concatenate([uvs, uvs.reshape(-1, 4, 2)[:, ::-1].reshape(-1, 2)])
    return points, quads, normals, uvs


def box():
    points = np.float32([(x, y, z) for x in (-0.7, 0.7) for y in (-0.8, 0.8) for z in (-0.6, 0.6)])
    quads = np.int32([(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)])
    return points, quads


def pyramid_mesh():
    points = np.float32([(-0.4, -1, 1), (-0.4, -1, -1), (-0.4, 1, -1), (-0.4, 1, 1), (0.9, 0.1, -0.2)])
    return points, np.int32([(3, 2, 1), (3, 1, 0), (0, 1, 4), (1, 2, 4), (2, 3, 4), (3, 0, 4)])


def square():
    return np.float32([(-1.5, -1.5, 0), (1.5, -1.5, 0), (1.5, 1.5, 0), (-1.5, 1.5, 0)]), np.int32([(0, 1, 2, 3)])


SHAPES = {"box": box, "pyramid": pyramid_mesh, "pane": square}


@functools.lru_cache(maxsize=None)
def images():
    """A folder with an image of normals and one of heights, both even along the edges of the square."""
    folder = pathlib.Path(_FOLDER.name)

    def wave(x, y):
        return math.sin(math.pi * (x + 0.5) / 32) ** 2 * math.sin(math.pi * (y + 0.5) / 32) ** 2

    def normal(x, y):
        bump = 0.25 * wave(x, y)
        n = np.array([bump * math.sin(x), bump * math.cos(y), 1.0])
        return tuple(0.5 + 0.5 * n / np.linalg.norm(n))

    (folder / "normals.png").write_bytes(png(32, 32, normal))
    (folder / "heights.png").write_bytes(png(32, 32, lambda x, y: (wave(x, y) * (0.5 + 0.5 * math.cos(x)),) * 3))
    (folder / "weights.png").write_bytes(png(4, 4, lambda x, y: ((x + y) % 2,) * 3))
    return folder


_FOLDER = tempfile.TemporaryDirectory(prefix="matrix_")


def material_of(body, look):
    if body.kind == "pane":
        return {"baseColor": (1.0,) * 3, "specTrans": 1.0, "thin": True, "roughness": 0.0}
    if look.mask:
        scatters = {} if body.kind == "glass" else {"scatterDistance": (0.1,) * 3}  # unions have no walls within
        return {"baseColor": (0.5,) * 3, "opacity": body.material.get("opacity", 1.0), **scatters}
    color = (1.0,) * 3 if look.white else (0.9, 0.6, 0.3)
    spread = (1.0,) * 3 if look.white else (1.0, 0.6, 0.4)
    distance = tuple(look.distance * s for s in spread)
    if body.kind == "matt":
        values = {"baseColor": color if look.white else (0.0,) * 3, "specular": 0.0, "roughness": 0.5}
    elif body.kind == "opaque body":
        values = {"baseColor": color, "specular": 0.0, "roughness": 0.5, "scatterDistance": distance}
    else:
        values = {"baseColor": (1.0,) * 3, "specTrans": 1.0, "ior": body.ior, "roughness": look.clear_roughness}
    if body.kind == "cloudy body":
        values.update(baseColor=color, scatterDistance=tuple(4 * d for d in distance))
    if body.stained:
        stain = (1.0,) * 3 if look.white else (0.9, 0.5, 0.2)
        values.update(coat=1.0, coatRoughness=0.3, coatIor=1.8, coatColor=stain, coatDarkening=1.0)
    values.update(body.material)
    if values.pop(BY_FREE_PATH, False) and "scatterDistance" in values:
        values["meanFreePath"] = values.pop("scatterDistance")
    return values


def nodes_of(body, look):
    nodes = {"surface": material_of(body, look)}
    if body.bumped:
        nodes["surface"]["normal"] = ("bumps", "rgb")
        nodes["bumps"] = {"type": "AlabasterTexture", "file": str(images() / "normals.png"), "sourceColorSpace": "raw",
                          "scale": (2.0, 2.0, 2.0, 1.0), "bias": (-1.0, -1.0, -1.0, 0.0)}
    if body.weighted:
        nodes["surface"]["subsurfaceWeight"] = ("weights", "r")
        nodes["weights"] = {"type": "AlabasterTexture", "file": str(images() / "weights.png"), "sourceColorSpace": "raw",
                            "filter": "nearest"}
    if body.displaced:
        nodes["relief"] = {"type": "AlabasterDisplacement", "displacement": ("heights", "r"), "scale": 0.12}
        nodes["heights"] = {"type": "AlabasterTexture", "file": str(images() / "heights.png"), "sourceColorSpace": "raw"}
    return nodes


def bake(points, normals, place):
    """The points where the placement has them, and their normals."""
    def apply(m, values, w):
        return np.float32((np.c_[np.float64(values), np.full(len(values), w)] @ m)[:, :3])
    turned = apply(np.linalg.inv(place).T, normals, 0.0)
    return apply(place, points, 1.0), turned / np.linalg.norm(turned, axis=1, keepdims=True)


def add_body(scene, body, draft, look):
    material, world = body.path + "_look", WAYS[look.way]
    scene.set_material(material, nodes=nodes_of(body, look), displacement="relief" if body.displaced else "")
    given, primvars = {"material": material}, {}
    if body.shape in SHAPES:
        points, quads = SHAPES[body.shape]()
        normals = np.ones_like(points)  # of no use: its faces are flat
    else:
        points, quads, normals, uvs = ball(8 if body.displaced else 32, body.hollow)
        primvars["st"] = hdalabaster.Primvar(uvs, "faceVarying", role="textureCoordinate")
    given["subsets"] = {}
    if body.labelled:
        # In white scenes a mirror: a diffuse lobe keeps .3 % of the light at some angles, and walks meet a label again and again.
        label = {"metallic": 1.0, "roughness": 0.0} if look.white and not look.mask else {"specular": 0.0}
        color = (0.5,) * 3 if look.mask else (1.0,) * 3 if look.white else (0.3, 0.6, 0.9)
        scene.set_material(body.path + "_label", baseColor=color, **label)
        given["subsets"][body.path + "_label"] = np.int32(np.flatnonzero(points[quads].mean(axis=1)[:, 0] > 0.3))
    if body.inner is not None:
        inner_points, inner_quads, inner_normals, inner_uvs = ball(32, False)
        if body.shape == "pyramid":
            inner_quads = np.concatenate([inner_quads[:, :3], inner_quads[:, [0, 2, 3]]])
        inner_points, inner_normals = bake(inner_points, inner_normals, body.inner)
        scene.set_material(body.path + "_inner", **material_of(Body("matt"), look))
        given["subsets"][body.path + "_inner"] = np.int32(range(len(quads), len(quads) + len(inner_quads)))
        quads = np.concatenate([quads, inner_quads + len(points)])
        points, normals = np.concatenate([points, inner_points]), np.concatenate([normals, inner_normals])
        if "st" in primvars:
            primvars["st"] = hdalabaster.Primvar(np.concatenate([uvs, inner_uvs]), "faceVarying", role="textureCoordinate")
    if body.set:
        primvars["subsurfaceSet"] = hdalabaster.Primvar(body.set, "constant")

    # Heights are in the mesh's own space, so only what keeps lengths may go into its points.
    place = body.place @ (SHEAR if draft.shear else np.eye(4))
    if look.way == "copies" and not (body.displaced and draft.shear):
        points, normals = bake(points, normals, place)
        place = np.eye(4)
    if body.displaced:
        given.update(scheme="catmullClark", refine_level=3)
    elif body.shape not in SHAPES:
        primvars["normals"] = normals
    motion = swing(np.eye(4), world) if draft.moves else None
    if draft.shear or look.way == "array":
        others = [moved(0.2 * (i % 91) - 9, 0.2 * (i // 91) - 9, -100, 0.02) for i in range(1, ARRAY)] if look.way == "array" else []
        given["instancer"] = body.path + "_instances"
        transforms = np.array([place, *others])
        stands = {"motion": motion} if motion else {"transform": world}
        scene.set_instancer(given["instancer"], {body.path: range(len(transforms))}, transforms=transforms, **stands)
    elif motion:
        given["motion"] = swing(place, world)
    else:
        given["transform"] = place @ world
    scene.set_mesh(body.path, points, quads, primvars=primvars, categories=["bodies"], **given)


def swing(place, world):
    return [(0.0, place @ moved(-0.1, 0, 0) @ world), (1.0, place @ moved(0.1, 0.05, 0) @ world)]


def replace_inner(draft, how):
    """What "ball within" puts into the main body is what Look.within says instead."""
    inner = next(body for body in draft.bodies if body.path == WITHIN)
    if how == "same":
        inner.kind, inner.material, inner.ior = draft.main.kind, draft.main.material, draft.main.ior
    else:
        draft.bodies.remove(inner)
    if how == "faces":
        draft.main.inner = inner.place @ np.linalg.inv(draft.main.place)


def reorder(draft, scene):
    """The last body becomes the first, by its name and by when it is given. 255 others, far away, lie between each two."""
    draft.bodies.reverse()
    for i, body in enumerate(draft.bodies):
        body.path = f"/{i:02}" + body.path[1:]
        for k in range(255 if i else 0):
            scene.set_mesh(f"/{i - 1:02}z{k:03}", *box(), transform=moved(0, 0, -50 - 0.01 * k - 5 * i, 1e-3))


def bounds(draft):
    """The box of the bodies, wherever they move."""
    reach = 1.06 if draft.main.displaced else 1.0
    points = ball(8, False)[0] * np.float32(reach)
    corners = []
    for body in draft.bodies:
        shape = SHAPES[body.shape]()[0] if body.shape in SHAPES else points
        shape = np.c_[shape, np.ones(len(shape))] @ body.place @ (SHEAR if draft.shear else np.eye(4))
        ways = [m for _, m in swing(np.eye(4), np.eye(4))] if draft.moves else [np.eye(4)]
        corners += [(shape @ m)[:, :3] for m in ways]
    corners = np.concatenate(corners)
    return corners.min(axis=0), corners.max(axis=0)


def scene_of(scenery, look):
    """A scene without lights, and its camera as render() takes it."""
    draft, scene = scenery.draft(), hdalabaster.Scene()
    if look.within != "ball":
        replace_inner(draft, look.within)
    if look.way == "reordered":
        reorder(draft, scene)
    for body in draft.bodies:
        if look.flat:
            body.place = body.place @ SQUASH
        add_body(scene, body, draft, look)
    camera = camera_of(draft)
    return scene, {**camera, "transform": placed(camera["transform"], look.way)}


def camera_of(draft, direction=VIEW, film=FILM):
    near = draft.near
    if near and draft.main.kind != "opaque body":
        # All rays begin in it, since radiance there is another than in air, and none is reflected inside without end.
        near, film = near + 0.3, 0.8
    camera = {"transform": look_at(direction), "projection": "orthographic", "horizontalAperture": film, "verticalAperture": film}
    if draft.inside:  # in the main body, between its middle and its far side
        camera = {"transform": look_at(direction, 0.0, -0.7 * np.array(direction) / np.linalg.norm(direction)),
                  "focalLength": 1.0, "horizontalAperture": 2.0, "verticalAperture": 2.0}
    if draft.near:
        camera["clippingRange"] = (0.2 if draft.inside else near, 100.0)
    if draft.moves:
        camera.update(shutterOpen=0.0, shutterClose=1.0)
    return camera
