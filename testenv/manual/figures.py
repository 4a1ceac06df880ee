#!/usr/bin/env python3
"""Renders the figures of the manual into delegate/manual/figures: rows of cups, a value of a parameter or a material each, and the
scenes of contents.py.

  figures.py [--program PATH] [--only NAME ...] [--out FOLDER] [--samples N] [--denoise] [--check]

A cup is 36 mm high, its wall 1 mm thick at the lip and its bottom 10 mm; those of recipes are three times as large. rows.json beside
this file has the values of each row, and the materials of recipes.md. --check renders nothing; it fails if a figure is missing, is not
in a page, or is larger than 60 kB. Needs oiiotool (openimageio-tools). The pictures in the repository are made with --denoise, which
needs Open Image Denoise (testenv/quickstart.sh installs it).
"""
import argparse
import json
import pathlib
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
TOP = HERE.parents[1]
sys.path.insert(0, str(TOP / "testenv/scenes"))
import contents  # noqa: E402
from gltf_writer import Document, Mesh  # noqa: E402
from scatter_distances import material_of  # noqa: E402
from shapes import backdrop, lathe, placed  # noqa: E402

OUT = TOP / "delegate/manual/figures"
LARGEST = 60_000
MM = 0.001
# Radius and height of the cup's rings in mm, up the outside and down the inside.
CUP = [(8.6, 0), (9.8, 0.3), (10.2, 1.1), (9.6, 2.0), (6.0, 3.6), (5.8, 5.0), (10.2, 7.6), (15.4, 12), (17.8, 18), (17.6, 23.5), (16.3, 29.5),
       (14.9, 34.2), (14.3, 35.8), (13.9, 36.1), (13.5, 35.9), (13.8, 34.2), (15.0, 29.5), (16.1, 23.5), (16.0, 18), (12.2, 13.4), (6.0, 11.0),
       (2.0, 10.2)]
SIDES = 24
PITCH, MARGIN = 43, 8  # mm between cups, and beside them all
RECIPE_UNIT = 3000  # mm of a scene unit: cups of recipes are three times as large
HEIGHT = 200  # pixels of a row
TABLE = json.loads((HERE / "rows.json").read_text())


def add_cup(document, name, cup, material, label):
    """`label`: None, or the material of some faces: those between two rings and two of the SIDES, as in rows.json."""
    def is_labelled(quad):
        return bool(label) and all(low <= at < high for at, (low, high) in zip(divmod(quad, SIDES), label["between"]))
    primitives = []
    for part, look in enumerate([material, label["material"]] if label else [material]):
        faces = Mesh()
        faces.points = cup.points
        chosen = [q for q in range(len(cup.quads)) if is_labelled(q) == bool(part)]
        faces.quads, faces.uvs = [cup.quads[q] for q in chosen], [cup.uvs[q] for q in chosen]
        document.add_mesh(name, faces, document.add_material(f"{name}_{part}" if part else name, look))
        primitives += document.json["meshes"].pop()["primitives"]
    document.json["meshes"].append({"name": name, "primitives": primitives})
    return len(document.json["meshes"]) - 1


def row_files(folder, name, materials, lights):
    """A row of cups as a glTF file and a render description; the latter's name."""
    document = Document("Alabaster figures.py")
    cup = lathe([(r * MM, y * MM) for r, y in CUP], sides=SIDES)
    for index, material in enumerate(materials):
        label = material.get("label")
        material = {key: value for key, value in material.items() if key != "label"}
        mesh = add_cup(document, f"cup{index}", cup, material, label)
        document.add_node(f"cup{index}", mesh, placed(at=((index - (len(materials) - 1) / 2) * PITCH * MM, 0, 0)))
    grey = document.add_material("floor", {"baseColor": [0.32, 0.32, 0.33], "roughness": 0.6})
    document.add_node("floor", document.add_mesh("floor", backdrop(), grey), placed(size=0.6))
    document.write_glb(folder / f"{name}.glb")
    width = HEIGHT * (len(materials) * PITCH + MARGIN) // 52
    scene = {
        "models": [{"file": f"{name}.glb", "refineLevel": 3}], "lights": lights,
        "camera": {"lookAt": {"eye": [0, 0.2, 0.62], "target": [0, 0.0165, 0]}, "focalLength": 50, "verticalAperture": 3.9,
                   "horizontalAperture": 3.9 * width / HEIGHT},
        "settings": {"resolution": [width, HEIGHT]}}
    (folder / f"{name}.json").write_text(json.dumps(scene))
    return folder / f"{name}.json"


def render(options, folder, name, row):
    """`row`: materials and lights, or a scene of contents.py, which is noisier."""
    if isinstance(row, str):
        scene, samples = contents.write(folder, row), 8 * options.samples
    else:
        scene, samples = row_files(folder, name, *row), options.samples
    picture = folder / f"{name}.png"
    subprocess.run([options.program, "render", str(scene), "-o", str(picture), "--quiet", "--threads", str(options.threads), "--spp",
                    str(samples), *(["--denoise"] if options.denoise else [])], check=True)
    return str(picture)


def write_jpeg(pictures, columns, file):
    """Joins pictures of one size, row by row."""
    mosaic = ["--mosaic:pad=4", f"{columns}x{len(pictures) // columns}"] if len(pictures) > 1 else []
    subprocess.run(["oiiotool", *pictures, *mosaic, "--ch", "R,G,B", "--eraseattrib", ".*", "--nosoftwareattrib", "-d", "uint8",
                    "--compression", "jpeg:88", "-o", str(file)], check=True)


def figures():
    """Figures by name: their pictures, as render() takes them, and how many stand side by side."""
    lights = TABLE["lights"]
    made = {row["name"]: ([([{**row["base"], **value} for value in row["values"]], lights[row.get("side", "front")])], 1) for row in TABLE["rows"]}
    recipes = [material_of(medium, RECIPE_UNIT) for medium in TABLE["recipes"] if medium.get("in_figure")]
    made["recipes"] = ([(recipes, lights["front"]), (recipes, lights["back"])], 1)
    wax = material_of(next(m for m in TABLE["recipes"] if m["name"] == "Candle wax"), RECIPE_UNIT)
    labelled = [{**wax, "label": label} for label in TABLE["labels"]]
    made["labels"] = ([(labelled, lights["front"]), (labelled, lights["back"])], 1)
    cups = [([TABLE["cup_under_lights"]], lights[name]) for name in TABLE["lights_in_figure"]]
    made["lights"] = (cups, len(cups))
    made["contents"] = (list(contents.SCENES), 2)
    return made


def faults(out):
    pages = "".join(page.read_text() for page in (TOP / "delegate/manual").glob("*.md"))
    for name in figures():
        file = out / f"{name}.jpg"
        if not file.exists():
            yield f"{file} is missing: figures.py --only {name}"
        elif file.stat().st_size > LARGEST:
            yield f"{file} is larger than {LARGEST} bytes"
        if f"(figures/{name}.jpg)" not in pages:
            yield f"no page shows figures/{name}.jpg"
    for file in out.glob("*.jpg"):
        if file.stem not in figures():
            yield f"{file} is no figure of rows.json"


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("--program", default=str(TOP / "build/release/bin/alabaster"))
    parser.add_argument("--only", nargs="+")
    parser.add_argument("--out", type=pathlib.Path, default=OUT)
    parser.add_argument("--threads", type=int, default=0)
    parser.add_argument("--samples", type=int, default=16)
    parser.add_argument("--denoise", action="store_true")
    parser.add_argument("--check", action="store_true")
    options = parser.parse_args()
    if options.check:
        found = list(faults(options.out))
        print("\n".join(found) or f"{len(figures())} figures are there")
        return 1 if found else 0
    options.out.mkdir(exist_ok=True)
    for name, (pictures, columns) in figures().items():
        if not options.only or name in options.only:
            with tempfile.TemporaryDirectory() as folder:
                files = [render(options, pathlib.Path(folder), f"{name}{i}", picture) for i, picture in enumerate(pictures)]
                write_jpeg(files, columns, options.out / f"{name}.jpg")
    return 0


if __name__ == "__main__":
    sys.exit(main())
