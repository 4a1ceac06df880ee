"""Short forms of Scene.set and Scene.edit, which __init__.py adds to Scene."""
from __future__ import annotations

import array
from typing import TYPE_CHECKING, Any, Mapping, Optional, Tuple, Union

from ._hdalabaster import Primvar, _shape_of

if TYPE_CHECKING:
    from typing_extensions import Unpack

    from . import _Array, _Matrix, _Motion, _Parameter
    from ._fields import Instancer, Mesh, RenderSettings


def _entries(values: Any, name: str) -> list[Tuple[str, Any]]:
    if values is None:
        return []
    if not isinstance(values, dict):
        raise TypeError(f"{name} must be a dict, not {type(values).__name__}")
    entries = list(values.items())
    for key, _ in entries:
        if not isinstance(key, str):
            raise TypeError(f"a key of {name} must be a str, not {type(key).__name__}")
    return entries


def _primvar(values: Any, interpolation: str = "vertex", role: str = "") -> Any:
    return values if values is None or isinstance(values, Primvar) else Primvar(values, interpolation, role=role)


def _faces(indices: Any, counts: Any) -> Tuple[Any, Any]:
    """The corners of faces and the sizes of these: rows of several lengths one after the other, and without counts those of the rows,
    or three numbers each. Read-only memory is not copied."""
    shape = _shape_of(indices, "indices")
    if len(shape) < 2:
        sizes = [3] * (shape[0] // 3) if shape else []
    elif len(shape) > 2 and 0 not in shape:
        raise ValueError("indices must have the shape (n) or (n, corners), or rows of several lengths")
    else:
        sizes = [shape[1]] * shape[0]
        if isinstance(indices, (list, tuple)):
            rows = [_shape_of(row, "indices") for row in indices]
            for number, row in enumerate(rows):
                if len(row) != 1:
                    raise ValueError(f"indices: element {number} is not a row of numbers, and the first is")
            sizes = [row[0] for row in rows]
            if len(set(sizes)) > 1:
                indices = [corner for row in indices for corner in row]
        if counts is not None and _shape_of(counts, "counts") != [len(sizes)]:
            raise ValueError(f"indices has {len(sizes)} rows, and counts has the shape {tuple(_shape_of(counts, 'counts'))}")
        for number, size in enumerate(sizes if counts is not None else []):
            if counts[number] != size:
                raise ValueError(f"indices: row {number} has {size} corners, and counts says {counts[number]}")
    if counts is None:
        counts = memoryview(array.array("i", sizes if any(sizes) else []).tobytes()).cast("i")
    return indices, counts


class SceneMethods:
    if TYPE_CHECKING:
        set: Any
        edit: Any

    def set_mesh(self, path: str, points: Union[_Array, Primvar], indices: _Array, counts: Optional[_Array] = None, *,
                 primvars: Optional[Mapping[str, Union[bool, str, _Array, Primvar]]] = None,
                 subsets: Optional[Mapping[str, _Array]] = None, subdiv_tags: Optional[Mapping[str, Union[str, _Array]]] = None,
                 left_handed: bool = False, holes: Optional[_Array] = None, motion: _Motion = None, **fields: Unpack[Mesh]) -> None:
        """points: (n, 3), or a Primvar. indices: the corners of all faces, one after the other, with the size of each face in counts;
        without counts a row is a face, of any length, or three numbers are. primvars={'st': array or Primvar}, subsets={material: faces},
        subdiv_tags={'crease_indices': ..., ...}, motion=[(time, transform), ...], and fields of a mesh."""
        indices, counts = _faces(indices, counts)
        given = {"points": _primvar(points, role="point"), "counts": counts, "indices": indices, "holes": holes, "motion": motion, **fields}
        given.update(("primvars:" + name, _primvar(values)) for name, values in _entries(primvars, "primvars"))
        given.update(_entries(subdiv_tags, "subdiv_tags"))
        for number, (material, faces) in enumerate(_entries(subsets, "subsets")):
            given[f"subsets:{path}/{number}:faces"] = faces
            given[f"subsets:{path}/{number}:material"] = material
        if not isinstance(left_handed, bool):
            raise TypeError(f"left_handed must be a bool, not {type(left_handed).__name__}")
        if left_handed:
            given["orientation"] = "leftHanded"
        self.set(path, "mesh", given)

    def set_primvar(self, mesh: str, name: str, values: Union[None, bool, str, _Array, Primvar], interpolation: str = "vertex") -> None:
        """Replaces one primvar, points among them. None removes it."""
        self.edit(mesh, {"primvars:" + name: _primvar(values, interpolation)})

    def set_transform(self, path: str, transform: _Matrix) -> None:
        """Moves a mesh, light, camera or instancer."""
        self.edit(path, {"transform": transform})

    def set_visible(self, path: str, visible: bool) -> None:
        """Shows or hides a mesh or light."""
        self.edit(path, {"visible": visible})

    def bind_material(self, mesh: str, material: str) -> None:
        """Gives a mesh a material."""
        self.edit(mesh, {"material": material})

    def set_instancer(self, path: str, prototypes: Mapping[str, _Array], *, transforms: Union[None, _Array, Primvar] = None,
                      translations: Union[None, _Array, Primvar] = None, rotations: Union[None, _Array, Primvar] = None,
                      scales: Union[None, _Array, Primvar] = None, motion: _Motion = None, **fields: Unpack[Instancer]) -> None:
        """prototypes={mesh: indices of its instances}. transforms (n, 4, 4), translations (n, 3), rotations (n, 4; the real part
        first), scales (n, 3), motion=[(time, transform), ...], and fields of an instancer. The meshes name the instancer, too.
        Values by instance are fields, which edit sets: edit('/many', {'primvars:tint': colors}). Materials read them by a node
        AlabasterPrimvar."""
        given = {"transforms": transforms, "translations": translations, "rotations": rotations, "scales": scales, "motion": motion, **fields}
        given.update(("prototypes:" + name, indices) for name, indices in _entries(prototypes, "prototypes"))
        self.set(path, "instancer", given)

    def set_material(self, path: str, nodes: Optional[Mapping[str, Mapping[str, Any]]] = None, displacement: str = "",
                     **parameters: Union[_Parameter, Tuple[str, str]]) -> None:
        """Parameters of schemas/disney_material.json: set_material('/wax', baseColor=(.9, .6, .3)). Or nodes={'surface':
        {'baseColor': ('image', 'rgb')}, 'image': {'type': 'AlabasterTexture', 'file': 'a.png'}}: a pair of texts connects an input
        with a node's output, a list of pairs with the product of several."""
        if nodes is not None and parameters:
            raise TypeError("a material has nodes, or parameters: put these into a node")
        given = {"displacement": displacement}
        for node, inputs in _entries({"surface": parameters} if nodes is None else nodes, "nodes"):
            if "." in node:
                raise ValueError(f"node '{node}': names of nodes have no dot")
            given[node + ".type"] = "AlabasterDisney"
            given.update((f"{node}.{name}", value) for name, value in _entries(inputs, f"node '{node}'"))
        self.set(path, "material", given)

    def set_light(self, path: str, type: str, transform: _Matrix = None, visible: bool = True, *, motion: _Motion = None,
                  **parameters: _Parameter) -> None:
        """type: rectLight, diskLight, cylinderLight, sphereLight, distantLight or domeLight. motion=[(time, transform), ...], and
        parameters of schemas/lights.json: intensity=2, color=(1, .9, .8)."""
        self.set(path, type, {"transform": transform, "visible": visible, "motion": motion, **parameters})

    def set_camera(self, path: str, transform: _Matrix = None, *, motion: _Motion = None, **parameters: _Parameter) -> None:
        """Looks along -z of its transform. motion=[(time, transform), ...], and parameters of schemas/camera.json."""
        self.set(path, "camera", {"transform": transform, "motion": motion, **parameters})

    def set_render_settings(self, path: str, *, pixel_aspect: Optional[float] = None, **fields: Unpack[RenderSettings]) -> None:
        """Fields of render settings, and settings by name. 0 as width, height or pixel_aspect is the default."""
        given = {"pixel_aspect": pixel_aspect, **fields}
        for name in ("width", "height", "pixel_aspect"):
            if isinstance(given.get(name), (int, float)) and given[name] == 0:
                given[name] = None
        self.set(path, "renderSettings", given)

    def set_parameter(self, path: str, name: str, value: _Parameter) -> None:
        """Changes one parameter of a light, a camera or render settings, or 'node.parameter' of a material ('surface.roughness')."""
        self.edit(path, {name: value})
