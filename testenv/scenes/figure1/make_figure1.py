#!/usr/bin/env python3
"""Makes our version of Figure 1 of the paper (Chiang, Kutz, Burley 2016): normalized diffusion on the left, random walk on
the right; a slab lit through a mask above, a dragon of the same wax below. Writes figure1.jpg and figure1.md (the
differences between the slabs).

  python3 testenv/scenes/figure1/make_figure1.py --assets FOLDER [--spp N] [--program PATH] [--out FOLDER]

FOLDER of --assets holds sss/dragon_wax.glb (default: $ALABASTER_TEST_ASSETS). Needs oiiotool (openimageio-tools).
"""
import argparse
import math
import os
import pathlib
import re
import shutil
import subprocess
import sys

HERE = pathlib.Path(__file__).resolve().parent
ROOT = HERE.parents[2]
sys.path.insert(0, str(HERE.parent))
from gltf_writer import Document, Mesh  # noqa: E402


def quad_mesh(quads):
    mesh = Mesh()
    for quad in quads:
        first = len(mesh.points)
        mesh.points += quad
        mesh.quads.append(list(range(first, first + 4)))
        mesh.uvs.append([(0.0, 0.0)] * 4)
    return mesh


def rectangle(x0, x1, z0, z1, y):
    return [(x0, y, z1), (x1, y, z1), (x1, y, z0), (x0, y, z0)]


def write_stage(path):
    """A floor that sweeps up behind the dragon."""
    document = Document("Alabaster make_figure1.py")
    profile = [(40, 0), (10, 0), (-12, 0), (-26, 0), (-36, 3), (-42, 14), (-44, 40)]  # z, y
    floor = Mesh()
    floor.add_grid([[(x, y, z) for x in (-80, -20, 20, 80)] for z, y in profile])
    material = document.add_material("floor", {"baseColor": [0.06, 0.057, 0.055], "roughness": 0.45})
    document.add_node("floor", document.add_mesh("floor", floor, material))
    document.write_glb(path)


def write_slab(path):
    """A slab, and above the camera a mask with a round hole and bars from 1.6 down to 0.1 wide."""
    document = Document("Alabaster make_figure1.py")
    half, depth, height, edge = 20, 8, 10, 2
    slab = Mesh()
    slab.points = [(x * half, y, z * half) for y in (0, -depth) for z in (-1, 1) for x in (-1, 1)]
    slab.quads = [[2, 3, 1, 0], [4, 5, 7, 6], [6, 7, 3, 2], [5, 4, 0, 1], [4, 6, 2, 0], [7, 5, 1, 3]]
    slab.uvs = [[(0.0, 0.0)] * 4] * 6
    wax = document.add_material("wax", {"baseColor": [0.5, 0.5, 0.5], "roughness": 0.5})
    document.add_node("slab", document.add_mesh("slab", slab, wax))

    centre, radius, steps = -3.3, 1.35, 64
    holes, x = [], -1.2
    for width in (1.6, 0.8, 0.4, 0.2, 0.1):
        holes.append((x, x + width))
        x += 2 * width
    black = [rectangle(-half, half, edge, half, height), rectangle(-half, half, -half, -edge, height)]
    left, right = centre - edge, centre + edge
    bars = [-half, left, right] + [x for hole in holes for x in hole] + [half]
    black += [rectangle(bars[i], bars[i + 1], -edge, edge, height) for i in range(0, len(bars), 2)]

    def on_square(angle):
        c, s = math.cos(angle), math.sin(angle)
        reach = edge / max(abs(c), abs(s))
        return (centre + reach * c, height, reach * s)

    for i in range(steps):  # the corners of the square around the round hole
        a, b = 2 * math.pi * i / steps, 2 * math.pi * (i + 1) / steps
        inner = [(centre + radius * math.cos(t), height, radius * math.sin(t)) for t in (a, b)]
        black.append([inner[0], inner[1], on_square(b), on_square(a)])
    ink = document.add_material("mask", {"baseColor": [0.0, 0.0, 0.0], "roughness": 1.0, "specular": 0.0})
    document.add_node("mask", document.add_mesh("mask", quad_mesh(black), ink))
    document.write_glb(path)


class Renderer:
    def __init__(self, program, folder, spp):
        self.program, self.folder, self.spp = program, folder, spp

    def render(self, scene, mode, seed=0):
        """Writes NAME.exr and NAME.png; returns NAME's path without its suffix."""
        name = self.folder / ("%s_%s_%d" % (scene, mode, seed))
        subprocess.run([str(self.program), "render", str(self.folder / (scene + ".json")), "--subsurface", mode, "--seed",
                        str(seed), "--spp", str(self.spp), "-o", "%s.exr" % name, "-o", "%s.png" % name, "--quiet"], check=True)
        return name


def oiiotool(*arguments):
    return subprocess.run(["oiiotool", *map(str, arguments)], check=True, capture_output=True, text=True).stdout


def statistics(*arguments):
    """Mean and root mean square of red, green and blue of oiiotool's result for these arguments, in blocks of 4 x 4 pixels,
    because the eye also averages such fine noise."""
    text = oiiotool(*arguments, "--ch", "R,G,B", "--resize:filter=box", "25%", "--printstats")
    numbers = {key: [float(v) for v in re.search(r"Stats %s: (.*?) \(float\)" % key, text).group(1).split()]
               for key in ("Avg", "StdDev")}
    return numbers["Avg"], [math.hypot(a, s) for a, s in zip(numbers["Avg"], numbers["StdDev"])]


def join(rows, path):
    """Joins pictures: those of a row side by side, the rows below each other."""
    gap, placed, y, width = 6, [], 0, 0
    for row in rows:
        x = 0
        for picture in row:
            w, h = map(int, re.search(r":\s*(\d+) x\s*(\d+),", oiiotool("--info", picture)).groups())
            placed.append((picture, x, y))
            x += w + gap
        width, y = max(width, x - gap), y + h + gap
    arguments = ["--create", "%dx%d" % (width, y - gap), "3"]
    for picture, x, y in placed:
        arguments += [picture, "--ch", "R,G,B", "--swap", "--paste", "%+d%+d" % (x, y)]
    oiiotool(*arguments, "-d", "uint8", "--compression", "jpeg:90", "-o", path)


def report(diffusion, walk, command):
    """Compares the slabs by two renders of each; the difference of a pair gives the noise."""
    def mean_of_two(pair):
        return ["%s.exr" % pair[0], "%s.exr" % pair[1], "--add", "--mulc", "0.5"]

    def noise_of_two(pair):
        return statistics("%s.exr" % pair[0], "%s.exr" % pair[1], "--sub")[1]

    mean, level = statistics(*mean_of_two(walk))
    difference, rms = statistics(*mean_of_two(diffusion), *mean_of_two(walk), "--sub")
    # The mean of two renders has a quarter of the variance of their difference.
    noise = [0.5 * math.hypot(a, b) for a, b in zip(noise_of_two(diffusion), noise_of_two(walk))]
    beyond = [math.sqrt(max(0.0, r * r - n * n)) for r, n in zip(rms, noise)]
    rows = ["| | red | green | blue |", "|--|--|--|--|"]
    for title, values, unit, form in (("mean difference, diffusion - walk", difference, mean, "%+.2f %%"),
                                      ("RMS difference", rms, level, "%.2f %%"),
                                      ("RMS of its noise", noise, level, "%.2f %%"),
                                      ("RMS difference beyond noise", beyond, level, "%.2f %%")):
        rows.append("| %s | %s |" % (title, " | ".join(form % (100 * v / u) for v, u in zip(values, unit))))
    return "\n".join(["# Figure 1: the slab row in numbers", "", "Made, with figure1.jpg, by `%s`." % command, "",
                      "Blocks of 4 x 4 pixels. Mean difference in per cent of the mean, RMS in per cent of the walk's RMS.", ""]
                     + rows) + "\n"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--assets", default=os.environ.get("ALABASTER_TEST_ASSETS"))
    parser.add_argument("--spp", type=int, default=256)
    parser.add_argument("--program", type=pathlib.Path, default=ROOT / "build/release/bin/alabaster")
    parser.add_argument("--out", type=pathlib.Path, default=ROOT / "testenv/statistical/results")
    options = parser.parse_args()
    if not options.assets:
        parser.error("--assets or $ALABASTER_TEST_ASSETS must name the folder with sss/dragon_wax.glb")
    folder = ROOT / "build/figure1"
    folder.mkdir(parents=True, exist_ok=True)
    shutil.copy(pathlib.Path(options.assets) / "sss/dragon_wax.glb", folder)
    for scene in ("slab", "dragon"):
        shutil.copy(HERE / (scene + ".json"), folder)
    write_stage(folder / "stage.glb")
    write_slab(folder / "slab.glb")

    renderer = Renderer(options.program, folder, options.spp)
    slabs = {mode: [renderer.render("slab", mode, seed) for seed in (0, 1)] for mode in ("diffusion", "walk")}
    dragons = {mode: renderer.render("dragon", mode) for mode in ("diffusion", "walk")}
    options.out.mkdir(parents=True, exist_ok=True)
    join([["%s.png" % slabs[mode][0] for mode in slabs], ["%s.png" % dragons[mode] for mode in dragons]],
         options.out / "figure1.jpg")
    (options.out / "figure1.md").write_text(
        report(slabs["diffusion"], slabs["walk"],
               "python3 testenv/scenes/figure1/make_figure1.py --spp %d" % options.spp))


if __name__ == "__main__":
    main()
