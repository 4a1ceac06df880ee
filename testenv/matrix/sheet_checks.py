"""Sheets and metals: their scenes, and what must hold of them. A sheet is a square without an end, as seen from its middle."""
import math
from typing import NamedTuple

import hdalabaster
import numpy as np

from body_checks import CEILING, FURNACE, SKY, LayersAddUp
from features import box, look_at
from measure import Series, Verdict, picture, renderer_of, same, same_bytes, within

FEATURES = {  # of a sheet: parameters that turn it on, and those that make it vanish
    "thin": ({"thin": True}, []),
    "diffTrans": ({"diffTrans": 1.0}, [{"diffTrans": 1e-4}]),
    "specTrans": ({"specTrans": 0.5}, [{"specTrans": 1e-4}]),
    "film": ({"iridescence": 1.0}, [{"iridescence": 1e-4}, {"iridescenceThickness": 0.0}, {"iridescenceIor": 1.0}]),
    "anisotropic": ({"anisotropic": 0.9}, [{"anisotropic": 1e-4}]),
    "coat": ({"coat": 1.0, "coatRoughness": 0.4}, [{"coat": 1e-4}, {"coatIor": 1.0}]),
    "sheen": ({"sheen": 1.0, "sheenRoughness": 0.4}, [{"sheen": 1e-4}]),
    "diffuse roughness": ({"diffuseRoughness": 1.0}, [{"diffuseRoughness": 0.6001}]),
    "transparent": ({"opacityMode": "transparent", "opacity": 0.4}, [{"opacity": 0.9999}]),
}
OF_METALS = ("film", "anisotropic", "coat", "sheen")
CORNERS = np.float32([(-50, -50, 0), (50, -50, 0), (50, 50, 0), (-50, 50, 0)])
ST = np.float32([(0, 0), (1, 0), (1, 1), (0, 1)])
LEAST = 0.5  # layers and rough facets of sheets keep some of the light: printed


class Sheet(NamedTuple):
    """`more` are parameters beside those of the features."""
    metal: bool
    features: tuple
    more: tuple = ()

    @property
    def name(self):
        more = tuple(f"{k} {v}" for k, v in self.more)
        return " + ".join((("metal" if self.metal else "sheet"),) + self.features + more)

    def has(self, *features):
        return any(f in self.features for f in features)

    @property
    def passes(self):
        return self.has("diffTrans", "specTrans")

    @property
    def is_whole(self):
        """False for the boundary of a solid that has no other side: light behind it has the radiance of light in glass."""
        return not self.has("specTrans") or self.has("thin")

    def material(self, white=True, **changes):
        color = (1.0,) * 3 if white else (0.6, 0.4, 0.2)
        values = {"baseColor": color, "diffTransColor": color, "roughness": 0.6, "metallic": 1.0 if self.metal else 0.0}
        for feature in self.features:
            values.update(FEATURES[feature][0])
        return {**values, **dict(self.more), **changes}

    def without(self, feature):
        return Sheet(self.metal, tuple(f for f in self.features if f != feature), self.more)


def at(degrees, azimuth=0.3, side=1):
    a = math.radians(degrees)
    return np.array([math.sin(a) * math.cos(azimuth), math.sin(a) * math.sin(azimuth), side * math.cos(a)])


def scene_of(material):
    scene = hdalabaster.Scene()
    scene.set_material("/look", **material)
    st = hdalabaster.Primvar(ST, "vertex", role="textureCoordinate")
    scene.set_mesh("/sheet", CORNERS, np.int32([[0, 1, 2, 3]]), material="/look", primvars={"st": st}, categories=["sheet"])
    return scene


def eye(direction, film=1e-3):
    return {"transform": look_at(direction, 0.5), "projection": "orthographic", "horizontalAperture": film, "verticalAperture": film}


def ways(sheet, degrees_=(10, 60, 85)):
    azimuths = (0.0, 0.8, math.pi / 2) if sheet.has("anisotropic") or dict(sheet.more).get("anisotropic") else (0.3,)
    sides = (1, -1) if not sheet.metal else (1,)
    return [(degrees, azimuth, side) for degrees in degrees_ for azimuth in azimuths for side in sides]


def albedos(sheet, energy, along, spp=256):
    """The light that viewers along these ways see of a white sheet in a sky of 1, drawn by seed."""
    scene = scene_of(sheet.material())
    scene.set_light("/sky", "domeLight", **SKY)
    renderer = renderer_of(scene, samples=spp, energy=energy)

    def one(seed):
        renderer.set(seed=seed)
        return np.array([picture(renderer, eye(at(*way)), 4).mean() for way in along])
    return one


class SheetViewer:
    """A white sheet or metal in a sky of 1: with energy `conserving`, metal without layers shows 1, and nothing shows more."""
    name = "furnace, viewer"

    @staticmethod
    def asks(sheet):
        return sheet.is_whole

    @staticmethod
    def run(sheet):
        lossless = sheet.metal and not sheet.has("film", "coat", "sheen")
        return within(albedos(sheet, "conserving", ways(sheet)), 1 - FURNACE if lossless else LEAST, CEILING, seeds=(6, 12, 24))


class SheetBounded:
    """With energy `bounded` nothing shows more than 1.001."""
    name = "furnace, viewer, bounded"

    @staticmethod
    def asks(sheet):
        return sheet.is_whole

    @staticmethod
    def run(sheet):
        return within(albedos(sheet, "bounded", ways(sheet)), 0.0, 1.001, seeds=(6, 12, 24))


def meter(scene, side):
    """A small sheet that faces the middle of the large one, and passes its light outwards as Lambert's law has it."""
    size = 0.002
    z = 0.4 * side
    scene.set_material("/meter", baseColor=(0, 0, 0), specular=0.0, diffTrans=2.0, diffTransColor=(1, 1, 1), thin=True)
    scene.set_mesh(f"/meter{side}", np.float32([(x * size, y * size, z) for x, y in ((-1, -1), (1, -1), (1, 1), (-1, 1))]),
                   np.int32([[0, 1, 2, 3]]), material="/meter", categories=["meter"])
    return eye((0, 0, side), size / 2)


class SheetLight:
    """A white sheet sends on, to both sides together, as much of the light from one direction as a viewer sees from there in a sky of 1,
    and at most all."""
    name = "furnace, light"

    @staticmethod
    def asks(sheet):
        return sheet.is_whole and not sheet.more and "transparent" not in sheet.features  # parallel light that goes straight on meets no eye

    @staticmethod
    def run(sheet):
        scene = scene_of(sheet.material())
        cameras = {side: meter(scene, side) for side in (1, -1)}
        renderer = renderer_of(scene, samples=16384, energy="conserving")  # one pixel: its samples are well distributed
        along = ways(sheet, (10, 60, 80))
        viewer = Series(albedos(sheet, "conserving", along), 7000)
        viewer.extend(12)
        seen = viewer.mean

        def one(seed):
            renderer.set(seed=seed)
            total = []
            for way in along:
                scene.set_light("/sun", "distantLight", look_at(at(*way)), angle=0.0,
                                intensity=1 / abs(math.cos(math.radians(way[0]))), lightLink="sheet", shadowLink="sheet")
                sides = (1, -1) if sheet.passes else (way[2],)
                total.append(math.pi * sum(picture(renderer, cameras[side], 1).mean() for side in sides))
            return np.array(total) / np.minimum(seen, 1.0)
        return within(one, 1 - FURNACE, CEILING, error=0.003, seeds=(6, 12, 24, 96))


class SheetReciprocity:
    """f(a, b) = f(b, a), for light that is reflected and for light that is passed."""
    name = "reciprocity"
    RULE = 0.01

    @staticmethod
    def asks(sheet):
        return True

    @staticmethod
    def seen(sheet, eye_at, sun_at):
        scene = scene_of(sheet.material(white=False))
        scene.set_light("/sun", "distantLight", look_at(sun_at), intensity=1 / abs(sun_at[2]), angle=0.0)
        renderer = renderer_of(scene, samples=1, maxDepth=1)
        return picture(renderer, eye(eye_at), 2).mean(axis=(0, 1))

    @classmethod
    def run(cls, sheet):
        pairs = [(at(10), at(80, 2.0)), (at(30, 0.1), at(65, -1.0)), (at(10, side=-1), at(80, 2.0, -1))]
        if sheet.passes and sheet.is_whole:
            pairs += [(at(10), at(80, 2.0, -1)), (at(65), at(20, 1.0, -1))]
        worst, text = 0.0, ""
        for a, b in pairs:
            there, back = cls.seen(sheet, a, b), cls.seen(sheet, b, a)
            if max(there.max(), back.max()) < 1e-6:
                continue
            off = np.abs(there / np.maximum(back, 1e-9) - 1).max()
            if off >= worst:
                worst, text = off, f"ratio {float((there / np.maximum(back, 1e-9))[0]):.4f}, {'passed' if a[2] * b[2] < 0 else 'reflected'}"
        return Verdict(bool(worst <= cls.RULE), float(worst / cls.RULE), text)


class Vanishing:
    """A feature whose strength goes to 0 leaves the picture that is without it, on both sides."""
    name = "a feature that vanishes"
    RULE = 0.005

    @staticmethod
    def asks(sheet):
        return any(FEATURES[f][1] for f in sheet.features) and not {"specTrans", "transparent"} <= set(sheet.features)  # opacity decides specTrans

    @staticmethod
    def draw(material, side):
        scene = scene_of(material)
        scene.set_light("/sky", "domeLight", intensity=1.0)
        renderer = renderer_of(scene, samples=1024)

        def one(seed):
            renderer.set(seed=seed)
            return np.concatenate([picture(renderer, eye(at(d, 0.3, side)), 2).mean(axis=(0, 1)) for d in (20, 75)])
        return one

    @classmethod
    def run(cls, sheet):
        found = []
        for feature in sheet.features:
            for change in FEATURES[feature][1]:
                for side in (1, -1):
                    there = cls.draw(sheet.material(white=False, **change), side)
                    gone = cls.draw(sheet.without(feature).material(white=False), side)
                    verdict = same(there, gone, cls.RULE, seeds=(6, 12, 24))
                    found.append((verdict, f"{next(iter(change))} {next(iter(change.values()))}, {'front' if side > 0 else 'back'}: "))
        verdict, label = max(found, key=lambda f: (not f[0].holds, f[0].worst))
        return verdict._replace(text=label + verdict.text)


class Turning:
    """A box without texture coordinates, its light and the camera turned together show the same picture."""
    name = "turned as a whole"

    @staticmethod
    def asks(sheet):
        return sheet.has("anisotropic")

    @staticmethod
    def draw(sheet, turn):
        scene = hdalabaster.Scene()
        scene.set_material("/look", **sheet.material(white=False))
        points, quads = box()
        scene.set_mesh("/box", points, quads, material="/look", transform=turn)
        scene.set_light("/lamp", "rectLight", look_at((0.6, 0.8, 1.0), 6.0) @ turn, intensity=20.0, width=3.0, height=3.0)
        camera = {"transform": look_at((0.3, 0.5, 1.0)) @ turn, "projection": "orthographic", "horizontalAperture": 1.2,
                  "verticalAperture": 1.2}
        renderer = renderer_of(scene, samples=64)

        def one(seed):
            renderer.set(seed=seed)
            return picture(renderer, camera).mean()
        return one

    @classmethod
    def run(cls, sheet):
        axis = np.array((1.0, 2.0, 3.0)) / math.sqrt(14)
        k = np.cross(np.eye(3), axis)
        turn = np.eye(4)
        turn[:3, :3] = np.eye(3) + math.sin(1.3) * k + (1 - math.cos(1.3)) * k @ k
        return same(cls.draw(sheet, turn), cls.draw(sheet, np.eye(4)), 0.005, error=0.002)


def lit(sheet):
    scene = scene_of(sheet.material(white=False))
    scene.set_light("/sky", "domeLight", **SKY)
    scene.set_light("/lamp", "rectLight", look_at((0.4, 0.2, 1.0), 4.0), intensity=8.0, width=1.0, height=1.0)
    return scene, eye(at(40), 4.0)


class SheetAddsUp(LayersAddUp):
    @staticmethod
    def scene(sheet):
        return lit(sheet)


class SheetBytes:
    """One thread, two threads and a crop give the same bytes."""
    name = "crops and threads"

    @staticmethod
    def asks(sheet):
        return True

    @staticmethod
    def run(sheet):
        return same_bytes(lambda: lit(sheet))


CHECKS = (SheetViewer, SheetBounded, SheetLight, SheetReciprocity, Vanishing, Turning, SheetAddsUp, SheetBytes)
