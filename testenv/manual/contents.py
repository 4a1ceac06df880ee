#!/usr/bin/env python3
"""Four models of what stands in media, each with a render description beside it: a tumbler of thin milk with straw and ice, fruit in
jelly, an insect in amber, and a hand with bones before a lamp. figures.py makes the figure of delegate/manual/artists.md of them.

  contents.py FOLDER [--only NAME]
  alabaster render FOLDER/milk.json -o milk.png --spp 256 --denoise
  testenv/benchmark/peers/peers.py --scene FOLDER/milk.json     # beside Cycles

Modelled in millimetres, y up; written in metres. Descriptions for Cycles, which knows no subsurfaceSet, lack that of the hand: NAME_alone.json.
"""
import argparse
import json
import math
import pathlib
import random
import sys

HERE = pathlib.Path(__file__).resolve().parent
sys.path[:0] = [str(HERE.parent / "scenes"), str(HERE.parent / "benchmark/peers")]
from formulas import exact_alpha, mean_free_path  # noqa: E402
from gltf_writer import Document, Mesh  # noqa: E402
from implicit import SurfaceNet, cone_chain, curve, ellipsoid, smooth_max, smooth_min  # noqa: E402
from scatter_distances import root  # noqa: E402
from shapes import backdrop, box, cube_sphere, lathe, noise, placed  # noqa: E402

MM = 0.001


def metres(mesh):
    mesh.points = [tuple(MM * c for c in p) for p in mesh.points]
    return mesh


def ball(centre, radii, n=6):
    return cube_sphere(n, lambda d: tuple(c + r * x for c, r, x in zip(centre, radii, d)))


def net(body, low, high, cell):
    return SurfaceNet(body, low, high, cell).mesh()


def medium(scattering, absorption, ior):
    """Behind a smooth clear wall; per mm, the absorption of each channel."""
    albedos = [root(lambda a, s=scattering / (scattering + absorbed): exact_alpha(a) - s, 0, 1) for absorbed in absorption]
    distances = [MM / (scattering + absorbed) / mean_free_path(albedo, 1) for absorbed, albedo in zip(absorption, albedos)]
    return {"baseColor": albedos, "scatterDistance": distances, "ior": ior, "specTrans": 1.0, "roughness": 0.0}


def glass(ior, **more):
    return {"baseColor": [1, 1, 1], "specTrans": 1.0, "roughness": 0.0, "ior": ior, **more}


def matt(color, roughness=0.4, **more):
    return {"baseColor": color, "roughness": roughness, **more}


def lamp(name, position, target, intensity, size, color=(1, 1, 1)):
    return {"name": name, "type": "rectLight", "position": [MM * c for c in position], "target": [MM * c for c in target],
            "intensity": intensity, "width": MM * size, "height": MM * size, "color": list(color), "visibleToCamera": False}


def sky(intensity, color=(1, 1, 1)):
    return {"name": "sky", "type": "domeLight", "intensity": intensity, "color": list(color), "visibleToCamera": False}


def camera(eye, target, focal):
    return {"lookAt": {"eye": [MM * c for c in eye], "target": [MM * c for c in target]}, "focalLength": focal,
            "horizontalAperture": 24, "verticalAperture": 24}


def floor(color, size=1.0):
    return "floor", backdrop(), matt(color, 0.6), placed(size=size)


def milk():
    """Thin milk: a straw and ice fade into it. The tumbler outranks the milk, which reaches into its wall, and the ice outranks both."""
    outer, inner = [(27, 0), (29.5, 1), (31, 4), (34.5, 50), (37.5, 98), (37.2, 100)], [(36.0, 100), (35.6, 98), (32.7, 50), (29.5, 9), (27, 7.5)]
    tumbler = lathe(outer + inner, sides=32)
    drink = lathe([(26, 7.0), (30.3, 9), (33.4, 50), (35.0, 77.5), (34.9, 78.0), (33, 78)], sides=32)
    straw = lathe([(2.6, 0), (2.6, 3), (2.6, 75), (2.6, 147), (2.6, 150), (2.2, 150), (2.2, 147), (2.2, 75), (2.2, 3), (2.2, 0.4)], sides=16)
    cubes = [(-12, 66, 9, 0.5, 0.35), (12, 64, 14, -0.3, -0.3), (-3, 67, -15, 1.2, 0.2)]
    things = [floor([0.24, 0.33, 0.42]), ("tumbler", metres(tumbler), glass(1.5, priority=1), None),
              ("milk", metres(drink), medium(0.05, (0.0002, 0.0005, 0.0012), 1.35), None),
              ("straw", metres(straw), matt([0.75, 0.05, 0.05], 0.25), placed(0.35, 0.24, at=(-0.016, 0.012, 0.004)))]
    things += [(f"ice{k}", metres(box(21, 21, 21, 3)), glass(1.31, priority=2), placed(turn, lean, at=(MM * x, MM * y, MM * z)))
               for k, (x, y, z, turn, lean) in enumerate(cubes)]
    lights = [lamp("window", (-420, 420, 260), (0, 60, 0), 7.0, 420, (1, 0.96, 0.9)), lamp("behind", (330, 260, -330), (0, 60, 0), 6.0, 300), sky(0.35)]
    return things, lights, camera((0, 190, 430), (0, 66, 0), 60)


def jelly():
    """A moulded jelly with cherries, blueberries, grapes and wedges of orange."""
    def flutes(angle, k, radius):
        return radius * (1 + 0.05 * math.cos(8 * angle) * min(1.0, k / 2) * (k < 7))
    body = lathe([(50, 0), (52, 2), (51.5, 9), (48, 26), (43, 42), (38.5, 49), (31, 52.5), (16, 52), (4, 51)], sides=48, radius_of=flutes)
    things = [floor([0.8, 0.79, 0.76]), ("jelly", metres(body), medium(0.008, (0.002, 0.03, 0.022), 1.36), None),
              ("plate", metres(lathe([(40, -6), (70, -4), (80, 0.5), (79, 1.2), (68, -1.5), (20, -1.5)], sides=48)), matt([0.85, 0.87, 0.9], 0.15),
               placed(at=(0, 0.0062, 0)))]
    things[1] = (*things[1][:3], placed(at=(0, 0.0048, 0)))
    looks = {"cherry": matt([0.45, 0.012, 0.02], 0.2), "blueberry": matt([0.045, 0.055, 0.17], 0.45),
             "grape": {"baseColor": [0.62, 0.72, 0.25], "roughness": 0.3, "scatterDistance": [0.003, 0.0035, 0.0012]},
             "orange": {"baseColor": [0.95, 0.45, 0.05], "roughness": 0.4, "scatterDistance": [0.004, 0.0015, 0.0006]}}
    chance, taken = random.Random(5), []
    for k, (kind, size) in enumerate([("cherry", 9.5)] * 4 + [("grape", 9.0)] * 4 + [("blueberry", 6.0)] * 7):
        for _ in range(2000):
            angle, height = chance.uniform(0, 2 * math.pi), chance.uniform(size + 7, 50 - size)
            reach = (46 - 0.25 * height) - size - 5
            radius = reach * math.sqrt(chance.uniform(0.25, 1))
            at = (radius * math.cos(angle), height, radius * math.sin(angle))
            if all(math.dist(at, q) > size + r + 1.0 for q, r in taken):
                taken.append((at, size))
                things.append((f"{kind}{k}", metres(ball(at, (size, 0.95 * size, size))), looks[kind], None))
                break
    def wedge(p):
        disk = smooth_max(math.hypot(p[0], p[1]) - 15, abs(p[2]) - 3.2, 2.0)
        return smooth_max(disk, -p[1] - 1, 1.5)
    for k, (turn, at) in enumerate([(0.2, (2, 24, 31)), (2.4, (27, 22, 14)), (4.1, (-27, 24, 12))]):
        if all(math.dist(at, q) > 0 for q, _ in taken):
            things.append((f"orange{k}", metres(net(wedge, (-18, -4, -6), (18, 18, 6), 1.5)), looks["orange"], placed(turn, 0.3, at=tuple(MM * c for c in at))))
    lights = [lamp("back", (180, 300, -380), (0, 25, 0), 10.0, 320, (1, 0.95, 0.88)), lamp("key", (-380, 330, 260), (0, 25, 0), 4.0, 380), sky(0.3)]
    return things, lights, camera((0, 165, 400), (0, 24, 0), 62)


def insect(p):
    """A gnat of 13 mm along x: head, thorax, abdomen, feelers, six legs."""
    x, y, z = p[0], p[1], abs(p[2])
    q = (x, y, z)
    d = ellipsoid(q, (5.0, 0.4, 0), (1.15, 1.1, 1.0))
    d = smooth_min(d, ellipsoid(q, (2.6, 0.8, 0), (1.9, 1.6, 1.35)), 0.5)
    d = smooth_min(d, cone_chain(q, [(1.2, 0.6, 0, 0.7), (-1.0, 0.2, 0, 1.25), (-4.0, -0.4, 0, 1.05), (-7.2, -1.3, 0, 0.3)]), 0.6)
    d = smooth_min(d, ellipsoid(q, (5.5, 0.7, 0.75), (0.6, 0.6, 0.5)), 0.1)
    for chain in LIMBS:
        d = smooth_min(d, cone_chain(q, chain), 0.15)
    return d


LIMBS = [curve([(3.6, -0.3, 0.7, 0.26), (5.2, 0.9, 2.6, 0.24), (6.2, -2.0, 4.2, 0.22), (7.2, -3.2, 5.0, 0.2)], 2),
         curve([(2.6, -0.4, 0.8, 0.26), (2.4, 1.4, 3.4, 0.24), (1.8, -1.9, 5.4, 0.22), (2.4, -3.6, 6.6, 0.2)], 2),
         curve([(1.6, -0.3, 0.7, 0.26), (-0.6, 1.6, 3.0, 0.24), (-3.4, -1.2, 4.8, 0.22), (-4.6, -3.2, 5.8, 0.2)], 2),
         curve([(5.8, 0.9, 0.3, 0.22), (7.2, 1.9, 0.9, 0.2), (8.4, 1.9, 1.5, 0.2)], 2)]


def wing(p):
    """A blade about the x axis, 9 mm long."""
    return ellipsoid(p, (-4.5, 0, 0), (5.0, 0.16, 1.7))


def amber():
    def stone(d):
        x, y, z = d
        bump = 1 + 0.10 * (noise(2.2 * x + 5, 2.2 * y + 2 * z + 5, 3) - 0.5) + 0.06 * (noise(4 * z + 9, 4 * x - 3 * y + 9, 8) - 0.5)
        return (21 * x * bump, 15 * y * bump, 11 * z * bump)
    things = [floor([0.5, 0.47, 0.43]),
              ("amber", metres(cube_sphere(16, stone)), medium(0.012, (0.003, 0.022, 0.11), 1.54), placed(0.25, 0.12, at=(0, 0.0142, 0))),
              ("gnat", metres(net(insect, (-8.5, -5, -8), (10, 4, 8), 0.28)), matt([0.03, 0.018, 0.01], 0.35), placed(0.5, 0.35, at=(0.001, 0.015, 0.001)))]
    for k, turn in enumerate((0.85, 0.2)):
        things.append((f"wing{k}", metres(net(wing, (-10.5, -0.8, -2.4), (1, 0.8, 2.4), 0.2)), matt([0.25, 0.16, 0.08], 0.3, opacity=0.45),
                       placed(turn, 0.62 - 0.5 * k, at=(0.003, 0.0165 + 0.0004 * k, 0.0005))))
    lights = [lamp("back", (110, 210, -260), (0, 14, 0), 16.0, 220, (1, 0.95, 0.88)), lamp("key", (-220, 220, 190), (0, 14, 0), 5.0, 240), sky(0.25)]
    return things, lights, camera((0, 62, 170), (0, 13.5, 0), 74)


# Joints (x, y, z, radius) of each finger, from the wrist's side; bones lie between them.
FINGERS = [[(-17, 44, 2, 10), (-25, 86, 4, 9.2), (-29, 112, 5, 8.2), (-31, 133, 5, 7.0)],
           [(-5, 46, 2, 10), (-6, 93, 5, 9.4), (-6.5, 122, 6, 8.4), (-7, 146, 6, 7.0)],
           [(7, 45, 2, 10), (12, 88, 4, 9.2), (15, 115, 5, 8.2), (17, 137, 5, 6.9)],
           [(18, 40, 1, 9.5), (28, 78, 3, 8.2), (34, 98, 4, 7.2), (38, 115, 4, 6.2)],
           [(-20, 10, 4, 12), (-38, 34, 8, 10.5), (-52, 54, 10, 9.2), (-61, 70, 10, 7.6)]]


def hand(p):
    d = smooth_min(ellipsoid(p, (0, 24, 0), (33, 36, 13)), cone_chain(p, [(0, -5, 0, 22), (0, -60, 0, 21)]), 24)
    for finger in FINGERS:
        d = smooth_min(d, cone_chain(p, finger), 7)
    return smooth_max(d, -52 - p[1], 3)


def bones(p):
    d = smooth_min(cone_chain(p, [(-9, -70, 0, 5.5), (-10, -12, 0, 6.5)]), cone_chain(p, [(9, -70, 0, 4.5), (9, -12, 0, 5.0)]), 1)
    d = max(d, -49 - p[1])
    for k in range(4):
        d = min(d, ellipsoid(p, (-13 + 8.8 * k, -2, 0), (5.4, 6.5, 5.4)))
    for finger in FINGERS:
        joints = [(finger[0][0] * 0.75, 8 if finger[0][1] > 20 else 0, 0, 10), *finger]
        for a, b in zip(joints, joints[1:]):
            t = [0.07, 0.2, 0.5, 0.8, 0.93]
            shape = [0.42, 0.30, 0.25, 0.30, 0.40]
            part = [tuple(u + s * (v - u) for u, v in zip(a[:3], b[:3])) + (w * (a[3] + b[3]) / 2,) for s, w in zip(t, shape)]
            d = min(d, cone_chain(p, part))
    return d


def backlit_hand():
    """Skin has a diffuse wall, and bones are of its subsurfaceSet."""
    skin = {"baseColor": [0.97, 0.76, 0.66], "roughness": 0.45, "ior": 1.4, "scatterDistance": [0.014, 0.005, 0.003]}
    things = [("skin", metres(net(hand, (-74, -56, -28), (50, 158, 28), 4.0)), skin, None),
              ("bones", metres(net(bones, (-70, -52, -12), (46, 152, 18), 2.0)), matt([0.1, 0.07, 0.05], 0.6), placed(at=(0, 0, 0.003)))]
    lights = [lamp("behind", (0, 60, -150), (0, 60, 0), 8.0, 260, (1, 0.93, 0.85)), sky(0.03, (0.7, 0.8, 1.0))]
    return things, lights, camera((30, 60, 520), (-6, 55, 0), 52)


SCENES = {"milk": milk, "jelly": jelly, "amber": amber, "hand": backlit_hand}


def write(folder, name):
    things, lights, view = SCENES[name]()
    document = Document("Alabaster contents.py")
    for part, mesh, look, place in things:
        document.add_node(part, document.add_mesh(part, mesh, document.add_material(part, look)), place)
    document.write_glb(folder / f"{name}.glb")
    scene = {"gltf": [{"file": f"{name}.glb", "refineLevel": 2}], "lights": lights, "camera": view,
             "settings": {"resolution": [300, 300], "samples": 128, "studio": "off", "maxDepth": 64}}
    if name == "hand":
        (folder / "hand_alone.json").write_text(json.dumps(scene, indent=1) + "\n")
        scene["meshes"] = [{"match": "*", "subsurfaceSet": "hand"}]
    (folder / f"{name}.json").write_text(json.dumps(scene, indent=1) + "\n")
    return folder / f"{name}.json"


if __name__ == "__main__":
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--only", choices=SCENES)
    given = parser.parse_args()
    given.folder.mkdir(parents=True, exist_ok=True)
    for chosen in [given.only] if given.only else SCENES:
        write(given.folder, chosen)
