#!/usr/bin/env python3
"""Fails when a file includes a header that its layer must not see, or a library that belongs to another room.

core: a folder includes only itself and folders before it in LAYERS. delegate may include core; core never delegate; the
delegate's installed headers never include core. Third-party libraries belong to the rooms named in OWNERS.
"""
import pathlib
import re
import sys

LAYERS = ["diagnostics", "math", "color", "parameter", "sampling", "texture", "geometry", "camera", "film", "convergence",
          "material", "subsurface", "light", "scene", "integrator", "session"]
PUBLIC = ["delegate/api", "delegate/host", "delegate/gltf", "delegate/description"]
HOSTS = ["cli", "tradeoff"]  # the program and what it is made of
OWNERS = {  # pattern of an include -> files that may have it
    r"embree3/": ["core/geometry/"],
    r"opensubdiv/": ["core/geometry/"],
    r"OpenColorIO/": ["core/color/"],
    r"OpenImageIO/": ["core/texture/", "delegate/host/product_writer"],
    r"tiny_gltf": ["delegate/gltf/"],
    r"valijson/": ["delegate/description/"],
    r"CLI/": ["delegate/cli/"],
}
INCLUDE = re.compile(r'^\s*#\s*include\s*[<"]([^>"]+)[>"]')


def faults(path, text):
    parts = path.split("/")
    public_header = path.endswith(".h") and any(path.startswith(p + "/") for p in PUBLIC)
    for number, line in enumerate(text.splitlines(), 1):
        match = INCLUDE.match(line)
        if not match:
            continue
        name = match.group(1)
        where = f"{path}:{number}: includes {name}: "
        for pattern, owners in OWNERS.items():
            if re.match(pattern, name) and not any(path.startswith(o) for o in owners):
                yield where + "belongs to " + ", ".join(owners)
        target = name.split("/")
        if line.count('"') == 2 and len(target) < 2:
            yield where + "write includes from the root of the repository"
        if parts[0] == "core" and target[0] in ("delegate", "testenv"):
            yield where + "core must not include it"
        if parts[0] == "delegate" and target[0] == "testenv":
            yield where + "the library must not include its tests"
        if public_header and target[0] == "core":
            yield where + "installed headers must not include core"
        if parts[0] == "delegate" and parts[1] in HOSTS and (target[0] == "core" or target[:2] in (["delegate", "prims"], ["delegate", "rendering"], ["delegate", "support"])):
            yield where + "the program must use only the public contract"
        if parts[0] == "delegate" and parts[1] == "tradeoff" and target[:2] == ["delegate", "cli"]:
            yield where + "the measurements must not know the program"
        if parts[0] == "core" and target[0] == "core":
            if LAYERS.index(target[1]) > LAYERS.index(parts[1]):
                yield where + f"layer {parts[1]} lies below {target[1]}"


def main():
    root = pathlib.Path(__file__).resolve().parents[2]
    found = []
    files = sorted(p for folder in ("core", "delegate") for p in (root / folder).rglob("*") if p.suffix in (".h", ".cpp"))
    for file in files:
        path = file.relative_to(root).as_posix()
        if path.startswith("core/") and path.split("/")[1] not in LAYERS:
            found.append(f"{path}: folder is not in the list of layers")
            continue
        found += faults(path, file.read_text())
    print("\n".join(found) if found else f"{len(files)} files keep to their layers")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
