"""A scene whose picture tells left from right, up from down and colours from each other. Standard library only.

Three squares face the camera: red at the upper left, green at the upper right, blue at the lower left; a gray wall is behind them.
"""
import base64
import json
import struct

# Lower left corner, width and colour.
SQUARES = {"red": ((-1, 0, 0), 1, (0.8, 0.05, 0.05)), "green": ((0, 0, 0), 1, (0.05, 0.8, 0.05)),
           "blue": ((-1, -1, 0), 1, (0.05, 0.05, 0.8)), "wall": ((-50, -50, -4), 100, (0.2, 0.2, 0.2))}


def write(folder, samples=4, wall=True):
    """Writes target.json and target.gltf; the description's path. The picture has the shape 4:3."""
    squares = {name: square for name, square in SQUARES.items() if wall or name != "wall"}
    points, accessors = [], []
    for i, ((x, y, z), width, _) in enumerate(squares.values()):
        x1, y1 = x + width, y + width
        points.append(struct.pack("<12f", x, y, z, x1, y, z, x1, y1, z, x, y1, z))
        accessors.append({"bufferView": i, "componentType": 5126, "count": 4, "type": "VEC3", "min": [x, y, z], "max": [x1, y1, z]})
    count = len(points)
    views = [{"buffer": 0, "byteOffset": 48 * i, "byteLength": 48} for i in range(count)]
    views.append({"buffer": 0, "byteOffset": 48 * count, "byteLength": 12})
    accessors.append({"bufferView": count, "componentType": 5123, "count": 6, "type": "SCALAR"})
    binary = b"".join(points) + struct.pack("<6H", 0, 1, 2, 0, 2, 3)
    document = {
        "asset": {"version": "2.0"}, "scene": 0, "scenes": [{"nodes": list(range(count))}],
        "nodes": [{"name": name, "mesh": i} for i, name in enumerate(squares)],
        "materials": [{"name": name, "pbrMetallicRoughness": {"baseColorFactor": [*color, 1], "metallicFactor": 0}}
                      for name, (_, _, color) in squares.items()],
        "meshes": [{"primitives": [{"attributes": {"POSITION": i}, "indices": count, "material": i}]} for i in range(count)],
        "accessors": accessors, "bufferViews": views,
        "buffers": [{"byteLength": len(binary), "uri": "data:application/octet-stream;base64," + base64.b64encode(binary).decode()}]}
    (folder / "target.gltf").write_text(json.dumps(document))
    scene = {"gltf": [{"file": "target.gltf"}],
             "materials": [{"match": name, "set": {"roughness": 1, "specular": 0}} for name in squares],
             "lights": [{"name": "sky", "type": "domeLight", "intensity": 1}],
             "camera": {"lookAt": {"eye": [0, 0, 5], "target": [0, 0, 0]}},
             "settings": {"resolution": [320, 240], "samples": samples}}
    file = folder / "target.json"
    file.write_text(json.dumps(scene, indent=1))
    return file
