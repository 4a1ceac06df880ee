"""Panels: settings of the render, passes, subsurface sets, the node group."""
import bpy

from . import cryptomatte, disney_group, passes, settings

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


def has(owner, name):
    """The owner, None where it has no property of that name."""
    return owner if owner is not None and name in owner.bl_rna.properties else None


# Properties of Blender's own that the engine reads, and whose panels belong to other engines: name, label, Blender's context, and
# (owner in the context, property).
PROPERTY_PANELS = [
    ("film", "Film", "render", [(lambda context: context.scene.render, "film_transparent")]),
    ("override", "Override", "view_layer", [(lambda context: context.view_layer, "material_override")]),
    ("visibility", "Visibility to Rays", "object", [(lambda context: context.object, "visible_camera"),
                                                    (lambda context: context.object, "is_holdout")]),
    ("spread", "Beam Shape", "data", [(lambda context: has(context.light, "spread"), "spread")]),
    ("displacement", "Displacement", "material", [
        (lambda context: has(context.material, "displacement_method") or has(getattr(context.material, "cycles", None), "displacement_method"),
         "displacement_method")]),
]


class PropertyPanel(AlabasterPanel):
    @classmethod
    def poll(cls, context):
        return super().poll(context) and all(cls.owners(context))

    @classmethod
    def owners(cls, context):
        data = {"data": "light", "material": "material", "object": "object"}.get(cls.bl_context)
        return [None] if data and getattr(context, data, None) is None else [owner(context) for owner, _ in cls.properties]

    def draw(self, context):
        self.layout.use_property_split = True
        for owner, name in self.properties:
            self.layout.prop(owner(context), name)


def property_panel(name, label, place, properties):
    return type(f"ALABASTER_PT_{name}", (PropertyPanel, bpy.types.Panel), {"bl_label": label, "bl_context": place, "properties": properties})


class NodesPanel(AlabasterPanel):
    """The nodes that are linked to a socket of the output."""

    @classmethod
    def poll(cls, context):
        owner = getattr(context, cls.owner, None)
        return super().poll(context) and owner is not None and owner.use_nodes

    def draw(self, context):
        tree = getattr(context, self.owner).node_tree
        output = tree.get_output_node("CYCLES") or tree.get_output_node("ALL")
        if output:
            self.layout.template_node_view(tree, output, output.inputs[self.socket])


class ALABASTER_PT_light_nodes(NodesPanel, bpy.types.Panel):
    bl_label, bl_context, owner, socket = "Nodes", "data", "light", "Surface"


class ALABASTER_PT_material_volume(NodesPanel, bpy.types.Panel):
    bl_label, bl_context, owner, socket = "Volume", "material", "material", "Volume"


class ALABASTER_PT_material_displacement(NodesPanel, bpy.types.Panel):
    bl_label, bl_context, owner, socket = "Displacement Nodes", "material", "material", "Displacement"


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
        owner = has(context.scene.render, "motion_blur_position") or has(getattr(context.scene, "cycles", None), "motion_blur_position")
        if owner:
            layout.prop(owner, "motion_blur_position", text="Position")


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
        column = layout.column(heading="Cryptomatte")
        for name in cryptomatte.KINDS:
            column.prop(layer, name)
        column.prop(layer, "pass_cryptomatte_depth", text="Levels")
        column = layout.column(heading="Alabaster")
        for aov in settings.PASSES:
            column.prop(layer.alabaster, aov)


class LightGroupPanel(AlabasterPanel):
    """The light group of what the context names: one of the view layer's."""
    bl_label = "Light Group"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context):
        return super().poll(context) and has(getattr(context, cls.bl_context), "lightgroup")

    def draw(self, context):
        self.layout.use_property_split = True
        self.layout.prop_search(getattr(context, self.bl_context), "lightgroup", context.view_layer, "lightgroups", text="Light Group")


class ALABASTER_PT_object_light_group(LightGroupPanel, bpy.types.Panel):
    bl_context = "object"


class ALABASTER_PT_world_light_group(LightGroupPanel, bpy.types.Panel):
    bl_context = "world"


class ALABASTER_PT_light_groups(AlabasterPanel, bpy.types.Panel):
    """Those of the view layer: each is a pass."""
    bl_label = "Light Groups"
    bl_context = "view_layer"
    bl_parent_id = "ALABASTER_PT_passes"
    bl_options = {"DEFAULT_CLOSED"}

    @classmethod
    def poll(cls, context):
        return super().poll(context) and has(context.view_layer, "lightgroups")

    def draw(self, context):
        row, layer = self.layout.row(), context.view_layer
        row.template_list("UI_UL_list", "lightgroups", layer, "lightgroups", layer, "active_lightgroup_index", rows=3)
        column = row.column(align=True)
        column.operator("scene.view_layer_add_lightgroup", icon="ADD", text="")
        column.operator("scene.view_layer_remove_lightgroup", icon="REMOVE", text="")


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
           ALABASTER_PT_passes, ALABASTER_PT_light_groups, ALABASTER_PT_object_light_group, ALABASTER_PT_world_light_group,
           ALABASTER_PT_collection, ALABASTER_PT_material, *(property_panel(*one) for one in PROPERTY_PANELS),
           ALABASTER_PT_light_nodes, ALABASTER_PT_material_volume, ALABASTER_PT_material_displacement]
register, unregister = bpy.utils.register_classes_factory(CLASSES)
