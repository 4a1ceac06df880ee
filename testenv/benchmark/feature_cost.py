#!/usr/bin/env python3
"""Counts what features cost a scene that does not use them.

  feature_cost.py PROGRAM [--scene NAME ...] [--size WxH]

The instructions of one camera sample, by function (valgrind's callgrind): the difference of two renders, one with twice the
samples of the other, so that loading and building are not counted. Functions that serve one feature alone are added up: in a scene
that does not use the feature, which a cell says, all of it is cost without use. Branches that the compiler has put into the
functions of others are not seen; `compare_programs.py BEFORE AFTER --instructions` counts them between two revisions.

PROGRAM needs its symbols, as it is built. It finds its library in ../lib. Needs callgrind (valgrind).
"""
import argparse
import pathlib
import re
import subprocess
import tempfile

from compare_programs import add_size, render, require

SCENES = ["thick_thin", "mixed_no_subsurface", "hard_light"]  # one with subsurface, one without, one with point-like light
FEW = 4  # samples
FEATURES = {  # functions of the room, without their arguments
    "coat, clear coat, sheen, thin film": r"DisneyCoat|DisneyClearcoat|clearcoat_albedo|DisneySheen|sheen_albedo|ThinFilm",
    "glass, thin surfaces, dispersion": r"DisneyDielectric|DisneyThinDielectric|DielectricBoundary",
    "absorption, nested dielectrics": r"MediumStack|interiors_at|MeshInterior",
    "culled sides, opacity, cut-outs": r"coverage|ask_filter|StochasticStop|Transmittance|is_partly_opaque",
    "textures": r"Texture|texels_across|UdimTexture|TexelStore",
    "normal and bump maps": r"mapped_normal|reflecting_normal",
    "motion": r"MovingCamera|Instance::move_to|time_",
    "shaping, IES": r"LightShaping|IesProfile",
    "light tree": r"LightTree",
    "light links": r"with_links|linked_visibility",
}
USED = {"mixed_no_subsurface": ["coat, clear coat, sheen, thin film", "textures"]}
CULLED = "culled sides, opacity, cut-outs"  # glTF's materials have one side unless they say otherwise


def profile(program, scene, samples, folder, size, flags=()):
    """Instructions by function, and in all."""
    data = folder / "callgrind.out"
    render(program, scene, folder / "cost.exr", ["--size", f"{size[0]}x{size[1]}", "--spp", str(samples), "--threads", "1", *flags],
           ["valgrind", "--tool=callgrind", f"--callgrind-out-file={data}"])
    text = subprocess.run(["callgrind_annotate", "--threshold=100", str(data)], capture_output=True, text=True, check=True).stdout
    total = int(re.search(r"^ *([\d,]+) .*PROGRAM TOTALS", text, re.M)[1].replace(",", ""))
    functions = {}
    for count, name in re.findall(r"^ *([\d,]+) \([ \d.]+%\)  \S*?:(alabaster::[^\n]*|[^\n]* alabaster::[^\n]*)$", text, re.M):
        functions[name] = functions.get(name, 0) + int(count.replace(",", ""))
    return functions, total


def own_name(function):
    """Without arguments, so that what a function is given does not count as its feature."""
    return function.replace("(anonymous namespace)::", "").split("(")[0]


def totals_by_name(functions):
    totals = {}
    for function, count in functions.items():
        totals[own_name(function)] = totals.get(own_name(function), 0) + count
    return totals


def per_sample(program, scene, folder, size, flags=()):
    """Instructions of a camera sample by function, and in all."""
    (few, few_total), (many, many_total) = (profile(program, scene, n, folder, size, flags) for n in (FEW, 2 * FEW))
    samples = size[0] * size[1] * FEW
    return {name: (count - few.get(name, 0)) / samples for name, count in many.items()}, (many_total - few_total) / samples


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("--scene", action="append", choices=SCENES, help="only this scene; may be repeated")
    add_size(parser)
    arguments = parser.parse_args()
    require(arguments.program, "valgrind", "callgrind_annotate")
    scenes = arguments.scene or SCENES
    with tempfile.TemporaryDirectory() as name:
        measured = {scene: per_sample(arguments.program, scene, pathlib.Path(name), arguments.size) for scene in scenes}
    print("| feature | " + " | ".join(scenes) + " | functions |\n|--|" + "--|" * (len(scenes) + 1))
    print("| instructions a sample | " + " | ".join(f"{total:.0f}" for _, total in measured.values()) + " | all |")
    for feature, pattern in FEATURES.items():
        cells, used = [], set()
        for scene, (functions, total) in measured.items():
            found = {f: c for f, c in totals_by_name(functions).items() if c > 0 and re.search(pattern, f)}
            used |= {f.split("alabaster::")[-1] for f in found}
            uses = feature == CULLED or feature in USED.get(scene, [])
            cells.append(f"{100 * sum(found.values()) / total:.2f} %" + " (used)" * uses)
        print(f"| {feature} | " + " | ".join(cells) + " | " + ", ".join(sorted(used)) + " |")


if __name__ == "__main__":
    main()
