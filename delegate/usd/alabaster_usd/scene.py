"""A stage as edits of a scene, in order: cameras and settings, the walk over the prims, materials, instancers."""
import hashlib

from pxr import Gf, Sdf, Usd, UsdGeom, UsdLux, UsdShade, UsdSkel

from . import geometry, lights, views
from .looks import Looks
from .notes import Fault
from .values import Samples, V, array, matrix, path, token

MOST_LIGHTS = 1000  # of a PointInstancer
RENDER_TAGS = {"default": "geometry", "render": "render", "proxy": "proxy", "guide": "guide"}


class Place:
    """Where the walk is: what prims inherit."""

    def __init__(self, xform=None, purpose="default", primvars=(), instancer=None, moved=None, root=None, moves=None, origin=None, drawn=True, options=None):
        self.xform = xform or Gf.Matrix4d(1)  # to the world, or to the space of the instancer
        self.moves = moves                    # the same at the times of the shutter; None: it stands still
        self.purpose, self.primvars = purpose, primvars
        self.instancer = instancer  # that draws what is met here
        self.moved = moved          # (from, to): prims below one path are named below another
        self.root = root or Gf.Matrix4d(1)  # from the world to the instancer's space, where it was met first
        self.origin = origin        # the path of the outermost instancer, or None
        self.drawn = drawn          # False: on the way to what differs from the last answer
        self.options = options or {}  # fields of meshes that the pass gives to the instancer that draws them

    def below(self, **changes):
        made = Place(self.xform, self.purpose, self.primvars, self.instancer, self.moved, self.root, self.moves, self.origin, self.drawn, self.options)
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
        self.name, self.fields, self.parent, self.transform = name, fields, parent, transform
        self.indices = None  # the instances of the prototype that is walked
        self.drawn_by = parent.indices if parent else None  # the parent's
        self.places = None   # gives the matrices of all instances
        fields["transform"] = matrix(transform)
        if parent:
            fields["parent"] = path(parent.name)
            parent.draws(name)

    def draws(self, name):
        self.fields["prototypes:" + name] = self.indices


class Reader:
    """Reads a stage at a time. `options`, all optional: camera, settings, pass, purposes, shutter, refine, width, hides_domes; record: by usdrecord's rules; library: also materials
    that nothing is drawn with."""

    def __init__(self, stage, sink, notes, time=None, options=None):
        options = options or {}
        self.stage, self.options = stage, options
        self.refine = options.get("refine", 2)
        self.looks = Looks(stage)
        self.up = str(UsdGeom.GetStageUpAxis(stage))
        self.links, self.shapes = lights.Links(), {}
        self.cameras, self.lights = {}, []
        self.points, self.lit_points = [], set()  # PointInstancers; names of the lights that they have now
        self.skeletons = geometry.Skeletons()
        self.chosen = views.Pass(stage, options["pass"], notes) if options.get("pass") else None
        self.origins = {}    # names of meshes and instancers -> the path of the prim that they are read from
        self.changes = None  # Changes, once a second time is asked for
        self.taken_apart = None  # paths below which a collection tells prims apart
        self.within = {}     # paths of prototypes -> names of the primvars that prims within them have
        self.said = {}       # of cameras and lights, as they were last
        self._begin(time, sink, notes)

    def _begin(self, time, sink, notes):
        if time is None and (self.stage.HasAuthoredTimeCodeRange() or self.options.get("record")):
            time = self.stage.GetStartTimeCode()
        self.time = Usd.TimeCode.EarliestTime() if time is None else Usd.TimeCode.Default() if time == "default" else Usd.TimeCode(time)
        self.sink, self.notes, self.meshes = sink, notes, []
        self.drawn_lights = {}  # meshes -> (to the space of the instancer, the instancer, its instances that draw them)
        self.world = UsdGeom.XformCache(self.time)
        self.looks.begin(sink, notes, self.time)

    # In order of time ---------------------------------------------------------------------------------
    def run(self):
        """Returns what stands beside the prims in an archive."""
        self._find_cameras_and_lights()
        settings = self._read_settings()
        self._view_and_light()
        self._children(self.stage.GetPseudoRoot(), Place())
        self._bind()
        if self.options.get("library"):
            for prim in self.stage.Traverse():
                if prim.IsA(UsdShade.Material):
                    self.looks.bind(UsdShade.Material(prim))
        return {"settings": settings}

    def advance(self, time, sink, notes):
        """Writes the prims that differ from the last answer to `sink`; returns the names of those that are gone. May be asked again where it fails."""
        last = dict(self.origins), dict(self.said), set(self.lit_points), dict(self.looks.done)
        try:
            return self._advance(time, sink, notes)
        except Exception:
            self.origins, self.said, self.lit_points, self.looks.done = last
            raise

    def _advance(self, time, sink, notes):
        self._begin(time, sink, notes)
        self.changes = self.changes or Changes(self.stage)
        if self.settings and _varies(self.settings):
            self.notes.tell("settings that change with time keep the values of the first frame", self.settings.GetPath())
        self._choose_shutter()
        gone = self._view_and_light()
        before = {name for name, origin in self.origins.items() if self.changes.holds(origin)}
        for name in before:
            del self.origins[name]
        self._children(self.stage.GetPseudoRoot(), Place(drawn=False))
        self.looks.renew(self.changes.others)
        self._bind()
        return sorted([name for name in before if name not in self.origins] + gone)

    def _find_cameras_and_lights(self):
        """Also those in instances, of which each is one of its own."""
        everything = iter(Usd.PrimRange(self.stage.GetPseudoRoot(),
                                        Usd.TraverseInstanceProxies() if self._in_prototypes() else Usd.PrimDefaultPredicate))
        for prim in everything:
            if prim.IsA(UsdGeom.Camera):
                self.cameras[str(prim.GetPath())] = prim
            elif prim.IsA(UsdGeom.PointInstancer):
                self.points.append(prim)
                if any(p.IsA(UsdGeom.Camera) for p in Usd.PrimRange(prim)):
                    self.notes.tell("cameras of PointInstancers are not read", prim.GetPath())
                everything.PruneChildren()
            elif lights.is_light(prim):
                self.links.add(prim, self.notes)
                if self._lets_light(prim):
                    self.lights.append((prim, str(prim.GetPath()), None))
            else:
                lights.tell_unread(prim, self.notes)

    def _lets_light(self, prim):
        return not self.chosen or (self.chosen.shows(prim.GetPath()) and not self.chosen.prunes(prim.GetPath()))

    def _lights_of_points(self):
        """One for each point: (light, name, (instancer, prototype, place among the points))."""
        for prim in self.points:
            points = UsdGeom.PointInstancer(prim)
            indices = points.GetProtoIndicesAttr().Get(self.time) or ()
            for number, target in enumerate(points.GetPrototypesRel().GetForwardedTargets()):
                prototype = self.stage.GetPrimAtPath(target)
                for light in (p for p in (Usd.PrimRange(prototype) if prototype else ()) if lights.is_light(p)):
                    chosen = _places(indices, number, points.ComputeMaskAtTime(self.time)) if len(indices) else ()
                    if len(chosen) > MOST_LIGHTS:
                        self.notes.tell("a PointInstancer has more than %d lights, which are not read" % MOST_LIGHTS, prim.GetPath())
                        continue
                    if str(light.GetPath()) not in self.links.fields:
                        self.links.add(light, self.notes)
                    if not (self._lets_light(light) and self._lets_light(prim)):
                        continue
                    below = str(light.GetPath())[len(str(target)):]
                    for i in chosen:
                        yield light, "%s/%s_%d%s" % (prim.GetPath(), prototype.GetName(), i, below), (points, prototype, i)

    def _light_place(self, light, instance, time, known):
        """(its transform, whether it is visible). `known` has the transforms of instancers."""
        if not instance:
            return UsdGeom.Imageable(light).ComputeLocalToWorldTransform(time), UsdGeom.Imageable(light).ComputeVisibility(time) != "invisible"
        points, prototype, i = instance
        to_world = lambda prim: UsdGeom.Imageable(prim).ComputeLocalToWorldTransform(time)
        if points not in known:
            known[points] = points.ComputeInstanceTransformsAtTime(time, time, UsdGeom.PointInstancer.IncludeProtoXform, UsdGeom.PointInstancer.IgnoreMask)
        placed = known[points][i] if i < len(known[points]) else Gf.Matrix4d(0)
        visible = points.ComputeVisibility(time) != "invisible" and UsdGeom.Imageable(light).GetVisibilityAttr().Get(time) != "invisible"
        return to_world(light) * to_world(prototype).GetInverse() * placed * to_world(points), visible

    def _in_prototypes(self):
        return any(p.IsA(UsdGeom.Camera) or lights.is_light(p)
                   for prototype in self.stage.GetPrototypes() for p in Usd.PrimRange(prototype))

    def _choose_shutter(self):
        """The times at which what moves is sampled: of the camera's shutter, or of the options'; for AOV motion of the next frame, too."""
        self.shutter, prim, settings = None, self.cameras.get(self.main), self.settings
        given = self.options.get("shutter")
        if not self.time.GetValue() > -1e300:  # the default time is no number
            return
        opens = closes = 0
        if (given or prim) and not (settings and views.all_disabled(settings, "disableMotionBlur")):
            opens, closes = given or [prim.GetAttribute("shutter:" + n).Get(self.time) or 0 for n in ("open", "close")]
        blurs = closes > opens
        ends = (t for t in (0.0, 1.0) if not (blurs and opens <= t <= closes)) if self.shows_motion else ()  # within it, a sample would change the blur
        times = {*(self._between(opens, closes) if blurs else ()), *ends}
        if times:
            self.shutter = sorted(times)
            self.shutter_times = [Usd.TimeCode(self.time.GetValue() + t) for t in self.shutter]

    def _view_and_light(self):
        """Cameras and lights, if they differ from the last answer. Returns the names of lights that are gone."""
        for where, one in self.cameras.items():
            fields = views.camera_fields(one, self.world.GetLocalToWorldTransform(one), self.time)
            if self.shutter:
                fields.update(views.lens_samples(one, self.time, self.shutter, self.notes))
            if self.settings and views.all_disabled(self.settings, "disableDepthOfField"):
                fields["fStop"] = V("float", 0.0)
                fields.pop("fStop:samples", None)
            if self.shutter:
                moves = [UsdGeom.Xformable(one).ComputeLocalToWorldTransform(t) for t in self.shutter_times]
                if any(m != moves[0] for m in moves):
                    fields["transform:samples"] = self._samples(moves)
            self._say(where, "camera", fields)
        known, of_points = {}, list(self._lights_of_points())
        then = [(t, {}) for t in self.shutter_times] if self.shutter else ()
        gone = sorted(self.lit_points - {name for _, name, _ in of_points})
        for name in gone:
            self.said.pop(name, None)
        self.lit_points = {name for _, name, _ in of_points}
        for light, name, instance in self.lights + of_points:
            place, visible = self._light_place(light, instance, self.time, known)
            kind, fields = lights.light_fields(light, place, visible, self.time, self.up, self.links.fields[str(light.GetPath())], self.notes)
            moves = [self._light_place(light, instance, t, held)[0] for t, held in then]
            if any(m != moves[0] for m in moves):
                fields["transform:samples"] = self._samples([lights.placed(light, m, self.up) for m in moves])
            if (kind == "domeLight" and self.options.get("hides_domes")) or (
                    self.chosen and not all(self.chosen.is_seen(p.GetPath()) for p in (light, *(instance[:1] if instance else ())))):
                fields["visibleToCamera"] = V("bool", False)
            self._say(name, kind, fields)
        return gone

    def _say(self, where, kind, fields):
        said = repr(fields)
        if self.said.get(where) != said:
            self.said[where] = said
            self.sink.set(where, kind, fields)

    def _between(self, opens, closes):
        """Both ends, and up to seven times between at which something has a sample."""
        now = self.time.GetValue()
        between, interval = set(), Gf.Interval(now + opens, now + closes)
        for prim in self.changes.movers if self.changes else self.stage.Traverse():
            if prim.IsA(UsdGeom.Xformable):
                xformable = UsdGeom.Xformable(prim)
                if xformable.TransformMightBeTimeVarying():
                    between.update(xformable.GetTimeSamplesInInterval(interval))
        between = sorted(t - now for t in between if opens < t - now < closes)
        between = between if len(between) <= 7 else [opens + (closes - opens) * i / 8 for i in range(1, 8)]
        return [opens, *between, closes]

    def _samples(self, moves):
        return V("samples", Samples(self.shutter, [matrix(m) for m in moves]))

    def _camera(self, name):
        """The camera of a path or a name; None: there is none."""
        if not name or name in self.cameras:
            return name or None
        return next((c for c in self.cameras if c.endswith("/" + name)), None) if not name.startswith("/") else None

    def _read_settings(self):
        record, asked = self.options.get("record"), self._camera(self.options.get("camera"))
        if record and self.options.get("camera") and not asked:
            self.notes.tell("the stage has no camera of that name", self.options["camera"])
        named = self.options.get("settings") or (self.chosen.settings if self.chosen else None)
        prim = views.choose_settings(self.stage, named, self.notes, only_named=record)
        where, fields, further = "/render", {}, []
        main = asked or self._camera("main_cam") or (None if record else next(iter(self.cameras), None))
        if prim:
            where = str(prim.GetPath())
            fields, further = views.settings_fields(prim, self.time, self.notes, self.cameras, self.options.get("may_write", lambda file: True),
                                                    self.options.get("aovs", ()))
            if main and ("camera" not in fields or (record and asked)):
                fields["camera"] = path(main)
        elif not record:
            fields = views.default_settings(main, self.cameras.get(main), self.time, self.options.get("width") or 1280)
        elif main:
            fields["camera"] = path(main)
        if record and "products:0:file" not in fields:
            fields.pop("crop", None)
            fields.update(views.recorded_size(self.cameras.get(fields["camera"].data) if "camera" in fields else None, self.time, self.options["width"]))
        self.binding = prim.GetAttribute("materialBindingPurposes").Get() if prim else None
        self.main, self.settings = asked or (fields["camera"].data if "camera" in fields else None), prim
        if record and not self.main:
            self.cameras = {}  # the stage is framed
        self.shows_motion = self.options["next_frame"] if "next_frame" in self.options else any(
            f[n].data == "motion" for f in (fields, *further) for n in f if ":vars:" in n and not n.endswith(":dataType"))
        self._choose_shutter()
        purposes = self.options.get("purposes")
        for purpose in purposes or ():
            if purpose not in RENDER_TAGS:
                raise Fault("'%s' is no purpose: choose from %s" % (purpose, ", ".join(RENDER_TAGS)))
        if purposes:
            fields["includedPurposes"] = V("token[]", purposes)
        self.purposes = set(fields["includedPurposes"].data) if "includedPurposes" in fields else {"default", "render"}
        while self.stage.GetPrimAtPath(where) and not prim:
            where += "_"
        self.sink.set(where, "renderSettings", fields)
        for number, one in enumerate(further):
            if purposes:
                one["includedPurposes"] = fields["includedPurposes"]
            if "camera" not in one and "camera" in fields:
                one["camera"] = fields["camera"]
            self.sink.set("%s/product_%d" % (where, number + 2), "renderSettings", one)
        return where

    # The walk -----------------------------------------------------------------------------------------
    def _children(self, parent, place):
        """Instances of one prototype that inherit the same are drawn by one instancer."""
        groups = {}
        ways = None if place.drawn else self.changes.ways.get(str(parent.GetPath()), ())
        for prim in parent.GetFilteredChildren(Usd.TraverseInstanceProxies(Usd.PrimDefaultPredicate)):
            if ways is None or prim.GetName() in ways:
                self._prim(prim, place, groups)
        for key in groups:
            self._instances(groups[key], place)

    def _prim(self, prim, place, groups):
        if self.chosen and self.chosen.prunes(prim.GetPath()):
            return
        if not place.drawn and str(prim.GetPath()) in self.changes.whole:
            place = place.below(drawn=True)
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
            skel = UsdSkel.BindingAPI(prim)
            key = (str(prim.GetPrototype().GetPath()), self._bindings(prim), place.purpose, self._apart(prim),
                   tuple((p.GetPrimvarName(), str(p.GetTypeName())) if self._may_differ(p, prim) else str(p.GetAttr().GetPath())
                         for p in UsdGeom.PrimvarsAPI(prim).FindInheritablePrimvars()),
                   *(str(p.GetPath()) if p else "" for p in (skel.GetInheritedAnimationSource(), skel.GetInheritedSkeleton())))
            groups.setdefault(key, []).append((prim, place))
            return
        self._draw(prim, place)

    def _may_differ(self, primvar, instance):
        """Whether instances that are drawn as one may each have a value: it would replace that of a mesh, so nothing within has one."""
        within = self.within.get(instance.GetPrototype().GetPath())
        if within is None:
            below = (p for child in instance.GetFilteredChildren(Usd.TraverseInstanceProxies()) for p in Usd.PrimRange(child, Usd.TraverseInstanceProxies()))
            within = self.within[instance.GetPrototype().GetPath()] = {
                v.GetPrimvarName() for p in below if p.IsA(UsdGeom.Imageable) for v in UsdGeom.PrimvarsAPI(p).GetPrimvarsWithAuthoredValues()}
        return primvar.GetPrimvarName() not in within and geometry.one_value(primvar, self.time) is not None

    def _bindings(self, prim):
        """What an instance inherits: the material of each purpose, and whether it is stronger than those below."""
        found = []
        for purpose in self._purposes_of_materials():
            material, binding = UsdShade.MaterialBindingAPI(prim).ComputeBoundMaterial(purpose)
            found.append((str(material.GetPath()), UsdShade.MaterialBindingAPI.GetMaterialBindingStrength(binding)) if material else None)
        return tuple(found)

    def _apart(self, prim):
        """Instances that light links, a pass or bindings of collections take apart are not drawn as one."""
        where = str(prim.GetPath())
        queries = self.chosen.queries.values() if self.chosen else ()
        if self.taken_apart is None:
            bound = [c.GetCollection() for p in self.stage.Traverse() for purpose in self._purposes_of_materials()
                     for c in UsdShade.MaterialBindingAPI(p).GetCollectionBindings(purpose) if c.IsValid()]
            every = [*queries, *(q for _, q in self.links.of), *(c.ComputeMembershipQuery() for c in bound if c)]
            self.taken_apart = {str(a) for q in every for p in q.GetAsPathExpansionRuleMap() for a in p.GetPrefixes()[:-1]}
        return where if where in self.taken_apart else tuple(lights.holds(q, where) for q in queries)

    def _purposes_of_materials(self):
        return [p if p != "allPurpose" else "" for p in (str(p) for p in self.binding)] if self.binding else ["full", ""]

    def _draw(self, prim, place):
        kind = prim.GetTypeName()
        if prim.IsA(UsdSkel.Root) and place.drawn:
            self.skeletons.populate(prim)
        if prim.IsA(UsdGeom.PointInstancer):
            return self._points(prim, place)
        if prim.HasAPI(UsdGeom.ModelAPI) and place.drawn:
            mode = UsdGeom.ModelAPI(prim).GetModelDrawModeAttr().Get() or UsdGeom.ModelAPI(prim).ComputeModelDrawMode()
            if mode not in ("default", "inherited"):
                self.notes.tell("draw modes are not read: the objects are drawn", prim.GetPath())
        if place.purpose in self.purposes and place.drawn:
            if kind == "Mesh":
                self._mesh(prim, place, geometry.mesh_fields(prim, self.time, self.refine, self.notes))
            elif kind in geometry.IMPLICIT:
                self._mesh(prim, place, geometry.implicit_fields(prim, self.time, self.shapes, self.notes), True)
            elif kind in geometry.KINDS:
                self._mesh(prim, place, geometry.curve_fields(prim, self.time, self.notes))
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
        if fields is None or (self.chosen and not self.chosen.shows(prim.GetPath())):
            return
        geometry.add_primvars(prim, place.primvars, fields, self.time, self.notes, is_implicit)
        xform, moves, rest = place.xform, place.moves, fields["primvars:points"]
        space = None if is_implicit else self.skeletons.deform(prim, fields, self.time, self.shutter, self.notes)
        if space:
            xform, moves = self.world.GetLocalToWorldTransform(space) * place.root, None
            if self.shutter:
                at = [UsdGeom.Imageable(space).ComputeLocalToWorldTransform(t) * place.root for t in self.shutter_times]
                moves = at if any(m != at[0] for m in at) else None
        if xform != Gf.Matrix4d(1):
            fields["transform"] = matrix(xform)
        if moves:
            fields["transform:samples"] = self._samples(moves)
        if self.shutter and (prim.GetTypeName() == "Mesh" or prim.GetTypeName() in geometry.KINDS) and fields["primvars:points"] is rest:
            geometry.add_motion(prim, fields, self.shutter, self.time, self.notes)
        if place.purpose != "default":
            fields["renderTag"] = token(RENDER_TAGS.get(place.purpose, "geometry"))
        if self.chosen:
            fields.update({**self.chosen.options(prim.GetPath()), **place.options})
        name = place.name(prim)
        if place.instancer and lights.is_mesh_light(prim):
            self.drawn_lights[name] = xform, place.instancer, place.instancer.indices.data
        if place.instancer:
            fields["instancer"] = path(place.instancer.name)
            place.instancer.draws(name)
        if self.links.of and not (place.instancer and place.instancer.of_links):
            categories = self.links.categories(prim.GetPath())
            if categories:
                fields["categories"] = V("token[]", categories)
        self.origins[name] = place.origin or str(prim.GetPath())
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
        inherited = [{p.GetPrimvarName(): p for p in UsdGeom.PrimvarsAPI(m[0]).FindInheritablePrimvars()} for m in members]
        for name, primvar in inherited[0].items():
            if self._may_differ(primvar, first):
                geometry.add_by_native_instance([of[name] for of in inherited], fields, self.time)
        instancer = Instancer(first_place.name(first), Gf.Matrix4d(1), place.instancer, fields)
        instancer.indices, instancer.places = array("int", range(len(members))), lambda: [m[1].xform for m in members]
        instancer.of_links = self._links_of([m[0].GetPath() for m in members], fields)
        instancer.origin = place.origin or str(first.GetPath())
        inner = first_place.below(xform=Gf.Matrix4d(1), moves=None, instancer=instancer, root=self.world.GetLocalToWorldTransform(first).GetInverse(),
                                  origin=instancer.origin)
        self._draw(first, inner)
        self._finish(instancer)

    def _links_of(self, paths, fields):
        """Categories by instance."""
        for name, query in self.links.of:
            held = [i for i, p in enumerate(paths) if lights.holds(query, p)]
            if held:
                fields["categories:" + name] = array("int", held)
        return bool(self.links.of)

    def _finish(self, instancer):
        self.origins[instancer.name] = instancer.origin
        self.sink.set(instancer.name, "instancer", instancer.fields)

    def _points(self, prim, place):
        if self.chosen and not self.chosen.shows(prim.GetPath()):
            return None
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
        # Of more positions than indices OpenUSD gives none; areas need their scales alone.
        instancer.places = lambda: points.ComputeInstanceTransformsAtTime(
            self.time, self.time, UsdGeom.PointInstancer.ExcludeProtoXform, UsdGeom.PointInstancer.IgnoreMask) or [
                Gf.Matrix4d(1).SetScale(Gf.Vec3d(s)) for s in (*(scales if scales and len(scales) == len(indices) else ()), *[Gf.Vec3f(1)] * len(positions))][:len(positions)]
        instancer.of_links, instancer.origin = False, place.origin or str(prim.GetPath())
        if place.moves:
            fields["transform:samples"] = self._samples(place.moves)
        if self.shutter:
            self._move_points(points, positions, fields)
        for primvar in UsdGeom.PrimvarsAPI(prim).GetPrimvarsWithAuthoredValues():
            if primvar.GetInterpolation() != "constant" and ":" not in primvar.GetPrimvarName():
                geometry.add_by_instance(primvar, len(positions), fields, self.time, self.notes)
        primvars = tuple(p for p in UsdGeom.PrimvarsAPI(prim).FindIncrementallyInheritablePrimvars(list(place.primvars)) or place.primvars
                         if p.GetInterpolation() == "constant")
        if min(indices) < 0 or max(indices) >= len(prototypes):
            self.notes.tell("points of a PointInstancer name a prototype that it does not have, and draw nothing", prim.GetPath())
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
            inner = Place(purpose=place.purpose, primvars=primvars, instancer=instancer, moved=(old, new) if new else place.moved, root=root,
                          origin=instancer.origin, options={**place.options, **(self.chosen.options(prim.GetPath()) if self.chosen else {})})
            groups = {}
            self._prim(prototype, inner, groups)
            for key in groups:
                self._instances(groups[key], inner)
        self._finish(instancer)

    def _move_points(self, points, positions, fields):
        """Samples over the shutter. Where more than velocities moves them, the places are matrices."""
        prefix = "primvars:hydra:instance"
        own = [points.GetPositionsAttr(), points.GetOrientationsAttr(), points.GetScalesAttr()]
        own += [points.GetOrientationsfAttr()] if hasattr(points, "GetOrientationsfAttr") else []
        varying = [a for a in own if a.ValueMightBeTimeVarying()]
        turns = points.GetAngularVelocitiesAttr().Get(self.time)
        if not turns and not any(a in varying for a in own[1:]) and geometry.add_velocities(
                points.GetVelocitiesAttr(), prefix + "Translations", positions, fields, self.shutter, self.time, self.stage):
            return
        if not varying and not turns:
            return
        now = self.time.GetValue()
        within = Gf.Interval(now + self.shutter[0], now + self.shutter[-1])
        even = [self.shutter[0] + (self.shutter[-1] - self.shutter[0]) * i / 8 for i in range(1, 8)] if turns else []
        times = sorted({*self.shutter, *even, *(t - now for a in varying for t in a.GetTimeSamplesInInterval(within))})[:24]
        at = lambda t: points.ComputeInstanceTransformsAtTime(Usd.TimeCode(now + t), self.time, UsdGeom.PointInstancer.ExcludeProtoXform, UsdGeom.PointInstancer.IgnoreMask)
        moved = [at(t) for t in times]
        if any(len(m) != len(positions) for m in moved):
            return self.notes.tell("points whose number changes within the shutter stand still", points.GetPath())
        for name in ("Translations", "Rotations", "Scales"):
            fields.pop(prefix + name, None)
        fields[prefix + "Transforms"] = V("matrix[]", at(0))
        fields[prefix + "Transforms:samples"] = V("samples", Samples(times, [V("matrix[]", m) for m in moved]))

    # Materials, for all meshes at once ------------------------------------------------------------------
    def _bind(self):
        prims, of = [], []
        for number, (name, prim, fields) in enumerate(self.meshes):
            prims.append(prim), of.append((number, None))
            if prim.GetTypeName() == "Mesh":
                for subset in UsdShade.MaterialBindingAPI(prim).GetMaterialBindSubsets():
                    if subset.GetElementTypeAttr().Get() != "face":
                        self.notes.tell("subsets of anything but faces have no material of their own", subset.GetPrim().GetPath())
                        continue
                    prims.append(subset.GetPrim()), of.append((number, subset))
        bound = self._bound(prims, self._purposes_of_materials())
        kept = {}
        for (number, subset), material in zip(of, bound):
            name, prim, fields = self.meshes[number]
            if lights.is_mesh_light(prim):
                if subset is None:
                    glow, primvar = name + "/light", "emission_" + hashlib.sha256(name.encode()).hexdigest()[:16]
                    made, by_instance = lights.glow_fields(prim, lambda: self._areas(name, prim), primvar, self.time, self.notes)
                    self.sink.set(glow, "material", made)
                    if by_instance:
                        self._emit_by_instance(name, primvar, by_instance)
                    fields["material"] = path(glow)
                    fields.update(lights.group_fields(prim, self.time))
                continue
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
            self.sink.set(name, geometry.KINDS.get(prim.GetTypeName(), "mesh"), fields)

    def _areas(self, name, prim):
        """In the world: of each instance that draws the mesh, as its outer instancers place it first."""
        areas = lights.Areas(UsdGeom.Mesh(prim), self.time)
        if name not in self.drawn_lights:
            return [areas.under(self.world.GetLocalToWorldTransform(prim))]
        xform, instancer, indices = self.drawn_lights[name]
        all, outer = instancer.places(), _outer_places(instancer)
        placed = [xform * all[i] * instancer.transform for i in indices]
        if any(abs(areas.under(placed[0] * o) / areas.under(placed[0] * outer[0]) - 1) > 1e-4 for o in outer[1:] if areas.under(placed[0] * outer[0]) > 0):
            self.notes.tell("meshes that are lights have the power of the first place where instancers within instancers scale them unlike", prim.GetPath())
        return [areas.under(p * outer[0]) for p in placed]

    def _emit_by_instance(self, name, primvar, emissions):
        _, instancer, indices = self.drawn_lights[name]
        values = [0.0] * (3 * len(instancer.places()))
        for i, emission in zip(indices, emissions):
            values[3 * i:3 * i + 3] = emission
        self.sink.edit(instancer.name, {"primvars:" + primvar: array("float3", values)})

    def _bound(self, prims, purposes):
        """The materials by the first purpose that has one."""
        found, lost = [None] * len(prims), set()
        for purpose in purposes:
            if all(found):
                break
            asked = [i for i, f in enumerate(found) if not f]
            materials, bindings = UsdShade.MaterialBindingAPI.ComputeBoundMaterials([prims[i] for i in asked], purpose)
            for i, material, binding in zip(asked, materials, bindings):
                found[i] = material if material else None
                if not material and binding and binding.GetTargets():
                    lost.add(i)
        for i in sorted(lost):
            if not found[i]:
                self.notes.tell("bindings lead to no material", prims[i].GetPath())
        return found


class Changes:
    """What may differ at another time: `whole` paths, whose prims are read again with all below them, the `ways` to these (path -> names of
    children), `movers`, prims with a transform that may differ, and `others`: nodes of materials, say."""

    def __init__(self, stage):
        self.whole, self.ways, self.movers, self.others = set(), {}, [], set()
        self.held = {}  # what was asked of holds()
        prims = list(Usd.PrimRange(stage.GetPseudoRoot()))
        animated = False
        for prim in prims:
            if _varies(prim):
                animated = animated or prim.GetTypeName() in ("SkelAnimation", "Skeleton")
                self._add(prim)
        prototypes = self._changing_prototypes(stage)
        for prim in prims:
            if prim.IsInstance() and prim.GetPrototype().GetPath() in prototypes:
                self._add(prim)
            elif prim.IsA(UsdSkel.Root) and animated:
                self._add(prim)
        instancers = [p for p in prims if p.IsA(UsdGeom.PointInstancer)]
        known = None
        while known != len(self.whole):  # one may draw another
            known = len(self.whole)
            for prim in instancers:
                if any(self._differs(stage.GetPrimAtPath(t), prototypes) for t in UsdGeom.PointInstancer(prim).GetPrototypesRel().GetForwardedTargets()):
                    self._add(prim)
        # One instancer draws the instances that lie side by side.
        for where in list(self.whole):
            prim = stage.GetPrimAtPath(where)
            if prim.IsInstance():
                self.whole.update(str(p.GetPath()) for p in prim.GetParent().GetChildren() if p.IsInstance())
        for where in self.whole:
            at = Sdf.Path(where)
            while not at.IsAbsoluteRootPath():
                self.ways.setdefault(str(at.GetParentPath()), set()).add(at.name)
                at = at.GetParentPath()

    def holds(self, where):
        if where not in self.held:
            self.held[where] = any(str(p) in self.whole for p in Sdf.Path(where).GetPrefixes())
        return self.held[where]

    def _add(self, prim):
        if prim.IsA(UsdGeom.Xformable) and UsdGeom.Xformable(prim).TransformMightBeTimeVarying():
            self.movers.append(prim)
        if not prim.IsA(UsdGeom.Imageable) and not prim.IsA(UsdGeom.Subset):
            self.others.add(prim.GetPath())
            return
        if prim.IsA(UsdShade.NodeGraph):
            self.others.add(prim.GetPath())
        drawn, at = prim, prim.GetParent()
        while at and not at.IsPseudoRoot():  # those that draw what is below them, or whose children tell of them
            if at.IsA(UsdGeom.PointInstancer) or at.IsA(UsdSkel.Root) or at.IsA(UsdGeom.Gprim):
                drawn = at
            at = at.GetParent()
        self.whole.add(str(drawn.GetPath()))

    @staticmethod
    def _changing_prototypes(stage):
        changing, count = set(), -1
        while len(changing) > count:
            count = len(changing)
            for prototype in stage.GetPrototypes():
                if prototype.GetPath() not in changing and any(
                        _varies(p) or (p.IsInstance() and p.GetPrototype().GetPath() in changing) for p in Usd.PrimRange(prototype)):
                    changing.add(prototype.GetPath())
        return changing

    def _differs(self, prototype, prototypes):
        return bool(prototype) and any(str(p.GetPath()) in self.whole or _varies(p) or (p.IsInstance() and p.GetPrototype().GetPath() in prototypes)
                                       for p in Usd.PrimRange(prototype, Usd.PrimAllPrimsPredicate))


def _outer_places(instancer):
    """From the instancer to the world, by all that draw it."""
    outer = instancer.parent
    if not outer:
        return [Gf.Matrix4d(1)]
    all = outer.places()
    further = _outer_places(outer)
    return [all[i] * outer.transform * o for i in instancer.drawn_by.data for o in further][:MOST_LIGHTS]


def _varies(prim):
    return any(a.ValueMightBeTimeVarying() for a in prim.GetAuthoredAttributes())


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
