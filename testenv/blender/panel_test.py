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
            def prop(self, data, name, *_, **__):
                shown.append((data, name))

            prop_search = prop

            def __getattr__(self, _):
                return lambda *_, **__: self
        layout = types.SimpleNamespace(layout=Layout(), **{name: getattr(panel, name, None) for name in ("blocks", "properties", "owner", "socket", "bl_context")})
        panel.draw(layout, self.context())
        return shown

    def context(self):
        light, material = bpy.data.lights.new("lamp", "AREA"), bpy.data.materials.new("skin")
        light.use_nodes = material.use_nodes = True
        return types.SimpleNamespace(
            scene=bpy.context.scene, view_layer=bpy.context.view_layer, collection=bpy.context.scene.collection, engine="ALABASTER",
            object=bpy.data.objects.new("lamp", light), light=light, material=material, world=bpy.data.worlds.new("world"))

    def test_each_has_its_own_drawing(self):
        """Blender takes a class its drawing where a subclass of it is registered."""
        for panel in panels.CLASSES:
            self.assertIs(getattr(bpy.types, panel.__name__, panel), panel)

    def test_controls(self):
        for panel in panels.CLASSES:
            if issubclass(panel, bpy.types.Panel):
                for data, name in self.drawn(panel):
                    self.assertIn(name, data.bl_rna.properties, panel.__name__)
        shown = {name for panel in panels.CLASSES if issubclass(panel, panels.AlabasterPanel) for _, name in self.drawn(panel)}
        self.assertLessEqual({"film_transparent", "material_override", "visible_camera", "is_holdout", "spread", "displacement_method",
                              "motion_blur_position", "use_pass_cryptomatte_object", "use_pass_cryptomatte_material",
                              "use_pass_cryptomatte_asset", "pass_cryptomatte_depth", "use_pass_position"}, shown)
        of_settings = [panel for panel in panels.CLASSES if issubclass(panel, panels.SettingsPanel)]
        self.assertEqual(of_settings[0].bl_label, "Sampling")
        sampling = {name for _, name in self.drawn(of_settings[0])}
        self.assertLessEqual({"quality", "samples", "targetError", "timeLimit", "adaptive", "denoise", "seed", "viewport_samples"}, sampling)
        shown = {name for panel in of_settings for _, name in self.drawn(panel)}
        self.assertEqual(shown, {*settings.SETTINGS, "quality", "viewport_samples"})

    def test_where_they_are_shown(self):
        context = self.context()
        by_name = {panel.__name__: panel for panel in panels.CLASSES}
        for name in ("spread", "visibility", "displacement", "light_nodes", "material_volume", "film"):
            self.assertTrue(by_name["ALABASTER_PT_" + name].poll(context), name)
        context.light.type = "POINT"
        context.light = bpy.data.lights["lamp"]
        context.material = None
        for name in ("spread", "displacement", "material_volume"):
            self.assertFalse(by_name["ALABASTER_PT_" + name].poll(context), name)
        context.engine = "CYCLES"
        self.assertFalse(by_name["ALABASTER_PT_film"].poll(context))

    def test_blenders_panels_of_slots_and_lenses_are_shown(self):
        for name in ("EEVEE_MATERIAL_PT_context_material", "DATA_PT_camera_dof", "DATA_PT_camera_dof_aperture"):
            self.assertIn("ALABASTER", getattr(bpy.types, name).COMPAT_ENGINES)
        self.assertNotIn("ALABASTER", bpy.types.EEVEE_MATERIAL_PT_settings.COMPAT_ENGINES)

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
