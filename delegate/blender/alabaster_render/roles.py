"""The roles of objects: in which subsurface set and light group they are, whether they are hold-outs, what sees and what lights them."""
from typing import NamedTuple

import bpy

LINKS_LIGHT = "light_linking" in bpy.types.Object.bl_rna.properties  # from Blender 4.0 on
MOST_GROUPS = 63  # of one frame, and light of no group
INDEX = "passIndex"  # the primvar that pass IndexOB shows


class Role(NamedTuple):
    """All that tells a mesh of one object from the same mesh of another, besides its materials."""
    body: str = ""  # the subsurface set; "": none
    holdout: bool = False
    catcher: bool = False  # of shadows
    seen: bool = True  # by the camera
    group: str = ""  # of the light that it emits; "": none
    categories: tuple = ()  # that the parameters lightLink and shadowLink of lights name
    matte: str = ""  # in pass CryptoObject; "": nobody asks
    asset: str = ""  # in pass CryptoAsset
    index: int = 0  # in pass IndexOB

    def primvars(self):
        """Constant primvars of the mesh, those that are not the default alone."""
        found = {"subsurfaceSet": self.body, "lightGroup": self.group, "holdout": self.holdout, "shadowCatcher": self.catcher,
                 "cryptoObject": self.matte, "cryptoAsset": self.asset, INDEX: [float(self.index)] if self.index else None}
        return {**{name: value for name, value in found.items() if value}, **({} if self.seen else {"visibleToCamera": False})}


def light_groups(view_layer):
    """The names of its light groups (from Blender 3.2 on): Cycles draws no others."""
    return [group.name for group in getattr(view_layer, "lightgroups", ())]


class Linked(NamedTuple):
    """Names of the objects that a light's collection includes and excludes."""
    included: set
    excluded: set

    def holds(self, name):
        return name not in self.excluded and (not self.included or name in self.included)

    def names(self, name):
        return name in self.included or name in self.excluded


class Roles:
    """The roles in a depsgraph. note(text) hears of what is not translated. with_passes: the view layer's are asked for."""

    def __init__(self, depsgraph, note, with_passes=False):
        self.layer, self.note, self.with_passes = depsgraph.view_layer_eval, note, with_passes
        self.sets, self.groups = subsurface_sets(), set(light_groups(self.layer)[:MOST_GROUPS])
        if len(light_groups(self.layer)) > MOST_GROUPS:
            note(f"of the light groups the first {MOST_GROUPS} are translated")
        self.linked = light_links() if LINKS_LIGHT else {}

    def of(self, instance, shaders):
        """shaders: for each material, whether it is a Holdout shader."""
        ob = instance.object
        parent = instance.parent if instance.is_instance else ob  # decides for all that it places, as in Cycles
        if any(shaders) and not all(shaders):
            self.note(f"object '{ob.name}': a Holdout shader counts where all materials of an object have one")
        for text in left_out(ob):
            self.note(f"object '{ob.name}': {text}")
        holdout = ob.is_holdout or parent.holdout_get(view_layer=self.layer)
        seen = ob.visible_camera and parent.visible_camera and (holdout or not parent.indirect_only_get(view_layer=self.layer))
        return Role(self.sets.get(ob.name_full, ""), holdout or all(shaders), ob.is_shadow_catcher or parent.is_shadow_catcher, seen,
                    self.group(ob), self.categories(ob, parent), *self.shown(ob))

    def shown(self, ob):
        """What tells the object from others in passes: its name, that of its topmost parent, as in Cycles, and its number."""
        def if_shown(switch, value, otherwise):
            return value if self.with_passes and getattr(self.layer, switch) else otherwise
        top = ob
        while top.parent:
            top = top.parent
        return (if_shown("use_pass_cryptomatte_object", ob.name, ""), if_shown("use_pass_cryptomatte_asset", top.name, ""),
                if_shown("use_pass_object_index", ob.pass_index, 0))

    def group(self, owner):
        """The light group of an object or a world. Blender tells the depsgraph of no edit of it."""
        name = getattr(owner and owner.original, "lightgroup", "")
        return name if name in self.groups else ""

    def categories(self, ob, parent):
        names = ob.original.name_full, parent.original.name_full
        return tuple(category for category, linked in self.linked.items()
                     if linked.holds(names[0] if linked.names(names[0]) else names[1]))

    def links(self, light):
        """Parameters of a light object."""
        group = {"lightGroup": self.group(light)} if self.group(light) else {}
        if not LINKS_LIGHT:
            return group
        linking = light.original.light_linking
        found = {"lightLink": linking.receiver_collection, "shadowLink": linking.blocker_collection}
        return {**group, **{name: category_of(one) for name, one in found.items() if one}}


def left_out(ob):
    if not (ob.visible_diffuse and ob.visible_glossy and ob.visible_transmission and ob.visible_shadow):
        yield "of its ray visibility only the camera's is translated"
    if LINKS_LIGHT and (ob.original.light_linking.receiver_collection or ob.original.light_linking.blocker_collection):
        yield "light links of meshes that emit are not translated"


def subsurface_sets():
    """The name of the set, by the name of each object that is in one."""
    found = {}
    for collection in bpy.data.collections:
        if collection.alabaster.subsurface_set:
            found.update({ob.name_full: collection.name_full for ob in collection.all_objects})
    return found


def category_of(collection):
    return f"collection {collection.name_full}"


def light_links():
    """The Linked of each category that a light names."""
    found = {}
    for light in bpy.data.objects:
        if light.type == "LIGHT":
            linking = light.light_linking
            for collection in filter(None, (linking.receiver_collection, linking.blocker_collection)):
                found[category_of(collection)] = linked_by(collection)
    return found


def linked_by(collection):
    """The state of a collection within it counts for all objects below."""
    linked = Linked(set(), set())

    def put(state, names):
        into, out = (linked.included, linked.excluded) if state == "INCLUDE" else (linked.excluded, linked.included)
        into.update(names)
        out.difference_update(names)
    for child, entry in zip(collection.children, collection.collection_children):
        put(entry.light_linking.link_state, [ob.name_full for ob in child.all_objects])
    for ob, entry in zip(collection.objects, collection.collection_objects):
        put(entry.light_linking.link_state, [ob.name_full])
    return linked
