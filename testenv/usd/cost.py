#!/usr/bin/env python3
"""What it costs from the command to the first ray of a stage: cost.py PROGRAM [NAME...]. On an idle machine.

CPU seconds and peak memory of the program and of its reader together, of a picture of 16x16 pixels with one sample, beside what
issue 14 asks. The stages are made here, by the OpenUSD that the program uses ($ALABASTER_USD or build/usd)."""
import os
import resource
import subprocess
import sys
import tempfile

HERE = os.path.dirname(os.path.abspath(__file__))
SITE = os.environ.get("ALABASTER_USD") or os.path.join(HERE, "../../build/usd")
sys.path.insert(0, SITE)
from pxr import Gf, Sdf, Usd, UsdGeom, Vt

CAMERA = (0, 0, 400)


def new(file):
    stage = Usd.Stage.CreateNew(file)
    stage.SetDefaultPrim(UsdGeom.Xform.Define(stage, "/World").GetPrim())
    UsdGeom.Camera.Define(stage, "/World/cam").AddTranslateOp().Set(CAMERA)
    stage.DefinePrim("/World/sky", "DomeLight")
    return stage


def quads(stage, where, side, place=(0, 0, 0)):
    """A grid of side x side quads."""
    mesh = UsdGeom.Mesh.Define(stage, where)
    n = side + 1
    mesh.CreatePointsAttr(Vt.Vec3fArray([Gf.Vec3f(x, y, 0) for y in range(n) for x in range(n)]))
    mesh.CreateFaceVertexCountsAttr(Vt.IntArray(side * side, 4))
    mesh.CreateFaceVertexIndicesAttr(Vt.IntArray([i for y in range(side) for x in range(side) for i in (y * n + x, y * n + x + 1, (y + 1) * n + x + 1, (y + 1) * n + x)]))
    mesh.CreateSubdivisionSchemeAttr("none")
    if place != (0, 0, 0):
        mesh.AddTranslateOp().Set(place)
    return mesh


def spread(i):
    return (i % 100 * 3 - 150, i // 100 % 100 * 3 - 150, 0)


def ten(file):
    stage = new(file)
    for i in range(10):
        quads(stage, "/World/m%d" % i, 4, spread(i))
    stage.Save()


def meshes(file, count=10_000, mover=False):
    stage = new(file)
    with Sdf.ChangeBlock():
        pass
    for i in range(count):
        quads(stage, "/World/g%d/m%d" % (i // 100, i), 2, spread(i))
    if mover:
        stage.SetStartTimeCode(0), stage.SetEndTimeCode(47)
        moved = UsdGeom.Xformable(stage.GetPrimAtPath("/World/g0/m0")).GetOrderedXformOps()[0]
        for t in range(48):
            moved.Set((t, 0, 0), t)
    stage.Save()


def layers(file, parts=229, count=1788):
    folder = file[:-5]
    os.makedirs(folder, exist_ok=True)
    stage = new(file)
    for part in range(parts):
        name = os.path.join(folder, "part%d.usdc" % part)
        own = Usd.Stage.CreateNew(name)
        own.SetDefaultPrim(UsdGeom.Xform.Define(own, "/Part").GetPrim())
        for i in range(part, count, parts):
            quads(own, "/Part/m%d" % i, 8, spread(i))
        own.Save()
        stage.DefinePrim("/World/p%d" % part).GetReferences().AddReference("./%s/part%d.usdc" % (os.path.basename(folder), part))
    stage.Save()


def points(file, count=1_000_000):
    stage = new(file)
    many = UsdGeom.PointInstancer.Define(stage, "/World/many")
    quads(stage, "/World/many/a", 1)
    many.CreatePrototypesRel().SetTargets(["/World/many/a"])
    many.CreateProtoIndicesAttr(Vt.IntArray(count, 0))
    many.CreatePositionsAttr(Vt.Vec3fArray([Gf.Vec3f(i % 1000 - 500, i // 1000 - 500, 0) for i in range(count)]))
    many.CreateOrientationsAttr(Vt.QuathArray(count, Gf.Quath(1, 0, 0, 0)))
    many.CreateScalesAttr(Vt.Vec3fArray(count, Gf.Vec3f(.5)))
    stage.Save()


def large(file):
    stage = new(file)
    quads(stage, "/World/m", 2000)
    stage.Save()


# (name, what makes it, more of the command, CPU seconds wanted, MB wanted)
ROWS = [("ten prims", ten, [], 1.5, None), ("10,000 meshes", meshes, [], 4, None), ("1,788 meshes in 230 layers", layers, [], 3, None),
        ("1e6 point instances", points, [], 3, 300), ("4M quads", large, [], None, None),
        ("2,937 layers", lambda file: layers(file, 2936, 2936), [], 3, None)]


def run(command):
    before = resource.getrusage(resource.RUSAGE_CHILDREN)
    subprocess.run(command, check=True, stdout=subprocess.DEVNULL)
    after = resource.getrusage(resource.RUSAGE_CHILDREN)
    return after.ru_utime + after.ru_stime - before.ru_utime - before.ru_stime


def peak(command):
    """MB of the larger of the program and its reader."""
    code = "import resource, subprocess, sys; subprocess.run(sys.argv[1:], check=True, stdout=subprocess.DEVNULL); print(resource.getrusage(resource.RUSAGE_CHILDREN).ru_maxrss)"
    return int(subprocess.run([sys.executable, "-c", code, *command], check=True, capture_output=True, text=True).stdout) / 1024


def main():
    program, chosen = os.path.abspath(sys.argv[1]), sys.argv[2:]
    with tempfile.TemporaryDirectory() as folder:
        command = lambda file, *more: [program, "render", file, "-o", os.path.join(folder, "x.####.exr" if more else "x.exr"), "--size", "16x16", "--spp", "1", "--quiet", *more]
        print("| stage | CPU s | wanted | ratio | peak MB | wanted |\n| --- | --- | --- | --- | --- | --- |")
        for number, (name, make, more, seconds, megabytes) in enumerate(ROWS):
            if chosen and name not in chosen:
                continue
            file = os.path.join(folder, "stage%d.usdc" % number)
            make(file)
            used, most = run(command(file)), peak(command(file))
            print("| %s | %.2f | %s | %s | %.0f | %s |" % (name, used, seconds or "-", "%.2f" % (used / seconds) if seconds else "-", most, megabytes or "-"), flush=True)
        if not chosen or "48 frames" in chosen:
            file = os.path.join(folder, "moves.usdc")
            meshes(file, mover=True)
            one, all = run(command(file, "--frames", "0:0")), run(command(file, "--frames", "0:47"))
            each = (all - one) / 47
            print("| 48 frames, one of 10,000 meshes moves: first, each further | %.2f, %.3f | %.3f | %.2f | - | - |" % (one, each, one / 10, each / (one / 10)))


if __name__ == "__main__":
    main()
