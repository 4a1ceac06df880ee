#!/usr/bin/env python3
"""Prints what a checkpoint costs, as Markdown: its file's size, and the seconds that writing one takes while workers render.

  checkpoint_cost.py PROGRAM [--scene SCENE] [--folder DIR]

Renders 1280 x 720 pixels with a checkpoint each second. The files go to DIR (default: the folder for temporary files), whose
disk counts: a checkpoint is there when the disk has it.
"""
import argparse
import json
import pathlib
import subprocess
import tempfile

SCENE = pathlib.Path(__file__).resolve().parents[1] / "scenes/mixed_no_subsurface/mixed_no_subsurface.json"
LAYERS = {
    "color": [],
    "color, normal, albedo, depth": ["normal", "albedo", "depth"],
    "color and all layers of light": ["diffuse", "specular", "emission", "subsurface", "subsurfaceSingle", "subsurfaceMultiple",
                                      "subsurfaceUnscattered"],
}
PIXELS = 1280 * 720


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("--scene", default=str(SCENE))
    parser.add_argument("--folder")
    args = parser.parse_args()
    print("| AOVs | bytes a pixel | file, MB | seconds a checkpoint | resume, seconds |")
    print("| --- | --- | --- | --- | --- |")
    for name, layers in LAYERS.items():
        with tempfile.TemporaryDirectory(dir=args.folder) as folder:
            file, stats = pathlib.Path(folder) / "c", pathlib.Path(folder) / "s.json"
            words = [args.program, "render", args.scene, "--size", "1280x720", "--spp", "2", "--quiet", "-o", f"{folder}/x.exr",
                     "--stats", str(stats), "--checkpoint", str(file), "--checkpoint-interval", "1"]
            for layer in layers:
                words += ["--aov", layer]
            subprocess.run(words, check=True)
            size, run = file.stat().st_size, json.loads(stats.read_text())["delegate"][0]
            seconds = run["phase.checkpoint.wall"] / run["checkpoint.count"]
            subprocess.run([*words, "--resume"], check=True)
            again = json.loads(stats.read_text())["delegate"][0]["phase.render.wall"]
            print(f"| {name} | {size / PIXELS:.0f} | {size / 1e6:.0f} | {seconds:.2f} | {again:.2f} |")


if __name__ == "__main__":
    main()
