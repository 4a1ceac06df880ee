#!/usr/bin/env python3
"""Renders the bundled scenes and joins them, three by two, into bundled.jpg.

  python3 testenv/scenes/make_contact_sheet.py [--program PATH] [--spp N] [--out FILE]

Needs oiiotool (openimageio-tools).
"""
import argparse
import pathlib
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
ROWS = [["skin_closeup", "backlit", "mixed_no_subsurface"], ["hard_light", "dome_high_contrast", "thick_thin"]]
WIDTH, HEIGHT, GAP = 320, 213, 6


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default=str(HERE.parents[1] / "build" / "release" / "bin" / "alabaster"))
    parser.add_argument("--spp", type=int, default=96)
    parser.add_argument("--out", default=str(HERE / "bundled.jpg"))
    options = parser.parse_args()
    columns = max(len(row) for row in ROWS)
    sheet = ["oiiotool", "--create", "%dx%d" % (columns * (WIDTH + GAP) - GAP, len(ROWS) * (HEIGHT + GAP) - GAP), "3"]
    with tempfile.TemporaryDirectory() as folder:
        for y, row in enumerate(ROWS):
            for x, name in enumerate(row):
                picture = str(pathlib.Path(folder) / (name + ".png"))
                subprocess.run([options.program, "render", str(HERE / name / (name + ".json")), "--size",
                                "%dx%d" % (WIDTH, HEIGHT), "--spp", str(options.spp), "--quiet", "-o", picture], check=True)
                sheet += [picture, "--ch", "R,G,B", "--swap", "--paste", "%+d%+d" % (x * (WIDTH + GAP), y * (HEIGHT + GAP))]
        subprocess.run(sheet + ["-d", "uint8", "--compression", "jpeg:88", "-o", options.out], check=True)


if __name__ == "__main__":
    sys.exit(main())
