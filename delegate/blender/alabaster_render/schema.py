"""Parameters as Alabaster's schemas have them: name, type, default, range, sentence."""
import json
import pathlib

HERE = pathlib.Path(__file__).parent
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

    @property
    def label(self):
        """scatterDistance as Scatter Distance"""
        spaced = "".join(" " + c if c.isupper() else c for c in self.name)
        return spaced[:1].upper() + spaced[1:]


def parameters(schema):
    """Those of a schema, such as "disney_material", by name."""
    for folder in FOLDERS:
        file = folder / f"{schema}.json"
        if file.is_file():
            properties = json.loads(file.read_text())["properties"]
            return {name: Parameter(name, entry) for name, entry in properties.items()}
    raise FileNotFoundError(f"{schema}.json is missing from {FOLDERS[0]}")
