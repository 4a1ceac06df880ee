#!/usr/bin/env python3
"""Tries the additions of four_additions.py through each interface, once they are built.

  try_additions.py FOLDER [BUILD]

FOLDER is the worktree that four_additions.py made. BUILD is a build of it, build/release in FOLDER if it is left out, with the program, the
library and the Python module (ninja alabaster alabaster_python). `alabaster schema --write FOLDER` writes the manual and the stub.

Prints a line for each addition and interface: the value as it arrived, the answer to a value out of range, and that to a misspelt name.
The first scene is an archive that Python writes. The values of descriptions and of --set pass through `alabaster convert` and the
archive that it writes. No code fills the AOV, which shows its background, 0.25. It has no range. The exit code is 1 if an answer is
missing or wrong.
"""
import argparse
import json
import pathlib
import re
import subprocess
import sys
import tempfile
from typing import NamedTuple

SIDE = 8
BACK = [[1, 0, 0, 0], [0, 1, 0, 0], [0, 0, 1, 0], [0, 0, 4, 1]]
NEAREST = re.compile(r"[Dd]id you mean '[^']*'")
RANGE = re.compile(r"must be [^,]*|expected [^.]*|is out of range; [^.]*")


class Addition(NamedTuple):
    misspelt: str
    value: object
    arrives: str
    outside: object  # None: it has no range
    schema: str = ""
    page: str = ""
    place: str = ""  # of --set
    is_in_stub: bool = False


ADDITIONS = {
    "trialSetting": Addition("trialSeting", 0.25, "0.25", 2, "render_settings", "render_settings", is_in_stub=True),
    "trialOption": Addition("trialOptoin", [0.25, 0.5, 0.75], "(0.25, 0.5, 0.75)", [2, 0, 0], "mesh", "mesh", "meshes//square.", True),
    "trialParameter": Addition("trialParametre", 0.25, "0.25", 2, "lights", "light", "lights//lamp."),
    "trialAov": Addition("trialAvo", None, "0.25", None),
}


def dumped(renderer):
    """The additions of meshes and lights, as the renderer's dump shows them."""
    return dict(re.findall(r"^  (trial\w+) (.*)$", renderer.command("dumpScene"), re.M))


class Trial:
    def __init__(self, folder, build, scratch):
        self.folder, self.build, self.scratch = folder, build, scratch
        sys.path.insert(0, str(build / "python"))
        import hdalabaster
        self.module = hdalabaster
        self.scene().write(scratch / "model.alab", camera="/camera", width=SIDE, height=SIDE)

    def scene(self):
        scene = self.module.Scene()
        scene.set_mesh("/square", [(-1, -1, 0), (1, -1, 0), (1, 1, 0), (-1, 1, 0)], [[0, 1, 2, 3]])
        scene.set_light("/lamp", "sphereLight", BACK)
        scene.set_camera("/camera", BACK)
        return scene

    def run(self, *arguments):
        """The output of a command, which may fail."""
        done = subprocess.run([str(word) for word in arguments], cwd=self.scratch, capture_output=True, text=True)
        return done.stdout + done.stderr

    def program(self, *arguments):
        return self.run(self.build / "bin/alabaster", *arguments)

    # Each returns the answers by the addition and the step: arrives, range, misspelt.
    def c(self):
        library = self.build / "lib"
        source = pathlib.Path(__file__).with_suffix(".c")
        print(self.run("cc", "-std=c99", "-Wall", "-Wextra", "-pedantic", "-Werror", f"-I{self.folder}", source, "-o", "host", f"-L{library}",
                       "-lhdAlabaster", f"-Wl,-rpath,{library}"), end="")
        lines = [line.split("\t") for line in self.run(self.scratch / "host").splitlines()]
        return {(line[0], line[1]): line[2] for line in lines if len(line) == 3}

    def python(self):
        heard, answers, scene = [], {}, self.scene()
        renderer = self.module.Renderer(scene, report=lambda severity, code, where, text: heard.append(text), samples=1)

        def draw():
            return renderer.render(width=SIDE, height=SIDE, camera="/camera", aovs=["trialAov"])

        calls = {"trialSetting": renderer.set, "trialOption": lambda **fields: scene.edit("/square", fields),
                 "trialParameter": lambda **fields: scene.edit("/lamp", fields),
                 "trialAov": lambda **fields: renderer.render(aovs=list(fields), camera="/camera")}
        for name, addition in ADDITIONS.items():
            for step, spelt, value in (("arrives", name, addition.value), ("misspelt", addition.misspelt, addition.value),
                                       ("range", name, addition.outside)):
                if step == "range" and value is None:
                    continue
                try:
                    calls[name](**{spelt: value})
                except self.module.Error as error:
                    answers[name, step] = str(error)
                if step == "arrives":
                    pixel = memoryview(draw().pixels("trialAov"))[0, 0]
                    shown = {**dumped(renderer), "trialSetting": renderer.get("trialSetting"), "trialAov": pixel}
                    answers[name, step] = str(shown.get(name))
        draw()
        answers.update(((text.split()[0], "range"), text) for text in heard)
        return answers

    def describe(self, *entries):
        """Writes a description that sets the values by their additions and names."""
        scene = {"models": [{"file": "model.alab"}], "settings": {"samples": 1, "resolution": [SIDE, SIDE]}}
        for name, spelt, value in entries:
            if name == "trialSetting":
                scene["settings"][spelt] = value
            elif name == "trialAov":
                scene["products"] = [{"file": "layers.exr", "aovs": ["color", spelt]}]
            else:
                kind, prim = ADDITIONS[name].place.rstrip(".").split("/", 1)
                scene[kind] = [{"match": prim, spelt: value}]
        (self.scratch / "scene.json").write_text(json.dumps(scene))

    def arrived(self, render, convert):
        """The values after both commands of the program."""
        for file in ("copy.alab", "layers.exr"):
            (self.scratch / file).unlink(missing_ok=True)
        said = self.program(*render) + self.program(*convert)
        layer = re.search(r"Stats Avg: (\S+)", self.run("oiiotool", "layers.exr", "--ch", "trialAov.X", "--printstats"))
        scene = self.module.Scene()
        try:
            loaded = scene.load(self.scratch / "copy.alab")
        except self.module.Error as error:
            return {(name, "arrives"): said or str(error) for name in ADDITIONS}
        renderer = self.module.Renderer(scene)
        renderer.render(settings=loaded["settings"])
        shown = {**dumped(renderer), "trialSetting": renderer.get("trialSetting"), "trialAov": layer and f"{float(layer[1]):g}"}
        return {(name, "arrives"): str(shown.get(name)) for name in ADDITIONS}

    def steps(self):
        for name, addition in ADDITIONS.items():
            yield name, "misspelt", addition.misspelt, addition.value
            if addition.outside is not None:
                yield name, "range", name, addition.outside

    def description(self):
        self.describe(*((name, name, addition.value) for name, addition in ADDITIONS.items()))
        answers = self.arrived(["render", "scene.json", "--quiet"], ["convert", "scene.json", "-o", "copy.alab"])
        for name, step, spelt, value in self.steps():
            self.describe((name, spelt, value))
            answers[name, step] = self.program("check", "scene.json")
        return answers

    def set_options(self):
        def option(name, spelt, value):
            return ["--aov", spelt] if name == "trialAov" else ["--set", f"{ADDITIONS[name].place}{spelt}={json.dumps(value)}"]

        self.describe()
        given = [word for name, addition in ADDITIONS.items() if name != "trialAov" for word in option(name, name, addition.value)]
        answers = self.arrived(["render", "scene.json", "--quiet", "-o", "layers.exr", *given, *option("trialAov", "trialAov", None)],
                               ["convert", "scene.json", "-o", "copy.alab", *given])
        for name, step, spelt, value in self.steps():
            command = ["render", "scene.json", "-o", "layers.exr"] if name == "trialAov" else ["check", "scene.json"]
            answers[name, step] = self.program(*command, *option(name, spelt, value))
        return answers

    def schema(self):
        description = self.program("schema", "render_description")
        answers = {("trialAov", "arrives"): "a word of products/aovs" if '"trialAov"' in description else ""}
        for name, addition in ADDITIONS.items():
            if not addition.schema:
                continue
            entry = json.loads(self.program("schema", addition.schema))["properties"].get(name, {})
            number = entry.get("items", entry)
            is_referred = f'"{addition.schema}.json#/properties/{name}"' in description
            if is_referred and number:
                kind = number["type"] if number is entry else f"{entry['minItems']} times {number['type']}"
                answers[name, "arrives"] = f"{kind}, {number['minimum']} to {number['maximum']}, \"{entry['description']}\""
        return answers

    def manual(self):
        pages = {name: f"parameters/{addition.page}.md" if addition.page else "pipeline.md" for name, addition in ADDITIONS.items()}
        return self.line_of(lambda name: rf"^\| (`{name}` \|.*) \|$", {name: f"delegate/manual/{page}" for name, page in pages.items()})

    def stub(self):
        file = "delegate/python/hdalabaster/_fields.pyi"
        return self.line_of(lambda name: rf"^    ({name}: .*)$", {name: file for name, addition in ADDITIONS.items() if addition.is_in_stub})

    def line_of(self, pattern, files):
        found = {name: re.search(pattern(name), (self.folder / file).read_text(), re.M) for name, file in files.items()}
        return {(name, "arrives"): re.sub(r" \|( \|)*", ",", line[1]) if line else "" for name, line in found.items()}


def cell(name, step, answer):
    """The part of an answer that matters, or the whole answer after WRONG."""
    if step == "arrives":
        return answer
    found = (NEAREST if step == "misspelt" else RANGE).search(answer)
    good = found and (step != "misspelt" or f"'{name}'" in found[0])
    return found[0] if good else f"WRONG: {answer.strip() or 'no answer'}"


def rows(trial):
    """(addition, interface, cells): the interface's own words, without a value to compare, where it only shows the row."""
    for interface, answers in (("C", trial.c()), ("Python", trial.python()), ("description", trial.description()),
                               ("`--set`, `--aov`", trial.set_options())):
        for name, addition in ADDITIONS.items():
            cells = [cell(name, step, answers.get((name, step), "")) for step in ("arrives", "range", "misspelt")]
            if cells[0] != addition.arrives:
                cells[0] = f"WRONG: {cells[0]}"
            if addition.outside is None:
                cells[1] = "-"
            yield name, interface, cells
    for interface, answers in (("schema", trial.schema()), ("manual", trial.manual()), ("Python's stub", trial.stub())):
        for name, addition in ADDITIONS.items():
            if interface != "Python's stub" or addition.is_in_stub:
                yield name, interface, [answers.get((name, "arrives")) or "WRONG: no row", "-", "-"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("build", type=pathlib.Path, nargs="?")
    options = parser.parse_args()
    folder = options.folder.resolve()
    with tempfile.TemporaryDirectory() as scratch:
        trial = Trial(folder, (options.build or folder / "build/release").resolve(), pathlib.Path(scratch))
        found = sorted(rows(trial), key=lambda row: list(ADDITIONS).index(row[0]))
    print("| addition | interface | arrives | out of range | misspelt |\n| --- | --- | --- | --- | --- |")
    for name, interface, cells in found:
        print("| " + " | ".join([name, interface, *(one.replace("\n", " ") for one in cells)]) + " |")
    return 1 if any(one.startswith("WRONG") for _, _, cells in found for one in cells) else 0


if __name__ == "__main__":
    sys.exit(main())
