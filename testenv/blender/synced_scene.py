"""A scene of Blender beside that of the library, which remembers its calls. For the tests of the add-on."""
import unittest

import bpy

import hdalabaster
import scenes
from alabaster_render import sync


class Watched:
    """An hdalabaster.Scene that remembers its calls."""

    def __init__(self):
        self.scene, self.calls = hdalabaster.Scene(), []

    def __getattr__(self, name):
        method = getattr(self.scene, name)

        def call(*args, **kwargs):
            self.calls.append((name, args[0]))
            self.last = kwargs
            return method(*args, **kwargs)
        return call


def fresh():
    bpy.ops.wm.read_factory_settings(use_empty=True)
    bpy.context.scene.render.engine = "ALABASTER"


def dump(scene):
    renderer = hdalabaster.Renderer(scene, samples=1)
    renderer.start(width=8, height=8, camera={"focalLength": 1.0})
    text = renderer.command("dumpScene")
    renderer.stop()
    return text


class SyncedScene(unittest.TestCase):
    """Instances, and a ball of its own."""

    def setUp(self):
        fresh()
        scenes.instances()
        self.ball = scenes.ball(scenes.diffuse("own"), (2, -3, 1), name="own")
        self.watched, self.notes = Watched(), []
        self.sync = sync.SceneSync(self.watched, True, self.notes.append)
        self.sync.sync(bpy.context.evaluated_depsgraph_get())

    def after(self, edit):
        """Calls that an edit makes, through the depsgraph's own updates."""
        self.watched.calls.clear()

        def updated(_, depsgraph):
            self.sync.update(depsgraph)
        bpy.app.handlers.depsgraph_update_post.append(updated)
        try:
            edit()
            bpy.context.view_layer.update()
        finally:
            bpy.app.handlers.depsgraph_update_post.remove(updated)
        return self.watched.calls
