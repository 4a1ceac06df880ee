"""Panels: settings of the render, passes, subsurface sets, the node group."""
import bpy

from . import disney_group, passes, settings

# Panels of settings: name, label, and blocks of the names of settings.
SETTINGS_PANELS = [
    ("sampling", "Sampling", [["quality"], ["samples", "targetError", "timeLimit"], ["adaptive", "denoise"], ["viewport_samples"],
                              ["seed", "filter"]]),
    ("paths", "Light Paths", [["maxDepth"], ["energy", "glossyFilter"]]),
    ("subsurface", "Subsurface", [["subsurface", "inversion"], ["walkGuiding", "walkSphereSteps"]]),
]
GROUPED = {name for *_, blocks in SETTINGS_PANELS for block in blocks for name in block}
SETTINGS_PANELS.append(("more", "Textures and Memory", [[name for name in settings.SETTINGS if name not in GROUPED]]))


class AlabasterPanel:
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "render"
    COMPAT_ENGINES = {"ALABASTER"}

    @classmethod
    def poll(cls, context):
        return context.engine in cls.COMPAT_ENGINES


class SettingsPanel(AlabasterPanel):
    """Not registered itself: where a registered class has subclasses, Blender takes its drawing away from it."""

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        for block in self.blocks:
            column = layout.column(align=True)
            for name in block:
                column.prop(context.scene.alabaster, name)


def settings_panel(name, label, blocks):
    closed = {"DEFAULT_CLOSED"} if name != "sampling" else set()
    return type(f"ALABASTER_PT_{name}", (SettingsPanel, bpy.types.Panel), {"bl_label": label, "bl_options": closed, "blocks": blocks})


class ALABASTER_PT_motion(AlabasterPanel, bpy.types.Panel):
    bl_label = "Motion Blur"
    bl_options = {"DEFAULT_CLOSED"}

    def draw_header(self, context):
        self.layout.prop(context.scene.render, "use_motion_blur", text="")

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        layout.active = context.scene.render.use_motion_blur
        layout.prop(context.scene.render, "motion_blur_shutter")


class ALABASTER_PT_passes(AlabasterPanel, bpy.types.Panel):
    bl_label = "Passes"
    bl_context = "view_layer"

    def draw(self, context):
        layout, layer = self.layout, context.view_layer
        layout.use_property_split = True
        layout.use_property_decorate = False
        column = layout.column(heading="Data")
        for name in passes.BLENDERS:
            column.prop(layer, name)
        column = layout.column(heading="Alabaster")
        for aov in settings.PASSES:
            column.prop(layer.alabaster, aov)


class ALABASTER_PT_collection(AlabasterPanel, bpy.types.Panel):
    bl_label = "Alabaster"
    bl_context = "collection"

    def draw(self, context):
        self.layout.prop(context.collection.alabaster, "subsurface_set")


class ALABASTER_PT_material(AlabasterPanel, bpy.types.Panel):
    bl_label = "Alabaster"
    bl_context = "material"

    def draw(self, context):
        self.layout.operator(disney_group.NODE_OT_alabaster_material.bl_idname, icon="NODETREE")


CLASSES = [disney_group.NODE_OT_alabaster_material, *(settings_panel(*one) for one in SETTINGS_PANELS), ALABASTER_PT_motion,
           ALABASTER_PT_passes, ALABASTER_PT_collection, ALABASTER_PT_material]
register, unregister = bpy.utils.register_classes_factory(CLASSES)
