#!/usr/bin/env python3
"""hdalabaster.load_stage reads an open stage as Scene.load reads its file: load_stage_test.py [FOLDER with pxr]. 77: there is no OpenUSD."""
import os
import sys
import tempfile
import warnings

sys.path[:0] = sys.argv[1:]
try:
    from pxr import Usd
except ImportError as e:
    print("skipped: OpenUSD for Python is not installed (alabaster usd install): %s" % e)
    sys.exit(77)
import hdalabaster

STAGE = """#usda 1.0
def Xform "World"
{
    def Camera "cam" { float focalLength = 20; }
    class Xform "_part"
    {
        def Cube "c" { double size = 0.5; }
    }
    def "a" (instanceable = true
        inherits = </World/_part>) { }
    def "b" (instanceable = true
        inherits = </World/_part>) { }
    def SphereLight "lamp" { float inputs:intensity = 3; }
    def Volume "fog" { }
}
"""


def main():
    with tempfile.TemporaryDirectory() as folder:
        file = os.path.join(folder, "stage.usda")
        with open(file, "w") as f:
            f.write(STAGE)
        loaded = hdalabaster.Scene(report=lambda *told: None)
        loaded.load(file)
        with warnings.catch_warnings(record=True) as told:
            warnings.simplefilter("always")
            opened = hdalabaster.load_stage(Usd.Stage.Open(file), hdalabaster.Scene(report=lambda *told: None))
    assert opened.prims == loaded.prims and "instancer" in opened.prims.values(), (opened.prims, loaded.prims)
    assert [str(w.message) for w in told] == ["/World/fog: volumes are not drawn (1 times)"], [str(w.message) for w in told]
    print("right: %d prims" % len(opened.prims))


if __name__ == "__main__":
    main()
