#!/usr/bin/env python3
"""Fails when a file includes a header that its room must not see, or a library that belongs to another room.

core: a room includes only itself and rooms before it in CORE_ROOMS. delegate: a room includes only itself and the rooms
that DELEGATE_ROOMS names for it; core never delegate; installed headers neither core nor what is not installed. A header
that calls itself "Internal to this room" in its first line, or that lies among installed ones without being installed
itself, is included by its own room alone. Third-party libraries belong to the rooms named in OWNERS.
"""
import pathlib
import re
import sys

CORE_ROOMS = ["diagnostics", "memory", "digest", "files", "math", "color", "parameter", "sampling", "images", "texture", "geometry", "camera", "film",
              "denoise", "convergence", "material", "subsurface", "light", "scene", "integrator", "session"]
CONTRACT = ["api", "host", "gltf", "archive", "description"]  # rooms with installed headers
DELEGATE_ROOMS = {  # room -> the rooms of delegate that it may include besides itself
    "api": [],
    "support": ["api"],
    "looks": ["api", "support"],
    "prims": ["api", "support", "looks"],
    "rendering": ["api", "support", "prims"],
    "host": ["api", "support"],
    "gltf": ["api", "support", "looks", "host"],
    "description": ["api", "support", "looks", "host", "gltf", "archive", "usd"],
    "usd": ["api", "support", "host", "archive"],
    "archive": ["api", "support", "host"],
    "c_api": CONTRACT + ["support"],
    "python": ["c_api"],
    "hydra": CONTRACT + ["support"],
    "tradeoff": CONTRACT + ["support"],
    "cli": CONTRACT + ["support", "tradeoff"],
    "view": CONTRACT + ["support", "cli"],
    "doors": [],  # tests alone: one scene through every way in
}
CORE_SEEN_BY = {  # room of delegate -> the rooms of core that it may include
    "prims": CORE_ROOMS,
    "rendering": CORE_ROOMS,
    "support": ["color", "files", "parameter"],
    "looks": ["color", "material", "subsurface"],  # chromaticities, the table of parameters, formulas
    # of camera, light, material, scene and session the tables of parameters
    "host": ["camera", "color", "denoise", "digest", "film", "files", "images", "light", "material", "math", "scene", "session", "texture"],
    "archive": ["digest", "files", "memory", "texture"],
    "c_api": ["math", "subsurface"],
    "gltf": ["files", "images", "material", "math", "memory", "subsurface", "texture"],
    "description": ["files", "math", "memory", "texture"],
    "usd": ["files"],
    "tradeoff": ["files"],
    "cli": ["files"],
    "view": ["files"],
}
OWNERS = {  # pattern of an include -> files that may have it
    r"embree[34]/": ["core/geometry/"],
    r"opensubdiv/": ["core/geometry/"],
    r"OpenColorIO/": ["core/color/"],
    r"OpenImageIO/": ["core/images/open_image_io/"],
    r"tiny_gltf": ["delegate/gltf/"],
    r"CLI/": ["delegate/cli/", "delegate/view/program"],
    r"imgui|GLFW/": ["delegate/view/"],
    r"xxhash": ["core/digest/"],
    r"dlfcn\.h": ["core/denoise/", "core/images/", "delegate/rendering/factory", "delegate/usd/", "delegate/hydra/plugin/renderer_plugin"],
    r"pxr/": ["delegate/hydra/plugin/"],
}
INCLUDE = re.compile(r'^\s*#\s*include\s*[<"]([^>"]+)[>"]')
INTERNAL = re.compile(r"^//.*\bInternal to this room\b")


def room_of(path):
    """core/light, delegate/host, ...; of a unit test the room that it tests."""
    parts = path.removeprefix("testenv/unit/").split("/")
    return "/".join(parts[:2])


def wrong_arrow(path, target):
    """Why `path` may not include `target` of another room, or None."""
    room, other = room_of(path).split("/"), room_of(target).split("/")
    if path.startswith("testenv/") or room == other:
        return None
    if other[0] == "testenv":
        return "the library must not include its tests"
    if room[0] == "core":
        if other[0] == "delegate":
            return "core must not include it"
        below = CORE_ROOMS.index(other[1]) < CORE_ROOMS.index(room[1])
        return None if below else f"room {room[1]} lies below {other[1]}"
    seen = DELEGATE_ROOMS[room[1]] if other[0] == "delegate" else CORE_SEEN_BY.get(room[1], [])
    return None if other[1] in seen else f"room {room[1]} must not include {'/'.join(other)}"


def faults(path, text, hidden, installed):
    """The faults of one file. `hidden`: headers for their own room alone."""
    for number, line in enumerate(text.splitlines(), 1):
        match = INCLUDE.match(line)
        if not match:
            continue
        name = match.group(1)
        where = f"{path}:{number}: includes {name}: "
        for pattern, owners in OWNERS.items():
            if re.match(pattern, name) and not path.startswith("testenv/") and not any(path.startswith(o) for o in owners):
                yield where + "belongs to " + ", ".join(owners)
        if line.count('"') != 2:
            continue
        if "/" not in name and not path.startswith("delegate/c_api/alabaster"):  # headers that stand alone
            yield where + "write includes from the root of the repository"
        if name.split("/")[0] not in ("core", "delegate", "testenv"):
            continue
        if reason := wrong_arrow(path, name):
            yield where + reason
        if name in hidden and room_of(path) != room_of(name):
            yield where + "the header is internal to " + room_of(name)
        if path in installed and name not in installed:
            yield where + "an installed header must include installed headers only"


def installed_headers(cmake):
    """Those of the list ALABASTER_INSTALLED_HEADERS."""
    return set(re.search(r"set\(ALABASTER_INSTALLED_HEADERS\s([^)]*)\)", cmake).group(1).split())


def hidden_headers(texts, installed):
    return {path for path, text in texts.items() if path.endswith(".h") and (
        INTERNAL.match(text.split("\n", 1)[0])
        or path not in installed and path.split("/")[0] == "delegate" and path.split("/")[1] in CONTRACT)}


def main():
    root = pathlib.Path(__file__).resolve().parents[2]
    texts = {file.relative_to(root).as_posix(): file.read_text() for folder in ("core", "delegate", "testenv")
             for file in sorted((root / folder).rglob("*")) if file.suffix in (".h", ".cpp")}
    installed = installed_headers((root / "CMakeLists.txt").read_text())
    hidden = hidden_headers(texts, installed)
    found = [f"CMakeLists.txt: installs {path}, which does not exist" for path in sorted(installed - texts.keys())]
    found += [f"{path}: is installed and calls itself internal" for path in sorted(installed & hidden)]
    for path, text in texts.items():
        room = room_of(path).split("/")
        if room[0] == "core" and room[1] not in CORE_ROOMS or room[0] == "delegate" and room[1] not in DELEGATE_ROOMS:
            found.append(f"{path}: {'/'.join(room)} is not in the list of rooms")
            continue
        found += faults(path, text, hidden, installed)
    print("\n".join(found) if found else f"{len(texts)} files keep to their rooms")
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
