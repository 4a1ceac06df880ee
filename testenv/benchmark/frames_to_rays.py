"""Counts the frames from trace_path to a shadow ray at a surface, to one at a walk's exit, and to a walk's first segment, both
ends included. Inlined functions count. For gdb, with a program that was built with -g (cmake -DCMAKE_CXX_FLAGS=-g):

  gdb -batch -x frames_to_rays.py --args PROGRAM render testenv/scenes/skin_closeup/skin_closeup.json --size 48x32 --spp 1 -o frames.exr
"""
import re

import gdb

WANTED = ["shadow ray at a surface", "shadow ray at an exit", "first segment of a walk"]
found = {}
at = {}  # by thread: "surface" or "exit" while it samples lights, "walk" until the walk's first segment


def thread():
    return gdb.selected_thread().num


def frames():
    """Names from trace_path to the newest frame; empty: no path is traced."""
    names, frame = [], gdb.newest_frame()
    while frame:
        names.append(re.sub(r"[<(].*", "", (frame.name() or "?").replace("(anonymous namespace)::", "")).split("::")[-1])
        if names[-1] == "trace_path":
            return names[::-1]
        frame = frame.older()
    return []


def note(what):
    names = frames()
    if names and what not in found:
        found[what] = names


class Enter(gdb.Breakpoint):
    """Where a kind of vertex or a walk begins."""

    def __init__(self, function, kind):
        super().__init__(function, internal=True)
        self.kind = kind

    def stop(self):
        at[thread()] = self.kind() if callable(self.kind) else self.kind
        return False


class Ray(gdb.Breakpoint):
    """Where a ray is traced."""

    def __init__(self, function, wanted):
        super().__init__(function, internal=True)
        self.wanted = wanted

    def stop(self):
        what = self.wanted.get(at.get(thread()))
        if what:
            note(what)
            at[thread()] = None
        return len(found) == len(WANTED)


def kind_of_vertex():
    return str(gdb.parse_and_eval("vertex->kind")).split("::")[-1]


gdb.execute("set breakpoint pending on")
gdb.execute("set pagination off")
Enter("alabaster::sample_lights", kind_of_vertex)
Enter("alabaster::find_exit", "walk")
Ray("EmbreeInstancedScene::occluded", {"surface": WANTED[0], "exit": WANTED[1]})
Ray("alabaster::EmbreeObjectScene::intersect", {"walk": WANTED[2]})
gdb.execute("run", to_string=True)
for what in WANTED:
    names = found.get(what)
    print(f"{what}: {len(names)} frames: {', '.join(names)}" if names else f"{what}: none was traced")
gdb.execute("kill")
