"""A stage as edits of a scene, in order: cameras and settings, the walk over the prims, materials, instancers."""
from pxr import Gf, Sdf, Usd, UsdGeom, UsdLux, UsdShade, UsdSkel

from . import geometry, lights, views
from .looks import Looks
from .values import Samples, V, array, matrix, path, token

RENDER_TAGS = {"default": "geometry", "render": "render", "proxy": "proxy", "guide": "guide"}


class Place:
    """Where the walk is: what prims inherit."""

    def __init__(self, xform=None, purpose="default", primvars=(), instancer=None, moved=None, root=None, moves=None):
        self.xform = xform or Gf.Matrix4d(1)  # to the world, or to the space of the instancer
        self.moves = moves                    # the same at the times of the shutter; None: it stands still
        self.purpose, self.primvars = purpose, primvars
        self.instancer = instancer  # that draws what is met here
        self.moved = moved          # (from, to): prims below one path are named below another
        self.root = root or Gf.Matrix4d(1)  # from the world to the instancer's space, where it was met first

    def below(self, **changes):
        made = Place(self.xform, self.purpose, self.primvars, self.instancer, self.moved, self.root, self.moves)
        made.__dict__.update(changes)
        return made

    def name(self, prim):
        text = str(prim.GetPath())
        if self.moved and (text == self.moved[0] or text.startswith(self.moved[0] + "/")):
            return self.moved[1] + text[len(self.moved[0]):]
        return text


class Instancer:
    """One that is being read: native instances of a prototype, or a PointInstancer."""

    def __init__(self, name, transform, parent, fields):
        self.name, self.fields, self.parent = name, fields, parent
        self.indices = None  # the instances of the prototype that is walked
        fields["transform"] = matrix(transform)
        if parent:
            fields["parent"] = path(parent.name)
            parent.draws(name)

    def draws(self, name):
        self.fields["prototypes:" + name] = self.indices


class Reader:
    """Reads a stage at a time. `options`: camera, settings, purposes, refine, all optional."""

    def __init__(self, stage, sink, notes, time=None, options=None):
        options = options or {}
        self.stage, self.sink, self.notes, self.options = stage, sink, notes, options
        if time is None:
            time = stage.GetStartTimeCode() if stage.HasAuthoredTimeCodeRange() else None
        self.time = Usd.TimeCode.EarliestTime() if time is None else Usd.TimeCode(time)
        self.refine = options.get("refine", 2)
        self.looks = Looks(stage, sink, notes, self.time)
        self.up = str(UsdGeom.GetStageUpAxis(stage))
        self.links, self.shapes, self.meshes = lights.Links(), {}, []
        self.cameras, self.lit, self.light_prims = {}, {}, []
        self.skeletons = geometry.Skeletons(self.time)
        self.world = UsdGeom.XformCache(self.time)

    # In order of time ---------------------------------------------------------------------------------
    def run(self):
        """Returns what stands beside the prims in an archive."""
        self._find_cameras_and_lights()
        settings = self._read_settings()
        root = self.stage.GetPseudoRoot()
        self._children(root, Place())
        self._bind()
        for where, (name, fields) in sorted(self.lit.items()):
            self.sink.set(where, name, fields)
        return {"settings": settings}

    def _find_cameras_and_lights(self):
        """Also those in instances, of which each is one of its own."""
        everything = iter(Usd.PrimRange(self.stage.GetPseudoRoot(),
                                        Usd.TraverseInstanceProxies() if self._in_prototypes() else Usd.PrimDefaultPredicate))
        for prim in everything:
            if prim.IsA(UsdGeom.Camera):
                self.cameras[str(prim.GetPath())] = prim
            elif prim.IsA(UsdGeom.PointInstancer):
                if any(lights.is_light(p) for p in Usd.PrimRange(prim)):
                    self.notes.tell("lights of PointInstancers are not read", prim.GetPath())
                everything.PruneChildren()
            elif lights.is_light(prim):
                self.links.add(prim, self.notes)
                visible = UsdGeom.Imageable(prim).ComputeVisibility(self.time) != "invisible"
                where = str(prim.GetPath())
                self.light_prims.append(prim)
                self.lit[where] = lights.light_fields(prim, self.world.GetLocalToWorldTransform(prim), visible, self.time, self.up,
                                                      self.links.fields[where], self.notes)
            else:
                lights.tell_unread(prim, self.notes)

    def _in_prototypes(self):
        return any(p.IsA(UsdGeom.Camera) or lights.is_light(p)
                   for prototype in self.stage.GetPrototypes() for p in Usd.PrimRange(prototype))

    def _choose_shutter(self, camera):
        """The times at which what moves is sampled: of the camera's shutter, or of the options'."""
        self.shutter, prim = None, self.cameras.get(camera)
        given = self.options.get("shutter")
        if given or prim:
            opens, closes = given or [prim.GetAttribute("shutter:" + n).Get(self.time) or 0 for n in ("open", "close")]
            if closes > opens and self.time.GetValue() > -1e300:
                self._sample(opens, closes)
        for where, one in self.cameras.items():
            fields = views.camera_fields(one, self.world.GetLocalToWorldTransform(one), self.time)
            if self.shutter:
                moves = [UsdGeom.Xformable(one).ComputeLocalToWorldTransform(t) for t in self.shutter_times]
                if any(m != moves[0] for m in moves):
                    fields["transform:samples"] = self._samples(moves)
            self.sink.set(where, "camera", fields)

        if not self.shutter:
            return
        if prim and any(prim.GetAttribute(n).ValueMightBeTimeVarying() for n in views.LENS):
            self.notes.tell("a lens that changes within the shutter stands still", camera)
        for light in self.light_prims:
            ends = [UsdGeom.Xformable(light).ComputeLocalToWorldTransform(t) for t in (self.shutter_times[0], self.shutter_times[-1])]
            if ends[0] != ends[1]:
                self.notes.tell("a light that moves within the shutter stands still", light.GetPath())

    def _sample(self, opens, closes):
        """Both ends, and up to seven times between at which something has a sample."""
        now = self.time.GetValue()
        between, interval = set(), Gf.Interval(now + opens, now + closes)
        for prim in self.stage.Traverse():
            if prim.IsA(UsdGeom.Xformable):
                xformable = UsdGeom.Xformable(prim)
                if xformable.TransformMightBeTimeVarying():
                    between.update(xformable.GetTimeSamplesInInterval(interval))
        between = sorted(t - now for t in between if opens < t - now < closes)
        between = between if len(between) <= 7 else [opens + (closes - opens) * i / 8 for i in range(1, 8)]
        self.shutter = [opens, *between, closes]
        self.shutter_times = [Usd.TimeCode(now + t) for t in self.shutter]

    def _samples(self, moves):
        return V("samples", Samples(self.shutter, [matrix(m) for m in moves]))

    def _read_settings(self):
        prim = views.choose_settings(self.stage, self.options.get("settings"), self.notes)
        where, fields = "/render", {}
        main = next((c for c in self.cameras if c.endswith("/main_cam")), next(iter(self.cameras), None))
        if prim:
            where = str(prim.GetPath())
            fields = views.settings_fields(prim, self.time, self.notes, self.cameras, self.options.get("may_write", lambda file: True),
                                           self.options.get("aovs", ()))
            if "camera" not in fields and main:
                fields["camera"] = path(main)
            self.binding = prim.GetAttribute("materialBindingPurposes").Get()
        else:
            fields = views.default_settings(main, self.cameras.get(main), self.time)
            self.binding = None
        self._choose_shutter(self.options.get("camera") or (fields["camera"].data if "camera" in fields else None))
        purposes = self.options.get("purposes")
        if purposes:
            fields["includedPurposes"] = V("token[]", purposes)
        self.purposes = set(fields["includedPurposes"].data) if "includedPurposes" in fields else {"default", "render"}
        while self.stage.GetPrimAtPath(where) and not prim:
            where += "_"
        self.sink.set(where, "renderSettings", fields)
        return where

    # The walk -----------------------------------------------------------------------------------------
    def _children(self, parent, place):
        """Instances of one prototype that inherit the same are drawn by one instancer."""
        groups = {}
        for prim in parent.GetFilteredChildren(Usd.TraverseInstanceProxies(Usd.PrimDefaultPredicate)):
            self._prim(prim, place, groups)
        for key in groups:
            self._instances(groups[key], place)

    def _prim(self, prim, place, groups):
        if prim.IsA(UsdGeom.Imageable):
            image = UsdGeom.Imageable(prim)
            visibility = image.GetVisibilityAttr()
            if visibility and visibility.Get(self.time) == "invisible":
                return
            if image.GetPurposeAttr().HasAuthoredValue():
                place = place.below(purpose=str(image.GetPurposeAttr().Get()))
            if prim.IsA(UsdGeom.Xformable):
                xformable = UsdGeom.Xformable(prim)
                local = _local(xformable, self.time)
                resets = xformable.GetResetXformStack()
                moves = None if resets else place.moves
                if self.shutter and (moves or xformable.TransformMightBeTimeVarying()):
                    locals = [_local(xformable, t) for t in self.shutter_times]
                    moves = [a * b for a, b in zip(locals, moves or [Gf.Matrix4d(1) if resets else place.xform] * len(locals))]
                place = place.below(xform=local * (Gf.Matrix4d(1) if resets else place.xform), moves=moves)
        if prim.IsInstance() and not prim.IsA(UsdGeom.Gprim):
            binding = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial()[0]
            key = (str(prim.GetPrototype().GetPath()), str(binding.GetPath()) if binding else "", place.purpose,
                   tuple(str(p.GetAttr().GetPath()) for p in UsdGeom.PrimvarsAPI(prim).FindInheritablePrimvars()))
            groups.setdefault(key, []).append((prim, place))
            return
        self._draw(prim, place)

    def _draw(self, prim, place):
        kind = prim.GetTypeName()
        if prim.IsA(UsdSkel.Root):
            self.skeletons.populate(prim)
        if prim.IsA(UsdGeom.PointInstancer):
            return self._points(prim, place)
        if prim.HasAPI(UsdGeom.ModelAPI):
            mode = UsdGeom.ModelAPI(prim).ComputeModelDrawMode()
            if mode != "default":
                self.notes.tell("draw modes are not read: the objects are drawn", prim.GetPath())
        if place.purpose in self.purposes:
            if kind == "Mesh":
                self._mesh(prim, place, geometry.mesh_fields(prim, self.time, self.refine, self.notes))
            elif kind in geometry.IMPLICIT:
                self._mesh(prim, place, geometry.implicit_fields(prim, self.time, self.shapes), True)
            elif kind == "TetMesh":
                self._mesh(prim, place, geometry.tet_fields(prim, self.time, self.notes))
            elif kind in geometry.UNREAD:
                self.notes.tell("%s are not drawn" % geometry.UNREAD[kind], prim.GetPath())
            elif prim.IsA(UsdGeom.Gprim):
                self.notes.tell("prims of type %s are not drawn" % kind, prim.GetPath())
        if prim.IsA(UsdGeom.Imageable):
            primvars = UsdGeom.PrimvarsAPI(prim).FindIncrementallyInheritablePrimvars(list(place.primvars))
            if primvars:
                place = place.below(primvars=tuple(primvars))
        self._children(prim, place)

    def _mesh(self, prim, place, fields, is_implicit=False):
        if fields is None:
            return
        geometry.add_primvars(prim, place.primvars, fields, self.time, self.notes, is_implicit)
        xform = place.xform
        if not is_implicit:
            space = self.skeletons.deform(prim, fields, self.notes)
            if space:
                xform = self.world.GetLocalToWorldTransform(space) * place.root
        if xform != Gf.Matrix4d(1):
            fields["transform"] = matrix(xform)
        if place.moves and xform is place.xform:
            fields["transform:samples"] = self._samples(place.moves)
        if self.shutter and prim.GetTypeName() == "Mesh" and xform is place.xform:
            geometry.add_motion(prim, fields, self.shutter, self.time, self.notes)
        if place.purpose != "default":
            fields["renderTag"] = token(RENDER_TAGS.get(place.purpose, "geometry"))
        name = place.name(prim)
        if place.instancer:
            fields["instancer"] = path(place.instancer.name)
            place.instancer.draws(name)
        if self.links.of and not (place.instancer and place.instancer.of_links):
            categories = self.links.categories(prim.GetPath())
            if categories:
                fields["categories"] = V("token[]", categories)
        self.meshes.append((name, prim, fields))

    def _instances(self, members, place):
        """Native instances. Prims are named by the first one: prototypes have another number in each run."""
        first, first_place = members[0]
        if len(members) == 1:
            return self._draw(first, first_place)
        fields = {"primvars:hydra:instanceTransforms": V("matrix[]", _matrices([m[1].xform for m in members]))}
        if any(m[1].moves for m in members):
            at = [[m[1].moves[i] if m[1].moves else m[1].xform for m in members] for i in range(len(self.shutter))]
            fields["primvars:hydra:instanceTransforms:samples"] = V("samples", Samples(self.shutter, [V("matrix[]", _matrices(a)) for a in at]))
        instancer = Instancer(first_place.name(first), Gf.Matrix4d(1), place.instancer, fields)
        instancer.indices = array("int", range(len(members)))
        instancer.of_links = self._links_of([m[0].GetPath() for m in members], fields)
        inner = first_place.below(xform=Gf.Matrix4d(1), moves=None, instancer=instancer, root=self.world.GetLocalToWorldTransform(first).GetInverse())
        self._draw(first, inner)
        self._finish(instancer)

    def _links_of(self, paths, fields):
        """Categories by instance."""
        for name, query in self.links.of:
            held = [i for i, p in enumerate(paths) if lights._holds(query, p)]
            if held:
                fields["categories:" + name] = array("int", held)
        return bool(self.links.of)

    def _finish(self, instancer):
        self.sink.set(instancer.name, "instancer", instancer.fields)

    def _points(self, prim, place):
        points = UsdGeom.PointInstancer(prim)
        get = lambda attribute: attribute.Get(self.time)
        indices, positions = get(points.GetProtoIndicesAttr()), get(points.GetPositionsAttr())
        prototypes = points.GetPrototypesRel().GetForwardedTargets()
        if not indices or not positions or not prototypes or len(positions) < len(indices):
            return self.notes.tell("PointInstancers without positions, indices or prototypes draw nothing", prim.GetPath())
        fields = {"primvars:hydra:instanceTranslations": V("float3[]", positions)}
        turns = get(points.GetOrientationsfAttr()) if hasattr(points, "GetOrientationsfAttr") else None
        turns = turns or get(points.GetOrientationsAttr())
        if turns and len(turns) == len(indices):
            fields["primvars:hydra:instanceRotations"] = _real_first(turns)
        scales = get(points.GetScalesAttr())
        if scales and len(scales) == len(indices):
            fields["primvars:hydra:instanceScales"] = V("float3[]", scales)
        shown = points.ComputeMaskAtTime(self.time)
        instancer = Instancer(place.name(prim), place.xform, place.instancer, fields)
        instancer.of_links = False
        if place.moves:
            fields["transform:samples"] = self._samples(place.moves)
        if self.shutter:
            geometry.add_velocities(points.GetVelocitiesAttr(), "primvars:hydra:instanceTranslations", positions, fields, self.shutter, self.time, self.stage)
        for primvar in UsdGeom.PrimvarsAPI(prim).GetPrimvarsWithAuthoredValues():
            if primvar.GetInterpolation() != "constant" and not primvar.GetPrimvarName().startswith("skel:"):
                self.notes.tell("primvars by instance are not read: all instances look alike", prim.GetPath())
        primvars = tuple(p for p in UsdGeom.PrimvarsAPI(prim).FindIncrementallyInheritablePrimvars(list(place.primvars)) or place.primvars
                         if p.GetInterpolation() == "constant")
        drawn = {}
        for number, target in enumerate(prototypes):
            prototype = self.stage.GetPrimAtPath(target)
            if not prototype:
                self.notes.fault("the prototype %s does not exist" % target, prim=prim.GetPath())
                continue
            chosen = _places(indices, number, shown)
            if not len(chosen):
                continue
            instancer.indices = V("int[]", chosen)
            old, new = str(prototype.GetPath()), None
            if not old.startswith(str(prim.GetPath()) + "/"):
                new = "%s/%s" % (instancer.name, prototype.GetName())
                drawn[new] = drawn.get(new, 0) + 1
                new += "_%d" % drawn[new] if drawn[new] > 1 else ""
            parent = prototype.GetParent()
            root = self.world.GetLocalToWorldTransform(parent).GetInverse() if parent else Gf.Matrix4d(1)
            inner = Place(purpose=place.purpose, primvars=primvars, instancer=instancer, moved=(old, new) if new else place.moved, root=root)
            groups = {}
            self._prim(prototype, inner, groups)
            for key in groups:
                self._instances(groups[key], inner)
        self._finish(instancer)

    # Materials, for all meshes at once ------------------------------------------------------------------
    def _bind(self):
        prims, of = [], []
        for number, (name, prim, fields) in enumerate(self.meshes):
            prims.append(prim), of.append((number, None))
            if prim.GetTypeName() == "Mesh":
                for subset in UsdShade.MaterialBindingAPI(prim).GetMaterialBindSubsets():
                    prims.append(subset.GetPrim()), of.append((number, subset))
        purposes = [str(p) for p in self.binding] if self.binding else ["full", ""]
        bound = self._bound(prims, purposes)
        kept = {}
        for (number, subset), material in zip(of, bound):
            name, prim, fields = self.meshes[number]
            value = self.looks.bind(material)
            if subset is None:
                if value:
                    fields["material"] = value
                kept[number] = value
                continue
            faces = subset.GetIndicesAttr().Get(self.time)
            if faces and (value or kept[number]):
                where = "subsets:%s/%s" % (name, subset.GetPrim().GetName())
                fields[where + ":faces"] = V("int[]", faces)
                fields[where + ":material"] = value or kept[number]
        for name, prim, fields in self.meshes:
            self.sink.set(name, "mesh", fields)

    @staticmethod
    def _bound(prims, purposes):
        """The materials by the first purpose that has one."""
        found = [None] * len(prims)
        for purpose in ["full" if p == "full" else "" if p in ("", "allPurpose") else p for p in purposes]:
            if all(found):
                break
            asked = [i for i, f in enumerate(found) if not f]
            materials, _ = UsdShade.MaterialBindingAPI.ComputeBoundMaterials([prims[i] for i in asked], purpose)
            for i, material in zip(asked, materials):
                found[i] = material if material else None
        return found


def _local(xformable, time):
    local = xformable.GetLocalTransformation(time)
    return local if isinstance(local, Gf.Matrix4d) else local[0]


def _matrices(all):
    import array as arrays
    made = arrays.array("d")
    for m in all:
        made.frombytes(memoryview(m).cast("B"))
    return made


def _real_first(turns):
    """USD's quaternions have the real part last."""
    import array as arrays
    view = memoryview(turns)
    half = view.format == "e"
    source = arrays.array("H" if half else "I")
    source.frombytes(view.cast("B"))
    made = arrays.array(source.typecode, bytes(len(source) * source.itemsize))
    made[0::4], made[1::4], made[2::4], made[3::4] = source[3::4], source[0::4], source[1::4], source[2::4]
    return V("quaternion of halves[]" if half else "quaternion[]", made)


def _places(indices, number, shown):
    """The instances of a prototype: those of its number that are shown."""
    import array as arrays
    view = memoryview(indices)
    if shown:
        return arrays.array("i", [i for i, (n, s) in enumerate(zip(view, shown)) if n == number and s])
    return arrays.array("i", [i for i, n in enumerate(view) if n == number])
