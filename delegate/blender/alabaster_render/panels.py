"""Panels: settings of the render, passes, subsurface sets, the node group."""
import bpy

from . import disney_group, settings

GROUPS = {
    "Sampling": ["samples", "viewport_samples", "targetError", "adaptive", "timeLimit", "denoise", "seed", "filter"],
    "Light Paths": ["maxDepth", "rouletteDepth", "energy"],
    "Subsurface": ["subsurface", "inversion", "walkWeights", "walkGuiding", "walkSphereSteps"],
}
GROUPED = {name for group in GROUPS.values() for name in group}


class AlabasterPanel:
    bl_space_type = "PROPERTIES"
    bl_region_type = "WINDOW"
    bl_context = "render"
    COMPAT_ENGINES = {"ALABASTER"}

    @classmethod
    def poll(cls, context):
        return context.engine in cls.COMPAT_ENGINES


class ALABASTER_PT_sampling(AlabasterPanel, bpy.types.Panel):
    bl_label = "Sampling"
    names = GROUPS["Sampling"]

    def draw(self, context):
        layout = self.layout
        layout.use_property_split = True
        layout.use_property_decorate = False
        for name in self.names:
            layout.prop(context.scene.alabaster, name)


class ALABASTER_PT_paths(ALABASTER_PT_sampling):
    bl_label = "Light Paths"
    names = GROUPS["Light Paths"]


class ALABASTER_PT_subsurface(ALABASTER_PT_sampling):
    bl_label = "Subsurface"
    names = GROUPS["Subsurface"]


class ALABASTER_PT_more(ALABASTER_PT_sampling):
    bl_label = "Textures and Refinement"
    names = [name for name in settings.SETTINGS if name not in GROUPED]


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
