"""Motion: where things stand at times of the shutter, and in the next frame."""
from . import camera, hair, materials, meshes, names, sync

POSES = 5  # over the shutter; between them bodies turn and move evenly


class Shutter:
    """In frames, relative to the frame that is drawn."""

    def __init__(self, scene, next_frame=False):
        self.next_frame = next_frame  # pass Vector shows the way there
        render = scene.render
        self.moves = render.use_motion_blur
        length = render.motion_blur_shutter
        position = getattr(render, "motion_blur_position", None) or getattr(getattr(scene, "cycles", None), "motion_blur_position", "CENTER")
        self.open = {"START": 0.0, "CENTER": -0.5 * length, "END": -length}[position]
        self.close = self.open + length

    def times(self):
        blur = [self.open + (self.close - self.open) * i / (POSES - 1) for i in range(POSES)] if self.moves else []
        return sorted({*blur, *((0.0, 1.0) if self.next_frame else ())})


def sample(engine, depsgraph, shutter, exporter):
    """Fills exporter.motion, exporter.deformation and exporter.lens. The depsgraph is that of the frame itself afterwards."""
    scene = depsgraph.scene
    frame, part = scene.frame_current, scene.frame_subframe
    seen, deformed, lenses, times = {}, {}, {}, shutter.times()
    for time in times:
        at = frame + part + time
        engine.frame_set(int(at // 1), at % 1)
        for owner, matrix in places(depsgraph):
            seen.setdefault(owner, []).append((time, matrix))
        for key, mesh in shapes(depsgraph).items():
            deformed.setdefault(key, []).append((time, mesh))
        if scene.camera:
            for name, value in camera.lens(scene.camera.evaluated_get(depsgraph), depsgraph).items():
                lenses.setdefault((scene.camera.name_full, name), []).append((time, value))
    engine.frame_set(frame, part)
    exporter.motion = {owner: poses for owner, poses in seen.items()
                       if len(poses) == len(times) and any(matrix != poses[0][1] for _, matrix in poses)}
    drawn = scene.camera.name_full if scene.camera else ""  # markers may bind another one at other times
    exporter.lens = {name + ":samples": values for (owner, name), values in lenses.items()
                     if owner == drawn and len(values) == len(times) and any(value != values[0][1] for _, value in values)}
    exporter.deformation = {key: poses for key, poses in deformed.items() if len(poses) == len(times) and deforms(poses)}


def deforms(poses):
    first = poses[0][1]
    return not all(mesh is not None and meshes.same(first["points"], mesh["points"]) for _, mesh in poses)


def shapes(depsgraph):
    """The shapes of all meshes that shape keys, armatures or other modifiers may deform, by key."""
    made = {}
    for instance in depsgraph.object_instances:
        ob = instance.object
        if (ob.type not in meshes.KINDS and ob.type not in hair.KINDS) or not instance.show_self:
            continue
        key, is_own = sync.mesh_key(ob, depsgraph)
        if is_own and key not in made and ob.is_deform_modified(depsgraph.scene, "RENDER"):
            read = hair.extract(ob, lambda text: None, materials.Wanted()) if ob.type in hair.KINDS else meshes.extract(ob, depsgraph, True, False, materials.Wanted())
            made[key] = meshes.shape(read)
    return made


def places(depsgraph):
    for instance in depsgraph.object_instances:
        if instance.object.type in meshes.KINDS or instance.object.type in hair.KINDS or instance.object.type == "LIGHT":
            yield sync.owner_of(instance), names.matrix(instance.matrix_world)
    eye = depsgraph.scene.camera
    if eye:
        yield (eye.name_full, ()), names.matrix(eye.evaluated_get(depsgraph).matrix_world.normalized())
