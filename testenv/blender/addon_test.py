"""Tests of the add-on. Runs inside Blender (blender -b -P) or with the module bpy: run_blender.py starts it.

Arguments: a JSON file with addon, module and zip.
"""
import json
import os
import pathlib
import sys
import tempfile
import types
import unittest
import unittest.mock

HERE = pathlib.Path(__file__).resolve().parent
arguments = sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else sys.argv[1:]
job = json.loads(pathlib.Path(arguments[0]).read_text())
sys.path[:0] = [str(HERE), job["addon"], job["module"]]

import bpy  # noqa: E402
import numpy  # noqa: E402

import alabaster_render  # noqa: E402
import scenes  # noqa: E402
import subsurface_widths  # noqa: E402
from edit_test import Edits  # noqa: E402, F401
from frame_test import Frames  # noqa: E402, F401
from light_test import Nodes  # noqa: E402, F401
from material_test import Materials  # noqa: E402, F401
from mesh_test import Hair, HairEdits, Meshes  # noqa: E402, F401
from panel_test import Panels  # noqa: E402, F401
from pass_test import Passes  # noqa: E402, F401
from role_test import Deformation, LightGroups, LightLinks, Roles  # noqa: E402, F401
from alabaster_render import library  # noqa: E402


class Widths(unittest.TestCase):
    def test_walks_are_as_wide_as_cycles(self):
        """By a shadow's edge: the mean of a picture hardly depends on the distance. With a radius wrong by 4 pi this fails by a factor of 10."""
        with tempfile.TemporaryDirectory() as folder:
            job = {"out": folder, "samples": 64, "columns": 96, "rows": 8}
            for method in subsurface_widths.methods(bpy.types.ShaderNodeBsdfPrincipled, "subsurface_method"):
                row = subsurface_widths.measure(job, method, lambda: subsurface_widths.principled(method))[1]
                theirs, ours = (row[engine]["widths"] for engine in ("CYCLES", "ALABASTER"))
                self.assertTrue(all(ours[:3]) and all(theirs[:3]), row)
                self.assertLess(abs(numpy.log(numpy.divide(ours[:3], theirs[:3]))).mean(), 0.3, row)


class Installation(unittest.TestCase):
    def test_another_package_of_this_name_is_passed_over(self):
        """A package that is called hdalabaster but has no Renderer."""
        with tempfile.TemporaryDirectory() as folder, unittest.mock.patch.dict(sys.modules), \
                unittest.mock.patch.object(sys, "path", [folder + "/theme", *sys.path]), \
                unittest.mock.patch.object(library, "HERE", pathlib.Path(folder)):
            for name, text in (("theme", ""), ("ours", "Renderer = object")):
                package = pathlib.Path(folder) / name / "hdalabaster"
                package.mkdir(parents=True)
                (package / "__init__.py").write_text(text)
            for name in [one for one in sys.modules if one.split(".")[0] == "hdalabaster"]:
                del sys.modules[name]
            with self.assertRaisesRegex(ImportError, "another package"):
                library.load()
            sys.modules["hdalabaster"] = types.ModuleType("hdalabaster")
            (pathlib.Path(folder) / "module_folder.txt").write_text(folder + "/ours")
            self.assertIn("/ours/", library.load().__file__)

    @unittest.skipUnless(job.get("zip"), "no zip")
    def test_zip(self):
        """As a new user: the zip goes into the preferences, the engine is there and renders."""
        alabaster_render.unregister()
        before = {name: sys.modules.pop(name) for name in list(sys.modules) if name.split(".")[0] == "alabaster_render"}
        path = list(sys.path)
        sys.path[:] = [one for one in path if one not in (job["addon"], job["module"])]
        try:
            bpy.ops.preferences.addon_install(filepath=job["zip"], overwrite=True)
            bpy.ops.preferences.addon_enable(module="alabaster_render")
            held = sys.modules["alabaster_render"]
            self.assertIn(os.environ["BLENDER_USER_SCRIPTS"], held.__file__)
            self.assertEqual(pathlib.Path(sys.modules["alabaster_render.library"].folders()[0]), pathlib.Path(job["module"]))
            scenes.stage()
            bpy.context.scene.render.engine = "ALABASTER"
            bpy.ops.preferences.addon_disable(module="alabaster_render")
        finally:
            sys.path[:] = path
            for name in [one for one in sys.modules if one.split(".")[0] == "alabaster_render"]:
                del sys.modules[name]
            sys.modules.update(before)
            alabaster_render.register()


alabaster_render.register()
done = unittest.main(argv=["addon_test", *arguments[1:]], exit=False, verbosity=1)
alabaster_render.unregister()
sys.stdout.flush()
sys.stderr.flush()
os._exit(0 if done.result.wasSuccessful() else 1)
