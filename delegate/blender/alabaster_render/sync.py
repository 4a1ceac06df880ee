"""A depsgraph as prims of an hdalabaster.Scene: all of it once, then what an update names."""
import bpy
import numpy

from . import cryptomatte, hair, library, lights, materials, meshes, names, roles, world

NO_MATERIAL = names.path("material", "(none)")
DOME = "/world"
NOT_DRAWN = {"VOLUME": "volumes", "GPENCIL": "grease pencils", "GREASEPENCIL": "grease pencils"}


class Group:
    """A mesh with its materials, and the places where it stands. owners tell whose the places are, for motion."""

    def __init__(self, key, slots, role):
        self.path, self.key, self.slots, self.role = None, key, slots, role
        self.matrices, self.owners = [], []


def mesh_key(ob, depsgraph):
    """A name that tells a mesh from others, and whether it is the object's own. Objects without modifiers share that of their data."""
    original = ob.original
    data = ob.data
    if original.evaluated_get(depsgraph).data != data:
        return ("geometry", ob.name_full, f"{data.as_pointer():x}"), False  # an instance that geometry nodes made
    shares = ob.type == "MESH" and not len(ob.modifiers) and original.mode == "OBJECT"
    return (("data", original.data.name_full) if shares else ("object", ob.name_full)), True


def owner_of(instance):
    """The object's name, and for an instance its parent and number: two parents count alike."""
    return instance.object.name_full, (instance.parent.name_full, *instance.persistent_id) if instance.is_instance else ()


class SceneSync:
    """note(text) hears of what is not translated. viewport: levels and visibility are those of viewports."""

    def __init__(self, scene, viewport, note):
        self.scene, self.viewport, self.note = scene, viewport, note
        self.meshes = {}      # by key: arguments of set_mesh, or None where there are no faces
        self.stale = {}       # meshes that have to be read again
        self.paths = {}       # of groups, by what they are
        self.set_groups = {}  # by path: look, matrices and mesh as the scene has them
        self.set_lights, self.set_materials = {}, {}
        self.material_names = {}  # by path: the name and the pass index
        self.wanted = materials.Wanted()
        self.own_path = {}    # by an object's name: the mesh that it alone places
        self.instanced = set()  # names of objects that make instances, or are made into some
        self.roles = None     # of the depsgraph, once it is read
        self.motion = {}      # by owner: [(time, matrix)]
        self.deformation = {}  # by key: [(time, shape)]
        self.lens = {}        # of the camera: fields of samples

    # Everything -----------------------------------------------------------------------------------
    def sync(self, depsgraph, space=None):
        """Makes the scene that of the depsgraph. Only meshes that are not known are read."""
        self.want(depsgraph)
        groups, seen_lights = {}, {DOME}
        self.own_path, self.instanced = {}, set()
        self.roles = roles.Roles(depsgraph, self.note, not self.viewport)
        for instance in depsgraph.object_instances:
            ob = instance.object
            if instance.show_particles and not (space and not ob.visible_in_viewport_get(space)):
                self.place_hair(depsgraph, instance, groups)
            if not instance.show_self or (space and not instance.is_instance and not ob.visible_in_viewport_get(space)):
                continue
            if instance.is_instance:
                self.instanced.update((ob.name_full, instance.parent.name_full))
            if ob.type == "LIGHT":
                seen_lights.add(self.sync_light(ob, instance.matrix_world, owner_of(instance)))
            elif ob.type in meshes.KINDS or ob.type in hair.KINDS:
                self.place(depsgraph, instance, groups)
            if ob.type in NOT_DRAWN:
                self.note(f"object '{ob.name}': {NOT_DRAWN[ob.type]} are not translated")
        for gone in set(self.set_lights) - seen_lights:
            del self.set_lights[gone]
            self.scene.remove(gone)
        self.sync_world(depsgraph.scene_eval)
        self.push(groups)
        self.stale.clear()

    def place(self, depsgraph, instance, groups):
        ob = instance.object
        key, is_own = mesh_key(ob, depsgraph)
        if key not in self.meshes:
            made = hair.extract(ob, self.note, self.wanted) if ob.type in hair.KINDS else meshes.extract(ob, depsgraph, is_own, self.viewport, self.wanted)
            self.meshes[key] = self.read(key, made)
            named = [one.name for one in getattr(ob.data, "color_attributes", ()) if one.name in self.wanted.colors]
            if len(named) > 1:
                self.note(f"object '{ob.name}': of the colour attributes that materials read only '{named[0]}' is translated")
        self.join(instance, groups, key, ob.material_slots)

    def place_hair(self, depsgraph, instance, groups):
        ob, viewport = instance.object, depsgraph.mode == "VIEWPORT"
        for system in hair.systems(ob, viewport):
            key = "hair", ob.name_full, system.name
            if key not in self.meshes:
                self.meshes[key] = self.read(key, hair.of_system(ob, system, viewport))
            self.instanced.add(ob.name_full)  # it moves with its hair
            last = min(system.settings.material, len(ob.material_slots))
            self.join(instance, groups, key, ob.material_slots[max(last - 1, 0):last])

    def join(self, instance, groups, key, slots):
        """Adds a place to the group of what is read and looks alike."""
        ob = instance.object
        if self.meshes[key] is None:
            return
        slots = tuple(self.material(slot.material) for slot in slots) or (NO_MATERIAL,)
        if NO_MATERIAL in slots:
            self.material(None)
        if all(self.set_materials[path].left_out for path in slots):
            return
        identity = key, slots, self.roles.of(instance, [self.set_materials[path].holdout for path in slots])
        if identity not in groups:
            groups[identity] = Group(*identity)
        groups[identity].matrices.append(names.matrix(instance.matrix_world))
        groups[identity].owners.append(owner_of(instance))
        if not instance.is_instance and key[0] != "hair":
            self.own_path[ob.name_full] = groups[identity]

    def read(self, key, mesh):
        """A mesh that was read again, or the one that it replaces where both are the same: Blender also calls a mesh updated when
        its material is."""
        before = self.stale.pop(key, None)
        return before if before is not None and mesh is not None and meshes.same(before, mesh) else mesh

    def name(self, groups):
        """Paths: those that groups had, and free ones for new groups."""
        self.paths = {identity: path for identity, path in self.paths.items() if identity in groups}
        taken = set(self.paths.values())
        for identity, group in groups.items():
            if identity not in self.paths:
                base = path = names.path("mesh", identity[0][1])
                number = 1
                while path in taken:
                    number += 1
                    path = f"{base}#{number}"
                self.paths[identity] = path
                taken.add(path)
            group.path = self.paths[identity]

    def push(self, groups):
        """Tells the scene of what differs from what it has."""
        self.name(groups)
        for gone in set(self.set_groups) - {group.path for group in groups.values()}:
            self.forget(gone)
        for group in groups.values():
            self.push_group(group)
        used = {group.key for group in groups.values()}
        self.meshes = {key: mesh for key, mesh in self.meshes.items() if mesh is None or key in used}

    def push_group(self, group):
        mesh = self.meshes[group.key]
        many = len(group.matrices) > 1
        look = id(mesh), group.slots, group.role, many
        held = self.set_groups.get(group.path)
        motions = [self.motion.get(owner) for owner in group.owners]
        if held and held[0] == look and held[1] == group.matrices:
            return
        if many:
            self.scene.set_instancer(instancer_of(group.path), {group.path: numpy.arange(len(group.matrices), dtype=numpy.int32)},
                                     transforms=instances(group.matrices, motions))
        if held and held[0] == look:
            if not many:
                self.scene.set_transform(group.path, group.matrices[0])
        else:
            if held and held[0][-1] and not many:
                self.scene.remove(instancer_of(group.path))
            placement = {"instancer": instancer_of(group.path)} if many else {
                "transform": group.matrices[0], "motion": motions[0]}
            set_mesh(self.scene, group, {**mesh, **self.moving(group.key, mesh)}, placement)
        self.set_groups[group.path] = look, list(group.matrices), mesh  # the mesh lives as long as its id is compared

    def forget(self, path):
        if self.set_groups.pop(path)[0][-1]:
            self.scene.remove(instancer_of(path))
        self.scene.remove(path)

    # Parts ----------------------------------------------------------------------------------------
    def sync_light(self, ob, matrix, owner):
        path = names.path("light", owner[0], *map(str, owner[1]))
        made = lights.translate(ob.data, matrix, ob.visible_camera, self.note)
        if made is None:
            return None
        made[2].update(self.roles.links(ob))
        if self.set_lights.get(path) != made:
            kind, transform, parameters = self.set_lights[path] = made
            self.scene.set_light(path, kind, transform, motion=lights.motion(ob.data, self.motion.get(owner)), **parameters)
        return path

    def sync_world(self, scene):
        """scene: the evaluated one. The original has the values of keys of another frame."""
        made = world.translate(scene, scene.world, self.note) if scene.world else None
        if made is None:
            made = None, {"intensity": 0.0, "visibleToCamera": not scene.render.film_transparent}
        if made[1] and self.roles and self.roles.group(scene.world):
            made[1]["lightGroup"] = self.roles.group(scene.world)
        if self.set_lights.get(DOME) != made:
            self.set_lights[DOME] = made
            self.scene.set_light(DOME, "domeLight", made[0], **made[1])

    def material(self, material, again=False):
        """The path of a material, which is translated where it is not known, or `again`."""
        path = names.path("material", material.name_full) if material else NO_MATERIAL
        self.material_names[path] = (material.name, material.pass_index) if material else (cryptomatte.NO_MATERIAL, 0)
        if path not in self.set_materials or again:
            network = materials.translate(material, self.note)
            if self.set_materials.get(path) != network:
                self.set_materials[path] = network
                self.scene.set_material(path, nodes=network.nodes, displacement=network.displacement)
        return path

    def role_changes(self, material):
        """Translates a material again. True where that changes what its meshes are, such as hold-outs."""
        before = self.set_materials.get(names.path("material", material.name_full))
        after = self.set_materials[self.material(material, again=True)]
        return before is not None and before.role() != after.role()

    def moving(self, key, mesh):
        """Points and normals of a mesh that deforms while the shutter is open."""
        poses = self.deformation.get(key)
        if not poses:
            return {}
        if not all(meshes.same_topology(mesh, pose) for _, pose in poses):
            self.note(f"'{key[1]}': its faces change while the shutter is open, so its points stand still")
            return {}
        hdalabaster = library.load()
        motion = [(time, pose["points"]) for time, pose in poses]
        changed = {"points": hdalabaster.Primvar(mesh["points"], "vertex", role="point", motion=motion)}
        normals = mesh.get("primvars", {}).get("normals")
        if normals and all(pose["normals"] and len(pose["normals"].values) == len(normals.values) for _, pose in poses):
            moved = normals._replace(motion=[(time, pose["normals"].values) for time, pose in poses])
            changed["primvars"] = {**mesh["primvars"], "normals": moved}
        return changed

    def want(self, depsgraph):
        """Meshes are read again where materials name other maps or colours than before."""
        wanted = materials.Wanted.of(one for one in depsgraph.ids if isinstance(one, bpy.types.Material))
        if wanted != self.wanted:
            self.wanted = wanted
            self.meshes.clear()

    # Edits ----------------------------------------------------------------------------------------
    def update(self, depsgraph, space=None):
        """Sends the parts that the depsgraph's updates name, and no more."""
        everything, moved = False, []
        for change in depsgraph.updates:
            one = change.id
            if isinstance(one, bpy.types.Object):
                if change.is_updated_geometry:
                    self.drop_meshes(one)
                if change.is_updated_transform and not (change.is_updated_geometry or change.is_updated_shading):
                    moved.append(one.evaluated_get(depsgraph))
                else:
                    everything = True
            elif isinstance(one, bpy.types.Material):
                everything |= self.role_changes(one.evaluated_get(depsgraph))
                everything |= materials.Wanted.of([one]) - self.wanted
            elif isinstance(one, bpy.types.World):
                self.sync_world(depsgraph.scene_eval)
            elif isinstance(one, (bpy.types.NodeTree, bpy.types.Image)):
                everything |= self.all_materials(depsgraph)
                self.sync_world(depsgraph.scene_eval)
            elif not isinstance(one, bpy.types.Camera):
                everything = True
                self.drop_data(one)
        if everything or not all(self.move(ob) for ob in moved):
            self.sync(depsgraph, space)

    def move(self, ob):
        """False where it takes more than one prim's transform."""
        if ob.type in {"CAMERA", "EMPTY", "SPEAKER", "LIGHT_PROBE"} and ob.name_full not in self.instanced:
            return True
        if ob.name_full in self.instanced:
            return False
        if ob.type == "LIGHT":
            return self.sync_light(ob, ob.matrix_world, (ob.name_full, ())) is not None
        group = self.own_path.get(ob.name_full)
        if group is None:
            return ob.type not in meshes.KINDS and ob.type not in hair.KINDS
        group.matrices[group.owners.index((ob.name_full, ()))] = names.matrix(ob.matrix_world)
        self.push_group(group)
        return True

    def drop_meshes(self, ob):
        gone = [key for key in self.meshes if key[1] == ob.name_full and key[0] != "data"]
        if ob.data is not None:
            gone.append(("data", ob.data.name_full))
        for key in gone:
            self.drop(key)

    def drop_data(self, data):
        """Meshes that were read from a datablock. Objects with modifiers have updates of their own."""
        self.drop(("data", data.name_full))

    def drop(self, key):
        mesh = self.meshes.pop(key, None)
        if mesh is not None:
            self.stale[key] = mesh

    def all_materials(self, depsgraph):
        """Translates again those that are shown. True where meshes are to be read again, too."""
        shown = [one for one in depsgraph.ids
                 if isinstance(one, bpy.types.Material) and names.path("material", one.name_full) in self.set_materials]
        changes = [self.role_changes(one) for one in shown]
        return any(changes) or materials.Wanted.of(shown) - self.wanted


def instancer_of(path):
    return path + "/instances"


def instances(matrices, motions):
    """Transforms of instances, with those at other times where any moves."""
    hdalabaster = library.load()
    rest = meshes.frozen(numpy.array(matrices, numpy.float64))
    moving = next((motion for motion in motions if motion), None)
    if not moving:
        return rest
    poses = [(time, meshes.frozen(numpy.array([motion[i][1] if motion else own for motion, own in zip(motions, matrices)],
                                              numpy.float64)))
             for i, (time, _) in enumerate(moving)]
    return hdalabaster.Primvar(rest, "instance", motion=poses)


def set_mesh(scene, group, mesh, placement):
    hdalabaster = library.load()
    arguments = dict(mesh)
    primvars = {name: hdalabaster.Primvar(one.values, one.interpolation, role=one.role, motion=one.motion)
                for name, one in arguments.pop("primvars", {}).items()}
    primvars.update((name, hdalabaster.Primvar(value, "constant")) for name, value in group.role.primvars().items())
    if "kind" in mesh:
        arguments.update(("primvars:" + name, one) for name, one in primvars.items())
        arguments["widths"] = hdalabaster.Primvar(arguments["widths"], "vertex")
        scene.set(group.path, arguments.pop("kind"), {**arguments, "material": group.slots[0], "categories": group.role.categories, **placement})
        return
    index = arguments.pop("material_index")
    subsets = {}
    for number, material in enumerate(group.slots[1:], 1):
        faces = numpy.flatnonzero(index == number if number + 1 < len(group.slots) else index >= number).astype(numpy.int32)
        if len(faces):
            known = subsets.get(material)
            subsets[material] = faces if known is None else numpy.concatenate([known, faces])
    scene.set_mesh(group.path, material=group.slots[0], subsets=subsets, primvars=primvars, categories=group.role.categories,
                   **placement, **arguments)
