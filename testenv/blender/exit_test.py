"""Ends with the engine registered, which must not be a crash. Runs inside Blender (blender -b -P) or with the module bpy:
run_blender.py starts it and looks at the exit code.

Arguments: a JSON file with addon (the folder that holds the add-on) and module.
"""
import json
import pathlib
import sys

arguments = sys.argv[sys.argv.index("--") + 1:] if "--" in sys.argv else sys.argv[1:]
job = json.loads(pathlib.Path(arguments[0]).read_text())
sys.path[:0] = [job["addon"], job["module"]]

import bpy  # noqa: E402

import alabaster_render  # noqa: E402

alabaster_render.register()
bpy.context.scene.render.engine = "ALABASTER"
bpy.context.scene.alabaster.samples = 1
bpy.context.scene.render.resolution_percentage = 5
bpy.ops.render.render()
print("\nREGISTERED " + bpy.app.version_string, flush=True)
