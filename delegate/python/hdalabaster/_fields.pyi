# This file is written by `alabaster schema --write`, from the tables of fields and parameters.
from typing import Literal, Optional, Sequence, TypedDict

from . import _Array

class Mesh(TypedDict, total=False):
    scheme: Optional[Literal["none", "catmullClark", "loop", "bilinear"]]
    orientation: Optional[Literal["rightHanded", "leftHanded"]]
    face_vertex_counts: Optional[_Array]
    face_vertex_indices: Optional[_Array]
    hole_indices: Optional[_Array]
    invisible_faces: Optional[_Array]
    interpolate_boundary: Optional[Literal["none", "edgeOnly", "edgeAndCorner"]]
    face_varying_linear_interpolation: Optional[Literal["all", "none", "boundaries", "cornersOnly", "cornersPlus1", "cornersPlus2"]]
    crease_method: Optional[Literal["uniform", "chaikin"]]
    triangle_subdivision: Optional[Literal["catmullClark", "smooth"]]
    crease_indices: Optional[_Array]
    crease_lengths: Optional[_Array]
    crease_weights: Optional[_Array]
    corner_indices: Optional[_Array]
    corner_weights: Optional[_Array]
    refine_level: Optional[int]
    transform: Optional[_Array]
    visible: Optional[bool]
    double_sided: Optional[bool]
    cull_style: Optional[Literal["dontCare", "nothing", "back", "front", "backUnlessDoubleSided", "frontUnlessDoubleSided"]]
    material: Optional[str]
    instancer: Optional[str]
    render_tag: Optional[str]
    categories: Optional[Sequence[str]]
    visibleToCamera: Optional[bool]
    holdout: Optional[bool]
    subsurfaceSet: Optional[str]
    lightGroup: Optional[str]

class Instancer(TypedDict, total=False):
    transform: Optional[_Array]
    parent: Optional[str]

class _SharedSettings(TypedDict, total=False):
    samples: Optional[int]
    firstSample: Optional[int]
    targetError: Optional[float]
    adaptive: Optional[bool]
    timeLimit: Optional[float]
    seed: Optional[int]
    maxDepth: Optional[int]
    threads: Optional[int]
    subsurface: Optional[Literal["lambert", "walk", "reference", "diffusion"]]
    inversion: Optional[Literal["chiang2016", "exact"]]
    walkGuiding: Optional[bool]
    walkSphereSteps: Optional[bool]
    energy: Optional[Literal["burley2015", "bounded", "conserving"]]
    textureMemory: Optional[int]
    memoryLimit: Optional[int]
    textureFilter: Optional[float]
    glossyFilter: Optional[float]
    refineEdgeLength: Optional[float]
    filter: Optional[Literal["box", "triangle", "gaussian", "blackmanHarris"]]
    cryptoRanks: Optional[int]
    denoise: Optional[bool]

class RenderSettings(_SharedSettings, total=False):
    camera: Optional[str]
    width: Optional[int]
    height: Optional[int]
    pixel_aspect_ratio: Optional[float]
    window_policy: Optional[Literal["matchVertically", "matchHorizontally", "fit", "crop", "dontConform"]]
    crop: Optional[_Array]
    frame: Optional[float]
    included_purposes: Optional[Sequence[str]]

class Settings(_SharedSettings, total=False):
    frame: Optional[int]
