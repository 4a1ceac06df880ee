#!/usr/bin/env python3
"""Situations of public bug reports against other programs, made by script, each with the answer that is right by reasoning.

  public_reports.py PROGRAM [--only TEXT] [--keep FOLDER]

A row is a report: its number, and the checks of model_reports.py or image_reports.py. A check compares a number of a picture or a
message with the right one. Rows that are known to be wrong are called open. The exit status is 1 if another one is wrong.
public_reports.md has the list with the verdicts.
"""
import argparse
import json
import os
import pathlib
import subprocess
import sys
import tempfile
import traceback

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "statistical" / "calibration"))
import numpy as np  # noqa: E402
from pictures import read_layers  # noqa: E402

sys.path.insert(0, str(HERE))
ROWS = []  # (report, situation, function, True if it is known to be wrong)


def report(name, situation, is_open=False):
    def register(function):
        ROWS.append((name, situation, function, is_open))
        return function
    return register


class Picture:
    """Channels of an EXR, as arrays of rows, and what the program said."""

    def __init__(self, layers, size, text):
        self.layers = {name: np.reshape(values, (size[1], size[0])) for name, values in layers.items()}
        self.text = text

    def rgb(self):
        return np.stack([self.layers[c] for c in "RGB"], axis=-1)

    @property
    def middle(self):
        """The mean of the middle 2 x 2 pixels: red, green, blue, alpha."""
        h, w = self.layers["R"].shape
        return [float(self.layers[c][h // 2 - 1:h // 2 + 1, w // 2 - 1:w // 2 + 1].mean()) for c in "RGBA"]

    @property
    def mean(self):
        return [float(self.layers[c].mean()) for c in "RGBA"]

    def layer(self, *channels):
        h, w = self.layers["R"].shape
        return [float(self.layers[c][h // 2, w // 2]) for c in channels]


class Case:
    """The checks of one report, in a folder of its own."""

    def __init__(self, program, folder):
        self.program, self.folder, self.results = program, folder, []

    def run(self, *arguments):
        done = subprocess.run([self.program, *map(str, arguments)], capture_output=True, text=True, cwd=self.folder, timeout=120,
                              env={**os.environ, "LC_ALL": "C.UTF-8"})
        return done.returncode, done.stdout + done.stderr

    def render(self, model, size=(8, 8), samples=4, lights=(), options=(), aovs=(), **settings):
        """The picture of a model, by its own camera and without a studio."""
        names = [name for a in aovs for name in ("--aov", a)]
        scene = self.folder / "scene.json"
        scene.write_text(json.dumps({"models": [{"file": str(model.relative_to(self.folder))}], "lights": list(lights),
                                     "settings": {"resolution": list(size), "samples": samples, "studio": "off", "filter": "box", **settings}}))
        code, text = self.run("render", scene, "-o", "out.exr", *names, *options)
        if code != 0:
            raise RuntimeError(f"exit code {code}: {text.strip()}")
        return Picture(read_layers(self.folder / "out.exr"), size, text)

    def near(self, what, got, right, tolerance=2e-3):
        """Numbers, of which each must be within `tolerance`, relative above 1."""
        got, right = np.atleast_1d(np.asarray(got, float)), np.atleast_1d(np.asarray(right, float))
        holds = got.shape == right.shape and bool((np.abs(got - right) <= tolerance * np.maximum(1, np.abs(right))).all())
        self.results.append((what, " ".join(f"{v:.4g}" for v in got.ravel()[:8]), " ".join(f"{v:.4g}" for v in right.ravel()[:8]), holds))

    def true(self, what, holds, got=""):
        self.results.append((what, str(got), "", bool(holds)))


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("--only", default="", help="reports whose line has this text")
    parser.add_argument("--keep", type=pathlib.Path, help="a folder for the inputs")
    options = parser.parse_args()
    import image_reports  # noqa: F401
    import further_reports  # noqa: F401
    import model_reports  # noqa: F401
    import slot_reports  # noqa: F401
    wrong = tried = 0
    with tempfile.TemporaryDirectory() as temporary:
        for number, (name, situation, function, is_open) in enumerate(row for row in ROWS if options.only.lower() in " ".join(row[:2]).lower()):
            folder = (options.keep or pathlib.Path(temporary)) / f"{number:02d}"
            folder.mkdir(parents=True, exist_ok=True)
            case = Case(str(pathlib.Path(options.program).resolve()), folder)
            try:
                function(case)
            except Exception as error:  # a render that failed is a wrong answer, and the other rows are still of interest
                if not isinstance(error, RuntimeError):
                    traceback.print_exc()
                case.true(str(error)[:300], False)
            case.true("has checks", bool(case.results))
            failed = [r for r in case.results if not r[3]]
            tried += 1
            wrong += bool(failed) != is_open  # an open one that has become right is closed in the table
            print(f"{('open ' if is_open else 'WRONG') if failed else 'right'}  {name}: {situation} ({len(case.results)} checks)")
            for what, got, right, _ in failed:
                print(f"       {what}: {got}" + (f", right is {right}" if right else ""))
    print(f"{wrong} of {tried} reports are not as the table has them" if wrong or not tried else f"{tried} reports are as the table has them")
    return 1 if wrong or not tried else 0


if __name__ == "__main__":
    sys.modules["public_reports"] = sys.modules["__main__"]
    sys.exit(main())
