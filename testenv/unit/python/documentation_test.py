"""Tests that every name of the module has a docstring and a type, and that examples of the documents run."""
import ast
import inspect
import pathlib
import re
import shutil
import subprocess
import sys
import tempfile
import unittest

import hdalabaster

TOP = pathlib.Path(__file__).resolve().parents[3]


class Documentation(unittest.TestCase):
    def test_everything_is_documented_and_typed(self):
        stub = ast.parse(pathlib.Path(hdalabaster.__file__).with_name("__init__.pyi").read_text())
        typed = {node.name: {f.name if isinstance(f, ast.FunctionDef) else f.target.id for f in node.body
                             if isinstance(f, (ast.FunctionDef, ast.AnnAssign))}
                 for node in stub.body if isinstance(node, ast.ClassDef)}
        functions = {node.name for node in stub.body if isinstance(node, ast.FunctionDef)}
        self.assertEqual(set(hdalabaster.__all__) - {"versions"} - functions, set(typed) - {"Frame", "Hit", "Progress", "Loaded", "Setting", "_Buffer"})
        typed["Scene"] |= set(vars(hdalabaster._SceneMethods))
        for name in ["Display", "Pixels", "Render", "Renderer", "Scene"]:
            kind = getattr(hdalabaster, name)
            members = {m for m in vars(kind) if not m.startswith("_")}
            self.assertEqual(members, {m for m in typed[name] if not m.startswith("_")}, name)
            self.assertTrue(inspect.getdoc(kind))
            for member in members | {"__getitem__"} & set(vars(kind)):
                text = inspect.getdoc(getattr(kind, member)) or ""
                # pybind11 writes the signature first.
                self.assertTrue(re.sub(r"^\w+\(.*\) -> .*", "", text).strip(), f"{name}.{member} has no docstring")
        for name in set(hdalabaster.__all__) - {"versions"}:
            self.assertTrue(inspect.getdoc(getattr(hdalabaster, name)), name)

    def test_example_of_the_readme(self):
        text = (TOP / "README.md").read_text()
        example = re.search(r"```python\n(import hdalabaster.*?)```", text, re.S).group(1)
        self.assertLessEqual(len(example.splitlines()), 20)
        with tempfile.TemporaryDirectory() as folder:
            subprocess.run([sys.executable, "-c", example], check=True, cwd=folder)
            self.assertTrue((pathlib.Path(folder) / "pebble.exr").exists())

    def test_examples_of_the_manual(self):
        examples = [example for page in sorted((TOP / "delegate/manual").rglob("*.md"))
                    if page.name != "measuring.md"  # measuring_test.py runs its blocks, which continue one another
                    for example in re.findall(r"```python\n(.*?)```", page.read_text(), re.S)]
        self.assertGreaterEqual(len(examples), 1)
        for example in examples:
            with tempfile.TemporaryDirectory() as folder:
                subprocess.run([sys.executable, "-c", example], check=True, cwd=folder)

    def test_descriptions_of_the_manual(self):
        """Blocks of JSON are render descriptions of a model.glb beside them."""
        descriptions = [text for page in sorted((TOP / "delegate/manual").rglob("*.md"))
                        for text in re.findall(r"```json\n(.*?)```", page.read_text(), re.S)]
        self.assertGreaterEqual(len(descriptions), 1)
        for text in descriptions:
            with tempfile.TemporaryDirectory() as folder:
                shutil.copy(TOP / "testenv/scenes/hard_light/hard_light.glb", pathlib.Path(folder) / "model.glb")
                (pathlib.Path(folder) / "scene.json").write_text(text)
                faults = []
                hdalabaster.Scene(report=lambda *fault: faults.append(fault)).load(pathlib.Path(folder) / "scene.json")
                self.assertEqual([], [fault for fault in faults if fault[0] != "info"])
