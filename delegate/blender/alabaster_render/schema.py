"""Parameters as Alabaster's schemas have them: name, type, default, range, sentence."""
import json
import pathlib

HERE = pathlib.Path(__file__).resolve().parent
# A zip has the schemas beside this file; in the source tree they are at its top.
FOLDERS = [HERE / "schemas", HERE.parents[2] / "schemas"]


class Parameter:
    """kind: float, int, bool, color, enum."""

    def __init__(self, name, entry):
        value = entry["anyOf"][0] if "anyOf" in entry else entry
        self.name = name
        self.default = entry["default"]
        self.description = entry["description"]
        self.unit = entry.get("unit", "none")
        self.choices = value.get("enum", [])
        kinds = {"number": "float", "integer": "int", "boolean": "bool", "array": "color", "string": "enum"}
        self.kind = kinds[value["type"]]
        ranged = value["items"] if self.kind == "color" else value
        self.minimum, self.maximum = ranged.get("minimum"), ranged.get("maximum")


def document(name):
    """A file of schemas, such as "quality_presets"."""
    for folder in FOLDERS:
        file = folder / f"{name}.json"
        if file.is_file():
            return json.loads(file.read_text())
    raise FileNotFoundError(f"{name}.json is missing from {FOLDERS[0]}")


def parameters(name):
    """Those of a schema, such as "disney_material", by name."""
    return {name: Parameter(name, entry) for name, entry in document(name)["properties"].items()}
