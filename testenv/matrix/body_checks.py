"""Checks of scenes of bodies (features.py). A check is a class: `name`, `asks(scenery)`, which is False where it does not apply, and
`run(scenery)`, which gives a Verdict."""
import math

import numpy as np

import features
from features import LAYERS, SIDE, Look, look_at, placed, scene_of
from measure import SEEDS, Verdict, blocks, picture, renderer_of, same, same_blocks, same_bytes, same_noise, within

FURNACE = 0.003
CEILING = 1 + FURNACE
LOSSLESS = 1 - FURNACE
LAYERED = 0.85  # layers and rough facets keep some of the light: printed, and compared with Lambert where there is one
LAYERED_CLEAR = 0.5  # they keep some each time that light passes a boundary from within
SKY = {"intensity": 1.0, "visibleToCamera": True}
OPPOSITE = (-0.8, 0.4, 0.45)  # 63 degrees from z


def least(scenery):
    """The least that a white scene shows in a sky of 1."""
    if not scenery.any(*LAYERS):
        return LOSSLESS
    return LAYERED_CLEAR if scenery.kind != "opaque body" else LAYERED


def mean_by_seed(renderer, camera):
    def one(seed):
        renderer.set(seed=seed)
        return picture(renderer, camera).mean(axis=(0, 1))
    return one


class ViewerFurnace:
    """Each block of 4 x 4 pixels of a white scene under a sky of 1 shows 1, or the squared index of what the camera is in."""
    name = "furnace, viewer"

    @staticmethod
    def asks(scenery):
        # Clear bodies that are cut show two indices beside others, and where they are hollow. An opaque ball that is cut is dark inside.
        hollow = scenery.kind != "opaque body" and scenery.any("inner shell")
        return not (scenery.any("cut") and (hollow or scenery.any("ball within") or len(scenery.kinds) > 1))

    @staticmethod
    def draw(scenery, mode="walk"):
        scene, camera = scene_of(scenery, Look())
        scene.set_light("/sky", "domeLight", **SKY)
        # Walks below clear boundaries are noisy, and those in a shell that is cut.
        opaque = scenery.kind == "opaque body"
        cut_shell = "inner shell" in scenery.features and "cut" in scenery.features
        spp = 256 if opaque and cut_shell else 64 if opaque and scenery.clear else 16
        renderer = renderer_of(scene, samples=spp, subsurface=mode, energy="conserving")

        def one(seed):
            renderer.set(seed=seed)
            return blocks(picture(renderer, camera))
        return one

    @classmethod
    def run(cls, scenery):
        index = 1.5 if scenery.kind != "opaque body" and scenery.any("cut", "camera inside") else 1.0
        draw = cls.draw(scenery)
        return within(lambda seed: draw(seed) / index ** 2, least(scenery), CEILING)


class LambertFurnace:
    """A white opaque body under layers shows in a sky of 1 what Lambert shows below the same layers. (Below a specular lobe it is the
    lobe that yields to subsurface, and the diffuse lobe that yields to specular: delegate/manual/artists.md, "Energy".)"""
    name = "furnace, as Lambert"

    @staticmethod
    def asks(scenery):
        return (scenery.kinds == ("opaque body",) and scenery.any("coat", "stained coat", "fibre sheen", "clearcoat")
                and not scenery.any("cut", "camera inside", "normal map", "displacement", "union", "face to face", "rough specular"))

    @staticmethod
    def run(scenery):
        mean = [(lambda seed, draw=ViewerFurnace.draw(scenery, mode): draw(seed).mean()) for mode in ("walk", "lambert")]
        return same(*mean, rule=FURNACE, error=0.0005)


def distant(scene, direction, angle, way="as is", **links):
    """Light of a cone, or parallel light, whose irradiance is 1."""
    scene.set_light("/sun", "distantLight", placed(look_at(direction), way), intensity=1.0, angle=angle, normalize=True, **links)


def meter(scene, low, high):
    """A cube of six sheets around the scene, which pass light outwards alone, as Lambert's law has it, cameras that see one each,
    and the area of a sheet: pi times what a camera sees is the flux through the sheet by its area."""
    scene.set_material("/meter", baseColor=(0, 0, 0), specular=0.0, diffTrans=2.0, diffTransColor=(1, 1, 1), thin=True)
    half, cameras = float((high - low).max()) / 2 * 1.02, []
    for axis in range(3):
        for side in (-1.0, 1.0):
            frame = look_at(side * np.eye(3)[axis], half, (low + high) / 2)
            corners = np.float32([frame[3, :3] + half * (a * frame[0, :3] + b * frame[1, :3])
                                  for a, b in ((-1, -1), (1, -1), (1, 1), (-1, 1))])
            scene.set_mesh(f"/meter{axis}{side:+.0f}", corners, np.int32([[0, 1, 2, 3]]), material="/meter", categories=["meter"])
            frame[3, :3] += frame[2, :3]
            cameras.append({"transform": frame, "projection": "orthographic",
                            "horizontalAperture": 2 * half, "verticalAperture": 2 * half})
    return cameras, (2 * half) ** 2


class LightFurnace:
    """A white scene sends on, in all directions together, the light that comes to it from one direction. Where light passes clear
    boundaries it comes from a cone, which paths meet by chance."""
    name = "furnace, light"
    CONE = 100.0
    FILM = 3.4

    @staticmethod
    def asks(scenery):
        # Parallel light that a pane passes meets no eye.
        return not scenery.any("cut", "camera inside", "pane")

    @classmethod
    def met(cls, scenery, angle):
        """The area that the light meets, holes left out, within .1 %: the mean over the cone, by Gauss' points of sin^2. Areas of
        boxes have kinks, and need more of them than balls do."""
        scene, camera = scene_of(scenery, Look(mask=True))
        frame, area = look_at(features.VIEW), 0.0
        rings, turns = (8, 24) if any(body.shape in features.SHAPES for body in scenery.draft().bodies) else (3, 6)
        ways = [(0.0, 0.0, 1.0)]
        if angle:
            edge = math.sin(math.radians(angle / 2))
            ways = [(edge * math.sqrt((1 + x) / 2), 2 * math.pi * k / turns, w / 2 / turns)
                    for x, w in zip(*np.polynomial.legendre.leggauss(rings)) for k in range(turns)]
        renderer = renderer_of(scene, samples=max(8, 2048 // len(ways)), maxDepth=0)
        for r, turn, weight in ways:
            cosine = math.sqrt(1 - r * r)  # the irradiance is that of a plane across the light's axis
            way = frame[2, :3] * cosine + r * (math.cos(turn) * frame[0, :3] + math.sin(turn) * frame[1, :3])
            seen = dict(camera, transform=look_at(way), horizontalAperture=cls.FILM, verticalAperture=cls.FILM)
            area += picture(renderer, seen, 48, "alpha").mean() * cls.FILM ** 2 * weight / cosine
        return area

    @classmethod
    def run(cls, scenery):
        angle = cls.CONE if scenery.clear or scenery.any("label") else 0.0  # no eye meets the mirrored parallel light
        scene, camera = scene_of(scenery, Look())
        cameras, area = meter(scene, *features.bounds(scenery.draft()))
        distant(scene, features.VIEW, angle, lightLink="bodies", shadowLink="bodies")
        renderer = renderer_of(scene, samples=16, energy="conserving")
        given = cls.met(scenery, angle)
        shutter = {k: v for k, v in camera.items() if k.startswith("shutter")}

        def one(seed):
            renderer.set(seed=seed)
            return sum(picture(renderer, {**c, **shutter}).mean() for c in cameras) * math.pi * area / given
        return within(one, least(scenery), CEILING, error=0.003, seeds=(12, 24, 96))


class Reciprocity:
    """The light that a scene sends from one direction to another is what it sends the other way."""
    name = "reciprocity"
    RULE = 0.01

    @staticmethod
    def asks(scenery):
        return not scenery.any("cut", "camera inside")

    @staticmethod
    def draw(scenery, eye, sun):
        scene, camera = scene_of(scenery, Look(white=False, clear_roughness=1.0, flat=True))
        distant(scene, sun, 0.0)
        camera = dict(camera, transform=look_at(eye), horizontalAperture=3.4, verticalAperture=3.4)
        renderer = renderer_of(scene, samples=64 if scenery.clear else 16)

        def one(seed):
            renderer.set(seed=seed)
            return picture(renderer, camera).mean(axis=(0, 1))[:2]
        return one

    @classmethod
    def run(cls, scenery):
        error = 0.008 if scenery.clear or scenery.any("opacity") else 0.003
        return same(cls.draw(scenery, SIDE, OPPOSITE), cls.draw(scenery, OPPOSITE, SIDE), cls.RULE, error, (*SEEDS, 768))


class LambertLimit:
    """With scatterDistance at 1e-4 of the size a body looks as Lambert does below the same layers, lit by a key light."""
    name = "limit of small distances"
    RULE = 0.005

    @staticmethod
    def asks(scenery):
        return set(scenery.kinds) == {"opaque body"} and not scenery.any("cut", "camera inside")

    @staticmethod
    def draw(scenery, mode):
        scene, camera = scene_of(scenery, Look(white=False, distance=1e-4))
        distant(scene, SIDE, 60.0 if scenery.clear else 0.0)  # a drop shows a point of light as a glint that few paths meet
        scene.set_light("/sky", "domeLight", intensity=0.2)
        renderer = renderer_of(scene, samples=128 if scenery.any("below glass") else 16, subsurface=mode)
        return mean_by_seed(renderer, camera)

    @classmethod
    def run(cls, scenery):
        error = 0.002 if scenery.clear or scenery.any("opacity") else 0.001  # light goes in and out of holes and drops
        return same(cls.draw(scenery, "walk"), cls.draw(scenery, "lambert"), cls.RULE, error)


class WalkIsReference:
    """Walks with their shortcuts and walks without have the same means."""
    name = "walk and reference"

    @staticmethod
    def asks(scenery):
        return any(kind != "glass" for kind in scenery.kinds)

    @staticmethod
    def draw(scenery, mode):
        scene, camera = scene_of(scenery, Look(white=False, distance=0.2 if scenery.kind == "opaque body" else 0.05))
        scene.set_light("/sky", "domeLight", intensity=0.5, visibleToCamera=True)
        distant(scene, SIDE, 180.0)
        renderer = renderer_of(scene, samples=16, subsurface=mode)

        def one(seed):
            renderer.set(seed=seed)
            return blocks(picture(renderer, camera, 20), 2)
        return one

    @classmethod
    def run(cls, scenery):
        return same_noise(cls.draw(scenery, "walk"), cls.draw(scenery, "reference"))


LAYER_AOVS = ("diffuse", "subsurface", "specular", "emission")
PARTS = ("subsurfaceUnscattered", "subsurfaceSingle", "subsurfaceMultiple")


def lit(scenery, way="as is", within="ball"):
    scene, camera = scene_of(scenery, Look(white=False, way=way, within=within))
    scene.set_light("/sky", "domeLight", **SKY)
    scene.set_light("/lamp", "rectLight", placed(look_at(SIDE, 4.0), way), intensity=8.0, width=1.0, height=1.0)
    return scene, camera


def lit_blocks(scenery, way="as is", within="ball"):
    """Blocks of 4 x 4 pixels of the scene as it is written down so, and their mean, drawn by seed."""
    scene, camera = lit(scenery, way, within)
    distant(scene, (-0.8, 0.6, 0.7), 60.0 if scenery.clear else 0.0, way=way)
    renderer = renderer_of(scene, samples=16)

    def one(seed):
        renderer.set(seed=seed)
        pixels = picture(renderer, camera)
        each = blocks(pixels[:, ::-1] if way == "mirrored" else pixels)
        return np.append(each, each.mean())
    return one


class Turned:
    """The scene, its light and the camera turned together show the same picture."""
    name, way = "turned as a whole", "turned"

    @staticmethod
    def asks(scenery):
        return True

    @classmethod
    def run(cls, scenery):
        return same_blocks(lit_blocks(scenery, cls.way), lit_blocks(scenery, "as is"))


class AsArray(Turned):
    """Bodies that are each one of an array's instances show the picture of bodies that stand alone."""
    name, way = "as an array", "array"


class ContentAsFaces:
    """A black ball within a body is the same as opaque faces of the body's mesh."""
    name = "content as faces"

    @staticmethod
    def asks(scenery):
        # Heights would move those faces, too, and where a hollow cuts the ball, faces of one mesh cross each other.
        return scenery.kind != "opaque body" and "ball within" in scenery.features and not scenery.any("displacement", "inner shell")

    @staticmethod
    def run(scenery):
        return same_blocks(lit_blocks(scenery, within="faces"), lit_blocks(scenery))


class ContentOfTheSameMedium:
    """A ball of its own medium and index within a clear body changes nothing."""
    name = "content of the same medium"

    @staticmethod
    def asks(scenery):
        # The ball has its material's layers and holes, fills a hollow, stands out of other shapes, and its wall is tinted by a colour
        # beside the medium's.
        others = ("opacity", "inner shell", "below glass", "glass on its face", "weight", *LAYERS)
        return scenery.kind != "opaque body" and "ball within" in scenery.features and not scenery.any(*others)

    @staticmethod
    def run(scenery):
        return same_blocks(lit_blocks(scenery, within="same"), lit_blocks(scenery, within="none"))


class LightWithoutSize:
    """Parallel light shows what light of half a degree does, where nothing refracts: sheets pass it, holes and gaps as well."""
    name = "light without size"

    @staticmethod
    def asks(scenery):
        return not scenery.clear and not scenery.any("camera inside")  # where there is hardly any light

    @staticmethod
    def draw(scenery, angle):
        scene, camera = scene_of(scenery, Look(white=False))
        distant(scene, SIDE, angle)
        renderer = renderer_of(scene, samples=16)
        return mean_by_seed(renderer, camera)

    @classmethod
    def run(cls, scenery):
        error = 0.008 if scenery.any("cut", "opacity") else 0.003  # light walks through, or goes in and out of holes
        return same(cls.draw(scenery, 0.0), cls.draw(scenery, 0.5), 0.01, error, (*SEEDS, 768))


class LayersAddUp:
    """diffuse + subsurface + specular + emission = color, and the three parts of subsurface are it."""
    name = "AOVs add up"

    @staticmethod
    def asks(scenery):
        return True

    @staticmethod
    def scene(scenery):
        return lit(scenery)

    @classmethod
    def run(cls, scenery):
        scene, camera = cls.scene(scenery)
        renderer = renderer_of(scene, samples=8)
        render = renderer.render(width=12, height=12, camera=camera, aovs=["color", *LAYER_AOVS, *PARTS])
        layer = {name: np.array(render[name].numpy(), float)[..., :3] for name in ("color", *LAYER_AOVS, *PARTS)}
        off = [np.abs(sum(layer[n] for n in names) - layer[whole]).max() for names, whole in
               ((LAYER_AOVS, "color"), (PARTS, "subsurface"))]
        rule = 1e-5 * max(1.0, np.abs(layer["color"]).max())
        return Verdict(max(off) <= rule, max(off) / rule, f"off by {max(off):.1e} of {np.abs(layer['color']).max():.2f}")


class SameBytes:
    """One thread, two threads and a crop give the same bytes."""
    name = "crops and threads"

    @staticmethod
    def asks(scenery):
        return True

    @staticmethod
    def run(scenery):
        return same_bytes(lambda: lit(scenery))


CHECKS = (ViewerFurnace, LambertFurnace, LightFurnace, Reciprocity, LambertLimit, WalkIsReference, Turned, AsArray, ContentAsFaces,
          ContentOfTheSameMedium, LightWithoutSize, LayersAddUp, SameBytes)