"""Tests of the panels. addon_test.py runs them."""
import types
import unittest

import bpy

from alabaster_render import panels, presets, settings
from synced_scene import fresh


class Panels(unittest.TestCase):
    def setUp(self):
        fresh()

    def drawn(self, panel):
        """(data, name) of each control of a panel."""
        shown = []

        class Layout:
            def prop(self, data, name, **_):
                shown.append((data, name))

            def __getattr__(self, _):
                return lambda *_, **__: self
        context = types.SimpleNamespace(scene=bpy.context.scene, view_layer=bpy.context.view_layer, collection=bpy.context.scene.collection)
        panel.draw(types.SimpleNamespace(layout=Layout(), blocks=getattr(panel, "blocks", None)), context)
        return shown

    def test_each_has_its_own_drawing(self):
        """Blender takes a class its drawing where a subclass of it is registered."""
        for panel in panels.CLASSES:
            self.assertIs(getattr(bpy.types, panel.__name__, panel), panel)

    def test_controls(self):
        for panel in panels.CLASSES:
            if issubclass(panel, bpy.types.Panel):
                for data, name in self.drawn(panel):
                    self.assertIn(name, data.bl_rna.properties, panel.__name__)
        of_settings = [panel for panel in panels.CLASSES if issubclass(panel, panels.SettingsPanel)]
        self.assertEqual(of_settings[0].bl_label, "Sampling")
        sampling = {name for _, name in self.drawn(of_settings[0])}
        self.assertLessEqual({"quality", "samples", "targetError", "timeLimit", "adaptive", "denoise", "seed", "viewport_samples"}, sampling)
        shown = {name for panel in of_settings for _, name in self.drawn(panel)}
        self.assertEqual(shown, {*settings.SETTINGS, "quality", "viewport_samples"})

    def test_quality_presets(self):
        group = bpy.context.scene.alabaster
        self.assertEqual(group.quality, "CUSTOM")
        for preset in presets.PRESETS:
            group.quality = preset["name"]
            self.assertEqual(group.quality, preset["name"])
            for name, value in presets.values(preset).items():
                self.assertAlmostEqual(getattr(group, name), value, places=6) if isinstance(value, float) else self.assertEqual(
                    getattr(group, name), value)
        group.samples = 77
        self.assertEqual((group.quality, group.maxDepth), ("CUSTOM", 64))
