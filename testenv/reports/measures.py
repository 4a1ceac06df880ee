"""Renders and reads pictures for reports.py, and writes the files that its rows vary."""
import json
import os
import pathlib
import struct
import subprocess
import sys

import numpy as np

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[1] / "statistical/calibration"))
from pictures import exr_attributes, exr_channels, read_layers  # noqa: E402


class Wrong(Exception):
    """A measured value that is not the right answer."""


class Skipped(Exception):
    """The machine lacks something that the row needs."""


def expect(holds, text):
    if not holds:
        raise Wrong(text)


class Run:
    """The result of a command: exit code, messages, the peak of its memory in bytes, and seconds of CPU time."""

    def __init__(self, code, text, memory, seconds):
        self.code, self.text, self.memory, self.seconds = code, text, memory, seconds

    def warnings(self, word=""):
        return [line for line in self.text.splitlines() if line.startswith(("warning:", "error:")) and word in line]


class Lab:
    """Runs the program on a copy of a report's folder, which rows may change."""

    def __init__(self, program, inputs, scratch, module):
        self.program, self.inputs, self.folder, self.module = program, inputs, scratch, module
        for file in inputs.rglob("*"):
            to = scratch / file.relative_to(inputs)
            if file.is_dir():
                to.mkdir(exist_ok=True)
            else:
                to.write_bytes(file.read_bytes())

    def command(self, words, environment=None, clean=True):
        """Runs words in the folder; `environment` is added to the caller's, which has no $OCIO."""
        variables = {key: value for key, value in os.environ.items() if key != "OCIO" or not clean}
        variables.update(environment or {})
        out = self.folder / "messages.txt"
        with out.open("w") as file:
            child = subprocess.Popen([str(word) for word in words], cwd=self.folder, env=variables, stdout=file, stderr=file)
            _, status, usage = os.wait4(child.pid, 0)
            child.returncode = os.waitstatus_to_exitcode(status)
        return Run(child.returncode, out.read_text(errors="replace"), usage.ru_maxrss * 1024, usage.ru_utime + usage.ru_stime)

    def run(self, *words, **options):
        return self.command([self.program, *words], **options)

    def python(self, *words):
        return self.command([sys.executable, *words], {"PYTHONPATH": self.module})

    def has_module(self):
        return self.module and self.python("-c", "import hdalabaster").code == 0

    def render(self, scene, *options):
        """The picture of a scene as {channel: rows}, and the run."""
        name = f"out_{abs(hash((scene, options))) % 10**8}.exr"
        run = self.run("render", scene, "-o", name, "--threads", "2", *options)
        expect(run.code == 0, f"{scene}: exit {run.code}: {run.text[-300:]}")
        return Picture(self.folder / name), run

    def write(self, name, data):
        (self.folder / name).write_bytes(data)
        return name

    def json(self, name):
        return json.loads((self.folder / name).read_text())

    def vary(self, name, to, change):
        """Writes the scene `name` as `to`, after change(scene)."""
        scene = self.json(name)
        change(scene)
        return self.write(to, json.dumps(scene).encode())


class Picture:
    def __init__(self, file):
        self.attributes, _ = exr_attributes(file.read_bytes())
        self.channels = [name for name, _ in exr_channels(self.attributes["channels"])]
        x0, y0, x1, y1 = struct.unpack("<4i", self.attributes["dataWindow"])
        self.layers = {name: np.array(values, float).reshape(y1 - y0 + 1, x1 - x0 + 1)
                       for name, values in read_layers(file).items()}

    def rgb(self):
        return np.stack([self.layers[c] for c in "RGB"], -1)

    def alpha(self):
        return self.layers["A"]

    def mean(self, where=None):
        values = self.rgb()
        return values.mean((0, 1)) if where is None else values[where].mean(0)

    def equals(self, other):
        return self.layers.keys() == other.layers.keys() and all(np.array_equal(v, other.layers[n]) for n, v in self.layers.items())


def near(value, right, slack, what):
    """`slack`: relative."""
    value, right = np.asarray(value, float), np.asarray(right, float)
    worst = np.max(np.abs(value - right) / np.abs(right))
    expect(worst <= slack, f"{what}: {np.array2string(value, precision=4)} and not {np.array2string(right, precision=4)} "
                           f"(off by {100 * worst:.1f} %, slack {100 * slack:.1f} %)")


def exr_file(layers, data_window=None, display_window=None):
    """An EXR of one part with float channels and no compression. `layers`: {channel: rows of numbers}."""
    layers = {name: np.asarray(rows, "<f4") for name, rows in sorted(layers.items())}
    height, width = next(iter(layers.values())).shape
    data_window = data_window or (0, 0, width - 1, height - 1)
    display_window = display_window or data_window

    def attribute(name, kind, value):
        return name.encode() + b"\0" + kind.encode() + b"\0" + struct.pack("<i", len(value)) + value

    channels = b"".join(name.encode() + b"\0" + struct.pack("<iiii", 2, 0, 1, 1) for name in layers) + b"\0"
    head = struct.pack("<ii", 20000630, 2) + attribute("channels", "chlist", channels)
    head += attribute("compression", "compression", b"\0") + attribute("dataWindow", "box2i", struct.pack("<4i", *data_window))
    head += attribute("displayWindow", "box2i", struct.pack("<4i", *display_window)) + attribute("lineOrder", "lineOrder", b"\0")
    head += attribute("pixelAspectRatio", "float", struct.pack("<f", 1)) + attribute("screenWindowCenter", "v2f", bytes(8))
    head += attribute("screenWindowWidth", "float", struct.pack("<f", 1)) + b"\0"
    size = 8 + 4 * width * len(layers)
    offsets = b"".join(struct.pack("<Q", len(head) + 8 * height + y * size) for y in range(height))
    lines = b"".join(struct.pack("<ii", data_window[1] + y, size - 8) + b"".join(rows[y].tobytes() for rows in layers.values())
                     for y in range(height))
    return head + offsets + lines


def glb_file(document, binary):
    text = json.dumps(document).encode()
    text += b" " * (-len(text) % 4)
    binary += bytes(-len(binary) % 4)
    return (struct.pack("<4sII", b"glTF", 2, 28 + len(text) + len(binary)) + struct.pack("<I4s", len(text), b"JSON") + text +
            struct.pack("<I4s", len(binary), b"BIN\0") + binary)
