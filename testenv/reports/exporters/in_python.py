"""Inputs of kinds.py by Python libraries: python in_python.py FOLDER, with trimesh, pygltflib, OpenEXR, tifffile and Pillow installed."""
import pathlib
import sys

import numpy as np
import OpenEXR
import PIL.Image
import pygltflib
import tifffile
import trimesh

folder = pathlib.Path(sys.argv[1])


def balls():
    ball = trimesh.creation.icosphere(subdivisions=3)
    inverted = ball.copy()
    inverted.invert()
    paint = trimesh.visual.TextureVisuals(material=trimesh.visual.material.PBRMaterial(name="m", baseColorFactor=[204, 204, 204, 255]))

    def dressed(mesh):
        mesh.visual = paint.copy()
        return mesh
    both = trimesh.Trimesh(np.vstack([ball.vertices, inverted.vertices]), np.vstack([ball.faces, inverted.faces + len(ball.vertices)]), process=False)
    dressed(both).export(folder / "08_trimesh_doubled.glb")
    trimesh.Trimesh(np.vstack([ball.vertices, [(500, 0, 0)]]), ball.faces, process=False).export(folder / "14_trimesh_loose.glb")
    dressed(ball)
    for name in ("08_trimesh_single.glb", "14_trimesh_clean.glb", "15_trimesh_clean.glb"):
        ball.export(folder / name)
    ring = [i for i, v in enumerate(ball.vertices) if abs(v[2]) < 1e-6]
    ring.sort(key=lambda i: np.arctan2(ball.vertices[i][1], ball.vertices[i][0]))
    fan = [(ring[0], ring[i], ring[i + 1]) for i in range(1, len(ring) - 1)]
    dressed(trimesh.Trimesh(ball.vertices, np.vstack([ball.faces, fan]), process=False)).export(folder / "15_trimesh_internal.glb")


def shared_accessors():
    """The way of many scripts: all primitives of a mesh use the accessors of the whole mesh."""
    ball = trimesh.creation.icosphere(subdivisions=5)
    points, faces = ball.vertices.astype("f4"), ball.faces.astype("u4")
    for name, count in (("02_pygltflib_one.glb", 1), ("02_pygltflib_shared.glb", 500)):
        parts = np.array_split(faces, count)
        data = points.tobytes() + faces.tobytes()
        gltf = pygltflib.GLTF2(scene=0, scenes=[pygltflib.Scene(nodes=[0])], nodes=[pygltflib.Node(mesh=0)],
                               buffers=[pygltflib.Buffer(byteLength=len(data))],
                               bufferViews=[pygltflib.BufferView(buffer=0, byteOffset=0, byteLength=points.nbytes, target=34962),
                                            pygltflib.BufferView(buffer=0, byteOffset=points.nbytes, byteLength=faces.nbytes, target=34963)])
        gltf.accessors.append(pygltflib.Accessor(bufferView=0, componentType=5126, count=len(points), type="VEC3", min=points.min(0).tolist(),
                                                 max=points.max(0).tolist()))
        mesh, at = pygltflib.Mesh(), 0
        for part in parts:
            gltf.accessors.append(pygltflib.Accessor(bufferView=1, byteOffset=at * 4, componentType=5125, count=part.size, type="SCALAR"))
            mesh.primitives.append(pygltflib.Primitive(attributes=pygltflib.Attributes(POSITION=0), indices=len(gltf.accessors) - 1, material=0))
            at += part.size
        gltf.materials.append(pygltflib.Material(doubleSided=False))
        gltf.meshes.append(mesh)
        gltf.set_binary_blob(data)
        gltf.save(folder / name)


def exr(name, r, g, b, data=None, display=None):
    header = {"compression": OpenEXR.ZIP_COMPRESSION, "type": OpenEXR.scanlineimage}
    if data:
        header["dataWindow"], header["displayWindow"] = data, display
    OpenEXR.File(header, {"R": r, "G": g, "B": b}).write(str(folder / name))


def ranges():
    def sky(sun):
        image = np.full((16, 32), .1, "f4")
        image[4, 8] = sun
        return image
    for name, sun in (("5e5", 5e5), ("5e6", 5e6), ("inf", np.inf), ("65504", 65504)):
        exr(f"05_openexr_{name}.exr", sky(sun), sky(sun), sky(sun))
        tifffile.imwrite(folder / f"05_tifffile_{name}.tif", np.stack([sky(sun)] * 3, axis=-1), photometric="rgb")


def heights():
    y, x = np.mgrid[0:128, 0:128] / 127
    hill = (np.exp(-((x - .5) ** 2 + (y - .5) ** 2) / .05)).astype("f4")
    tifffile.imwrite(folder / "06_tifffile_hill.tif", hill)
    tifffile.imwrite(folder / "06_tifffile_hill_plus_100.tif", hill + np.float32(100))
    levels = np.round(hill * 65535).astype("u2")
    PIL.Image.fromarray(levels).save(folder / "06_pillow_hill.png")
    tifffile.imwrite(folder / "06_pillow_same.tif", levels.astype("f4") / 65535)


def windows():
    y, x = np.mgrid[0:32, 0:64]
    full = [np.where((y // 4 + x // 4) % 2 == 0, v, v / 4).astype("f4") for v in (1, .5, .25)]
    for plane in full:
        plane[:, :8] = plane[:, 56:] = plane[:8] = plane[24:] = 0
    exr("07_openexr_whole.exr", *full)
    crop = [np.ascontiguousarray(p[8:24, 8:56]) for p in full]
    exr("07_openexr_cropped.exr", *crop, (np.array([8, 8], "i4"), np.array([55, 23], "i4")), (np.array([0, 0], "i4"), np.array([63, 31], "i4")))


def layers():
    rgb = {n: np.full((8, 16), v, "f4") for n, v in zip("RGB", (1, .5, .25))}
    other = {n: np.full((8, 16), 7, "f4") for n in ("N.X", "N.Y", "N.Z")}
    OpenEXR.File([OpenEXR.Part({"type": OpenEXR.scanlineimage}, {"Z": np.full((8, 16), 7, "f4")}, "depth"),
                  OpenEXR.Part({"type": OpenEXR.scanlineimage}, rgb, "beauty")]).write(str(folder / "12_openexr_parts.exr"))
    OpenEXR.File({"type": OpenEXR.scanlineimage}, other).write(str(folder / "12_openexr_only_normals.exr"))


def orientations():
    up = np.zeros((8, 16, 3), "u1")
    up[:4] = 255, 188, 137  # the upper half
    turned = PIL.Image.fromarray(up[::-1, ::-1])
    exif = turned.getexif()
    exif[0x112] = 3
    turned.save(folder / "16_pillow.tif", tiffinfo={0x112: 3})
    turned.save(folder / "16_pillow.jpg", exif=exif, quality=100)


for make in (balls, shared_accessors, ranges, heights, windows, layers, orientations):
    make()
