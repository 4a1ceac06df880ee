"""Refines the faces of an OBJ, with its indexed texture coordinates, by the Python module: cage_of_obj.py FILE"""
import sys

import hdalabaster as alabaster
import numpy as np

points, coordinates, faces, values = [], [], [], []
for line in open(sys.argv[1]):
    word, *rest = line.split() or [""]
    if word == "v":
        points.append([float(v) for v in rest[:3]])
    elif word == "vt":
        coordinates.append([float(v) for v in rest[:2]])
    elif word == "f":
        corners = [corner.split("/") for corner in rest]
        faces.append([int(c[0]) - 1 for c in corners])
        values.append([int(c[1]) - 1 for c in corners])
flat = lambda rows: np.array(sum(rows, []), "i4")  # noqa: E731
distinct, of = np.unique(np.array(coordinates, "f4"), axis=0, return_inverse=True)  # as modellers store them: equal values once
st = alabaster.Primvar(distinct, "faceVarying", indices=of.ravel()[flat(values)].astype("i4"), role="textureCoordinate")
scene = alabaster.Scene()
for copy in range(4):
    scene.set_mesh(f"/cage{copy}", np.array(points, "f4") + 3 * copy, flat(faces), np.array([len(f) for f in faces], "i4"), scheme="catmullClark",
                   refine_level=2, primvars={"st": st})
scene.set_light("/sky", "domeLight")
camera = np.eye(4)
camera[3, 2] = 9
scene.set_camera("/camera", camera)
picture = alabaster.Renderer(scene, samples=1).render(width=16, height=16, camera="/camera", aovs=["color"])["color"].numpy()
print("drawn", float(np.asarray(picture)[..., 3].mean()))
