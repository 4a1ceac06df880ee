"""Calls of the program for flags_table.py, each in a folder of its own, and what they left there."""
import json
import os
import pathlib
import re
import shutil
import struct
import subprocess
import sys
from typing import NamedTuple

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "statistical/calibration"))
import pictures  # noqa: E402


class Outcome(NamedTuple):
    code: int
    out: str
    err: str
    folder: pathlib.Path

    def file(self, name):
        return self.folder / name

    def attributes(self, name="a.exr"):
        return pictures.exr_attributes(self.file(name).read_bytes())[0]

    def layers(self, name="a.exr"):
        return pictures.read_layers(self.file(name))

    def color(self, name="a.exr"):
        layers = self.layers(name)
        return [layers[c] for c in "RGB"]

    def pixels(self, name="a.png"):
        """Bytes of a PNG besides its texts."""
        return b"".join(re.findall(rb"IDAT(.*?)(?=....(?:IDAT|IEND))", self.file(name).read_bytes(), re.S))

    def doubles(self, name="a.exr"):
        """{name: number} of the attributes of the renderer that are doubles."""
        return {key.removeprefix("alabaster/"): struct.unpack("<d", value)[0] for key, value in self.attributes(name).items() if len(value) == 8}

    @property
    def stats(self):
        return json.loads(self.file("s.json").read_text())

    def names(self):
        return {str(p.relative_to(self.folder)) for p in self.folder.rglob("*") if p.is_file()}


class Runs:
    """Runs of one program, each in a copy of the folder of the run before, at first of the scenes'."""

    def __init__(self, program, scenes, scratch, environment):
        self.program, self.scenes, self.scratch, self.known = program, scenes, scratch, {}
        self.environment = {**os.environ, **environment}

    def __call__(self, *steps):
        """The Outcome of the last of `steps`, each a tuple of arguments. Equal steps run once."""
        if steps not in self.known:
            before = self(*steps[:-1]).folder if len(steps) > 1 else self.scenes
            folder = self.scratch / str(len(self.known))
            shutil.copytree(before, folder)
            done = subprocess.run([self.program, *steps[-1]], cwd=folder, capture_output=True, text=True, env=self.environment)
            self.known[steps] = Outcome(done.returncode, done.stdout, done.stderr, folder)
        return self.known[steps]
