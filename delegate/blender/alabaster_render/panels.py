"""Panels: settings of the render, passes, subsurface sets, the node group."""
import bpy

from . import disney_group, settings

# Blocks of a panel, each the names of its settings.
SAMPLING = [["quality"], ["samples", "targetError", "timeLimit"], ["adaptive", "denoise"], ["viewport_samples"], ["seed", "filter"]]
PATHS = [["maxDepth"], ["energy", "glossyFilter"]]
SUBSURFACE = [["subsurface", "inversion"], ["walkGuiding", "walkSphereSteps"]]
GROUPED = {name for panel in (SAMPLING, PATHS, SUBSURFACE) for block in panel for name in block}
MORE = [[name for name in settings.SETTINGS if name not in GROUPED]]


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


class ALABASTER_PT_sampling(SettingsPanel, bpy.types.Panel):
    bl_label = "Sampling"
    blocks = SAMPLING


class ALABASTER_PT_paths(SettingsPanel, bpy.types.Panel):
    bl_label = "Light Paths"
    bl_options = {"DEFAULT_CLOSED"}
    blocks = PATHS


class ALABASTER_PT_subsurface(SettingsPanel, bpy.types.Panel):
    bl_label = "Subsurface"
    bl_options = {"DEFAULT_CLOSED"}
    blocks = SUBSURFACE


class ALABASTER_PT_more(SettingsPanel, bpy.types.Panel):
    bl_label = "Textures and Memory"
    bl_options = {"DEFAULT_CLOSED"}
    blocks = MORE


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
        for name in ("use_pass_z", "use_pass_normal", "use_pass_vector", "use_pass_emit"):
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


CLASSES = [disney_group.NODE_OT_alabaster_material, ALABASTER_PT_sampling, ALABASTER_PT_paths, ALABASTER_PT_subsurface,
           ALABASTER_PT_more, ALABASTER_PT_motion, ALABASTER_PT_passes, ALABASTER_PT_collection, ALABASTER_PT_material]


def register():
    for one in CLASSES:
        bpy.utils.register_class(one)


def unregister():
    for one in reversed(CLASSES):
        bpy.utils.unregister_class(one)
