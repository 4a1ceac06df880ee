"""Meshes and what becomes one: their topology, points and primvars as fields."""
import math

from pxr import Gf, Usd, UsdGeom, UsdSkel, Vt

from .values import Samples, V, array, color_space_of, to_rec709, token, value_of

SCHEMES = ("none", "catmullClark", "loop", "bilinear")
KINDS = {"BasisCurves": "basisCurves", "Points": "points"}  # of prims; all others are meshes
UNREAD = {"NurbsCurves": "NURBS and Hermite curves", "HermiteCurves": "NURBS and Hermite curves", "Volume": "volumes",
          "NurbsPatch": "NURBS patches", "ParticleField3DGaussianSplat": "splats", "ParticleField": "splats"}
IMPLICIT = ("Cube", "Sphere", "Cylinder", "Cylinder_1", "Cone", "Capsule", "Capsule_1", "Plane")
ROLES = {"Color": "lin_rec709", "TextureCoordinate": "textureCoordinate", "Normal": "normal", "Vector": "vector", "Point": "point"}
OPTIONS = ("subsurfaceSet", "lightGroup", "holdout", "shadowCatcher", "visibleToCamera", "cryptoInstances", "cryptoObject", "cryptoAsset")
PLAIN = {"float2", "half2", "double2"}
AROUND, UP = 64, 32  # quads of a sphere


def mesh_fields(prim, time, refine, notes):
    """Topology, tags and points of a Mesh; None (told): it has none."""
    mesh = UsdGeom.Mesh(prim)
    points = floats3(mesh.GetPointsAttr().Get(time))
    counts, indices = mesh.GetFaceVertexCountsAttr().Get(time), mesh.GetFaceVertexIndicesAttr().Get(time)
    if not points or not counts or not indices:
        notes.tell("meshes without points or faces are not drawn", prim.GetPath())
        return None
    fields = {"faceVertexCounts": V("int[]", counts), "faceVertexIndices": V("int[]", indices), "primvars:points": V("float3[]", points)}
    scheme = mesh.GetSubdivisionSchemeAttr().Get(time)
    if scheme not in SCHEMES:
        notes.tell("a subdivision scheme is not known: %s" % scheme, prim.GetPath())
        scheme = "none"
    fields["scheme"] = token(scheme)
    if scheme == "none":
        _add_normals(mesh, fields, time)
    else:
        fields["refineLevel"] = V("int", refine)
        for name, attribute, kind in [("interpolateBoundary", mesh.GetInterpolateBoundaryAttr(), "token"),
                                      ("faceVaryingLinearInterpolation", mesh.GetFaceVaryingLinearInterpolationAttr(), "token"),
                                      ("triangleSubdivision", mesh.GetTriangleSubdivisionRuleAttr(), "token"),
                                      ("holeIndices", mesh.GetHoleIndicesAttr(), "int[]"),
                                      ("creaseIndices", mesh.GetCreaseIndicesAttr(), "int[]"),
                                      ("creaseLengths", mesh.GetCreaseLengthsAttr(), "int[]"),
                                      ("creaseWeights", mesh.GetCreaseSharpnessesAttr(), "float[]"),
                                      ("cornerIndices", mesh.GetCornerIndicesAttr(), "int[]"),
                                      ("cornerWeights", mesh.GetCornerSharpnessesAttr(), "float[]")]:
            value = attribute.Get(time) if attribute.HasAuthoredValue() else None
            if value is not None and len(value):
                fields[name] = V(kind, value)
    add_sides(mesh, fields, time)
    return fields


def curve_fields(prim, time, notes):
    """Topology, points and widths of BasisCurves or Points; None (told): it has none."""
    curves, fields = UsdGeom.BasisCurves(prim), {}
    points = floats3(curves.GetPointsAttr().Get(time))
    if prim.IsA(UsdGeom.BasisCurves):
        counts = curves.GetCurveVertexCountsAttr().Get(time)
        fields = {"curveVertexCounts": V("int[]", counts), "type": token(curves.GetTypeAttr().Get(time)),
                  "basis": token(curves.GetBasisAttr().Get(time)), "wrap": token(curves.GetWrapAttr().Get(time))}
        for name, known in (("type", ("linear", "cubic")), ("basis", ("bezier", "bspline", "catmullRom")),
                            ("wrap", ("nonperiodic", "periodic", "pinned"))):
            if fields[name].data not in known:
                notes.tell("a %s of curves is not known: %s" % (name, fields.pop(name).data), prim.GetPath())
        if curves.GetNormalsAttr().HasAuthoredValue() or UsdGeom.PrimvarsAPI(prim).GetPrimvar("normals").HasAuthoredValue():
            notes.tell("ribbons are drawn as tubes: the normals of curves are not read", prim.GetPath())
    if not points or ("curveVertexCounts" in fields and not fields["curveVertexCounts"].data):
        notes.tell("curves and points without points draw nothing", prim.GetPath())
        return None
    fields["primvars:points"] = V("float3[]", points)
    gprim = curves if prim.IsA(UsdGeom.BasisCurves) else UsdGeom.Points(prim)
    widths = gprim.GetWidthsAttr().Get(time)
    if widths:
        fields["primvars:widths"] = value_of(widths)  # may be halves or doubles in a file
        fields["primvars:widths:interpolation"] = token(gprim.GetWidthsInterpolation())
    return fields


def floats3(values):
    """Points and normals may be halves or doubles in a file; None: they are neither."""
    if isinstance(values, (Vt.Vec3dArray, Vt.Vec3hArray)):
        return Vt.Vec3fArray([Gf.Vec3f(*v) for v in values])
    return values if isinstance(values, Vt.Vec3fArray) else None


def add_sides(gprim, fields, time):
    if gprim.GetOrientationAttr().Get(time) == "leftHanded":
        fields["orientation"] = token("leftHanded")
    if not gprim.GetDoubleSidedAttr().Get(time):
        fields["doubleSided"] = V("bool", False)


def _add_normals(mesh, fields, time):
    primvar = UsdGeom.PrimvarsAPI(mesh).GetPrimvar("normals")
    if primvar and primvar.HasAuthoredValue():
        return  # it is among the primvars
    normals = floats3(mesh.GetNormalsAttr().Get(time)) if mesh.GetNormalsAttr().HasAuthoredValue() else None
    if normals:
        fields["primvars:normals"] = V("float3[]", normals)
        fields["primvars:normals:interpolation"] = token(mesh.GetNormalsInterpolation())


def add_primvars(gprim, inherited, fields, time, notes, is_implicit):
    """Those of the prim, and the constant ones of its ancestors. A gprim's own displayColor is there and may be empty."""
    known = {p.GetPrimvarName(): p for p in inherited}
    known.update((p.GetPrimvarName(), p) for p in UsdGeom.PrimvarsAPI(gprim).GetPrimvarsWithAuthoredValues()
                 if p.GetAttr().Get(time) is not None)
    for name, primvar in sorted(known.items()):
        if name.startswith("skel:"):
            continue
        if name in OPTIONS:  # of the renderer, given as constant primvars
            fields[name] = value_of(primvar.Get(time), str(primvar.GetTypeName()))
            continue
        if ":" in name and not name.startswith("st"):
            notes.vendors[name.split(":")[0]] = notes.vendors.get(name.split(":")[0], 0) + 1
            continue
        if name == "normals" and ("scheme" not in fields or fields["scheme"].data != "none"):
            continue  # of a subdivision surface, curves and points they follow from the shape
        made = _primvar(primvar, time, notes, gprim)
        if made is None:
            continue
        value, interpolation, role, indices = made
        if is_implicit and interpolation != "constant" and name != "widths":
            if value.type.endswith("[]") and len(value.data) == 1:
                interpolation = "constant"
            else:
                notes.tell("primvars of implicit surfaces are read where they are constant", gprim.GetPath())
                continue
        if name == "normals" and value.type != "float3[]":
            continue
        key = "primvars:" + name
        fields[key], fields[key + ":interpolation"] = value, token(interpolation)
        if role:
            fields[key + ":role"] = token(role)
        if indices is not None:
            fields[key + ":indices"] = V("int[]", indices)


def add_by_instance(primvar, count, fields, time, notes):
    """A primvar of a PointInstancer, which has a value for each of its points."""
    prim, name = primvar.GetAttr().GetPrim(), primvar.GetPrimvarName()
    if primvar.GetInterpolation() == "uniform" or name in OPTIONS:
        return notes.tell("primvars of PointInstancers that are uniform, and options of meshes by instance, are not read", prim.GetPath())
    made = _primvar(primvar, time, notes, prim)
    if made is None:
        return None
    value, _, role, indices = made
    given = len(indices) if indices is not None else len(value.data) if value.type.endswith("[]") else 1
    if given < count:
        return notes.tell("primvars by instance with too few values are not read: %s has %d for %d points" % (name, given, count), prim.GetPath())
    if indices is not None and not all(0 <= i < len(value.data) for i in indices[:count]):
        return notes.tell("primvars by instance whose indices lie beyond their values are not read: " + name, prim.GetPath())
    data = type(value.data)([value.data[i] for i in indices[:count]]) if indices is not None else value.data if given == count else value.data[:count]
    fields["primvars:" + name] = V(value.type, data)
    if role and role != "textureCoordinate":
        fields["primvars:" + name + ":role"] = token(role)
    return None


def one_value(primvar, time):
    """The one to four numbers of a constant primvar, colours in linear Rec. 709; None: it is no such value."""
    kind, name = str(primvar.GetTypeName()), primvar.GetPrimvarName()
    made = value_of(primvar.Get(time), kind)
    if made is None or ":" in name or name in OPTIONS or made.type.replace("[]", "").rstrip("234") not in ("float", "double", "half", "int"):
        return None
    space = color_space_of(primvar.GetAttr()) if primvar.GetTypeName().role == "Color" else ""
    made = to_rec709(made, space) if space else made
    if made is None or (made.type.endswith("[]") and len(made.data) != 1):
        return None
    value = made.data[0] if made.type.endswith("[]") else made.data
    return [float(c) for c in value] if hasattr(value, "__len__") else [float(value)]


def add_by_native_instance(primvars, fields, time):
    """The primvars of one name that native instances inherit, unless all have one value."""
    values = [one_value(p, time) for p in primvars]
    if all(v == values[0] for v in values):
        return
    key = "primvars:" + primvars[0].GetPrimvarName()
    fields[key] = array("float%d" % len(values[0]) if len(values[0]) > 1 else "float", [c for v in values for c in v])
    role = ROLES.get(str(primvars[0].GetTypeName().role), "")
    if role and role != "textureCoordinate":
        fields[key + ":role"] = token(role)


def _primvar(primvar, time, notes, gprim):
    value = primvar.Get(time)
    kind = str(primvar.GetTypeName()) or "that OpenUSD does not know"
    made = value_of(value, kind)
    if made is None or made.type.startswith(("string", "token", "matrix", "uint", "int64")):
        notes.tell("primvars of type %s are not read" % (kind if made is None or made.type.startswith("matrix") else made.type.replace("[]", "")
                                                        + " (texts and whole numbers of other sizes)"), gprim.GetPath())
        return None
    if primvar.GetElementSize() > 1:
        notes.tell("primvars of several elements for each place are not read", gprim.GetPath())
        return None
    if made.type.endswith("[]") and not len(made.data):
        return None
    interpolation = primvar.GetInterpolation()
    role = ROLES.get(str(primvar.GetTypeName().role), "")
    space = color_space_of(primvar.GetAttr()) if role == "lin_rec709" else ""
    if space:
        converted = to_rec709(made, space)
        if converted is None:
            notes.tell("colours in the space %s are taken as linear Rec. 709" % space, gprim.GetPath())
        made = converted or made
    if not role and made.type.replace("[]", "") in PLAIN:
        role = "textureCoordinate"
    indices = primvar.GetIndices(time) if primvar.IsIndexed() and made.type.endswith("[]") else None
    return made, str(interpolation), role, indices


def add_motion(prim, fields, shutter, time, notes):
    """Samples of points that move within the shutter, by velocities where there are any."""
    mesh = UsdGeom.PointBased(prim)
    attribute, points, now = mesh.GetPointsAttr(), fields["primvars:points"].data, time.GetValue()
    if add_velocities(mesh.GetVelocitiesAttr(), "primvars:points", points, fields, shutter, time, prim.GetStage()):
        return
    if not attribute.ValueMightBeTimeVarying():
        return
    within = attribute.GetTimeSamplesInInterval(Gf.Interval(now + shutter[0], now + shutter[-1]))
    times = sorted({shutter[0], shutter[-1], *(t - now for t in within)})[:16]
    moved = [floats3(attribute.Get(now + t)) for t in times]
    if any(m is None or len(m) != len(points) for m in moved):
        notes.tell("a mesh whose topology changes within the shutter stands still", prim.GetPath())
    elif any(m != moved[0] for m in moved):
        fields["primvars:points:samples"] = V("samples", Samples(times, [V("float3[]", m) for m in moved]))


def add_velocities(attribute, name, points, fields, shutter, time, stage):
    """Velocities are units a second. False: there are none."""
    velocities = floats3(attribute.Get(time)) if attribute and attribute.HasAuthoredValue() else None
    if not velocities or len(velocities) != len(points):
        return False
    rate = stage.GetTimeCodesPerSecond()
    ends = (shutter[0], shutter[-1])
    fields[name + ":samples"] = V("samples", Samples(ends, [V("float3[]", points + velocities * (t / rate)) for t in ends]))
    return True


# Implicit surfaces as closed meshes. The points are shared by all that have the same sizes.

def implicit_fields(prim, time, cache, notes):
    """None (told): it has no axis, or no size, which damaged clips leave out."""
    kind = prim.GetTypeName()
    sizes = tuple(prim.GetAttribute(n).Get(time) for n in
                  {"Cube": ("size",), "Sphere": ("radius",), "Cylinder": ("radius", "height", "axis"), "Cone": ("radius", "height", "axis"),
                   "Cylinder_1": ("radiusBottom", "radiusTop", "height", "axis"), "Capsule": ("radius", "height", "axis"),
                   "Capsule_1": ("radiusBottom", "radiusTop", "height", "axis"), "Plane": ("width", "length", "axis")}[kind])
    if None in sizes:
        notes.tell("shapes without a size are not drawn", prim.GetPath())
        return None
    if sizes[-1] not in "XYZ" if isinstance(sizes[-1], str) else False:
        notes.tell("an axis is not known: %s" % sizes[-1], prim.GetPath())
        return None
    key = (kind, sizes)
    if key not in cache:
        cache[key] = _scaled(cache, kind, *sizes) if kind in ("Sphere", "Cylinder") else _shape(kind, *sizes)
    fields = dict(cache[key])
    add_sides(UsdGeom.Gprim(prim), fields, time)
    return fields


def _scaled(cache, kind, radius, height=1.0, axis="Z"):
    """The shape of radius and height 1, about its axis and along it."""
    key = (kind, axis)
    if key not in cache:
        unit = _shape(*((kind, 1.0) if kind == "Sphere" else (kind, 1.0, 1.0, axis)))
        points, along = unit["primvars:points"].data, Gf.Vec3f(*_axis(axis)((0, 0, 1)))
        axial = Vt.Vec3fArray([along * Gf.Dot(p, along) for p in points]) if kind == "Cylinder" else points * 0.0
        cache[key] = unit, points - axial, axial
    unit, radial, axial = cache[key]
    return {**unit, "primvars:points": V("float3[]", radial * radius + axial * height)}


def _fields(points, faces, normals=None, rate="vertex"):
    fields = {"scheme": token("none"), "faceVertexCounts": array("int", [len(f) for f in faces]),
              "faceVertexIndices": array("int", [i for f in faces for i in f]),
              "primvars:points": V("float3[]", Vt.Vec3fArray([Gf.Vec3f(*p) for p in points]))}
    if normals:
        fields["primvars:normals"] = array("float3", [c for n in normals for c in n])
        fields["primvars:normals:interpolation"] = token(rate)
    return fields


def _axis(axis):
    """Turns a shape about z to stand about its axis, as USD does it: by a cyclic exchange."""
    return {"X": lambda p: (p[2], p[0], p[1]), "Y": lambda p: (p[1], p[2], p[0]), "Z": lambda p: p}[axis]


def _shape(kind, *sizes):
    if kind == "Cube":
        h = sizes[0] / 2
        points = [(x * h, y * h, z * h) for x in (-1, 1) for y in (-1, 1) for z in (-1, 1)]
        return _fields(points, [(0, 1, 3, 2), (4, 6, 7, 5), (0, 4, 5, 1), (2, 3, 7, 6), (0, 2, 6, 4), (1, 5, 7, 3)])
    if kind == "Plane":
        turn = {"X": lambda x, y: (0, y, -x), "Y": lambda x, y: (x, 0, -y), "Z": lambda x, y: (x, y, 0)}[sizes[2]]
        w, l = sizes[0] / 2, sizes[1] / 2
        return _fields([turn(*p) for p in ((-w, -l), (w, -l), (w, l), (-w, l))], [(0, 1, 2, 3)])
    # Turned profiles: (distance from the axis, place on it, normal's parts) from the bottom to the top.
    if kind == "Sphere":
        r = sizes[0]
        arcs = [[_on_arc(r, 0, -90 + 180 * i / UP) for i in range(UP + 1)]]
        return _turned(arcs, lambda p: p)
    if kind in ("Cylinder", "Cylinder_1", "Cone"):
        low, high, height, axis = {"Cylinder": lambda r, h, a: (r, r, h, a), "Cone": lambda r, h, a: (r, 0, h, a),
                                   "Cylinder_1": lambda *s: s}[kind](*sizes)
        slope = math.hypot(height, low - high) or 1
        side = (height / slope, (low - high) / slope)
        h = height / 2
        parts = [[(0, -h, (0, -1)), (low, -h, (0, -1))], [(low, -h, side), (high, h, side)], [(high, h, (0, 1)), (0, h, (0, 1))]]
        return _turned([p for p in parts if any(q[0] > 0 for q in p)], _axis(axis))
    low, high, height, axis = sizes if kind == "Capsule_1" else (sizes[0], sizes[0], sizes[1], sizes[2])
    bottom = [_on_arc(low, -height / 2, -90 + 90 * i / (UP // 2)) for i in range(UP // 2 + 1)]
    top = [_on_arc(high, height / 2, 90 * i / (UP // 2)) for i in range(UP // 2 + 1)]
    return _turned([bottom + top], _axis(axis))


def _on_arc(radius, centre, degrees):
    c, s = math.cos(math.radians(degrees)), math.sin(math.radians(degrees))
    c = 0.0 if abs(degrees) == 90 else c
    return (radius * c, centre + radius * s, (c, s))


def _turned(arcs, turn):
    """Profiles turned about the z axis; points on the axis, and those that two profiles share, are one, so the mesh is closed."""
    points, faces, normals, known = [], [], [], {}
    circle = [(math.cos(2 * math.pi * i / AROUND), math.sin(2 * math.pi * i / AROUND)) for i in range(AROUND)]

    def ring(place):
        key = (place[0], place[1])
        if key not in known:
            r, z = key
            known[key] = [len(points) + (i if r > 0 else 0) for i in range(AROUND)]
            points.extend(turn((r * c, r * s, z)) for c, s in (circle if r > 0 else circle[:1]))
        return known[key]

    for arc in arcs:
        for a, b in zip(arc, arc[1:]):
            low, high = ring(a), ring(b)
            for i in range(AROUND):
                j = (i + 1) % AROUND
                corners = [(low[i], a, i), (low[j], a, j), (high[j], b, j), (high[i], b, i)]
                if a[0] <= 0:
                    corners = corners[1:]
                elif b[0] <= 0:
                    corners = corners[:3]
                faces.append([c[0] for c in corners])
                for _, (_, _, (out, up)), k in corners:
                    normals.append(turn((out * circle[k][0], out * circle[k][1], up)))
    return _fields(points, faces, normals, "faceVarying")


def tet_fields(prim, time, notes):
    mesh = UsdGeom.TetMesh(prim)
    points, tets = floats3(mesh.GetPointsAttr().Get(time)), mesh.GetTetVertexIndicesAttr().Get(time)
    faces = mesh.GetSurfaceFaceVertexIndicesAttr().Get(time) or (UsdGeom.TetMesh.ComputeSurfaceFaces(mesh, time) if tets else None)
    if not points or not faces:
        notes.tell("meshes without points or faces are not drawn", prim.GetPath())
        return None
    fields = {"scheme": token("none"), "faceVertexCounts": array("int", [3] * len(faces)),
              "faceVertexIndices": array("int", [i for f in faces for i in f]), "primvars:points": V("float3[]", points)}
    add_sides(mesh, fields, time)
    return fields


class Skeletons:
    """Skinned and blended points."""

    def __init__(self):
        self.cache = UsdSkel.Cache()

    def populate(self, root):
        self.cache.Populate(UsdSkel.Root(root), Usd.TraverseInstanceProxies())

    def deform(self, prim, fields, time, shutter, notes):
        """Changes the points; returns the prim whose space they are in, or None: nothing moves it."""
        query = self.cache.GetSkinningQuery(prim)
        if not query or not (query.HasJointInfluences() or query.HasBlendShapes()):
            return None
        skeleton = UsdSkel.BindingAPI(prim).GetInheritedSkeleton()
        skel = self.cache.GetSkelQuery(skeleton) if skeleton else None
        if not skel:
            return None
        rest = fields["primvars:points"].data
        points, is_skinned = self._points(prim, query, skel, rest, time)
        fields["primvars:points"] = V("float3[]", points)
        for name in [n for n in fields if n.startswith("primvars:normals")]:
            del fields[name]  # those of the rest pose
        animation = skel.GetAnimQuery()
        if shutter and animation:
            now, within = time.GetValue(), Gf.Interval(time.GetValue() + shutter[0], time.GetValue() + shutter[-1])
            samples = {*(animation.GetJointTransformTimeSamplesInInterval(within) or ()), *(animation.GetBlendShapeWeightTimeSamplesInInterval(within) or ())}
            times = sorted({*shutter, *(t - now for t in samples)})[:16]
            moved = [self._points(prim, query, skel, rest, Usd.TimeCode(now + t))[0] for t in times]
            if any(m != moved[0] for m in moved):
                fields["primvars:points:samples"] = V("samples", Samples(times, [V("float3[]", m) for m in moved]))
        return skeleton.GetPrim() if is_skinned else None

    def _points(self, prim, query, skel, rest, time):
        """(the points at a time, whether joints move them)."""
        points = Vt.Vec3fArray(rest)
        if query.HasBlendShapes():
            points = self._blend(prim, query, skel, points, time)
        turns = skel.ComputeSkinningTransforms(time) if query.HasJointInfluences() else None
        if not turns:
            return points, False
        if query.GetJointMapper():
            turns = self._mapped(query.GetJointMapper(), turns)
        if query.IsRigidlyDeformed():
            turn = query.ComputeSkinnedTransform(turns, time)
            return Vt.Vec3fArray([Gf.Vec3f(turn.Transform(p)) for p in points]) if turn else points, True
        return points, bool(query.ComputeSkinnedPoints(turns, points, time))

    @staticmethod
    def _mapped(mapper, turns):
        mapped = Vt.Matrix4dArray()
        made = mapper.RemapTransforms(turns, mapped) if not mapper.IsIdentity() else turns
        return made if isinstance(made, Vt.Matrix4dArray) else mapped

    def _blend(self, prim, query, skel, points, time):
        animation = skel.GetAnimQuery()
        weights = animation.ComputeBlendShapeWeights(time) if animation else None
        if not weights:
            return points
        names, values = list(animation.GetBlendShapeOrder()), list(weights)
        by_name = dict(zip(names, values))
        own = Vt.FloatArray([by_name.get(n, 0.0) for n in query.GetBlendShapeOrder()])
        shapes = UsdSkel.BlendShapeQuery(UsdSkel.BindingAPI(prim))
        sub = shapes.ComputeSubShapeWeights(own)
        if not sub:
            return points
        weights, blend, parts = sub
        shapes.ComputeDeformedPoints(weights, blend, parts, shapes.ComputeBlendShapePointIndices(), shapes.ComputeSubShapePointOffsets(), points)
        return points
