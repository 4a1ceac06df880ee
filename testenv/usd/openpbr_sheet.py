#!/usr/bin/env python3
"""OpenPBR's public examples that scatter below their surface, as one sheet: openpbr_sheet.py PROGRAM EXAMPLES OUT.png [flags of render, in place of
--size 1200x480 --spp 256].

EXAMPLES is the folder `examples` of github.com/AcademySoftwareFoundation/OpenPBR. Their lengths are centimetres: each is on a ball of
5 cm and a leaf of 3 mm, under a lamp in front and a sun behind. In rows: skin I to V; skin VI, marble, milk, pearl, snow."""
import os
import re
import subprocess
import sys
import tempfile

NAMES = ["skin_i", "skin_ii", "skin_iii", "skin_iv", "skin_v", "skin_vi", "marble", "milk", "pearl", "snow"]
HEAD = """#usda 1.0
(
    metersPerUnit = 0.01
    upAxis = "Y"
)
def Camera "camera"
{
    token projection = "orthographic"
    float horizontalAperture = 500
    float verticalAperture = 200
    float2 clippingRange = (1, 1000)
    double3 xformOp:translate = (0, 0, 100)
    uniform token[] xformOpOrder = ["xformOp:translate"]
}
def DomeLight "sky"
{
    float inputs:intensity = 0.15
}
def RectLight "lamp"
{
    float inputs:intensity = 12
    float inputs:width = 60
    float inputs:height = 60
    double3 xformOp:translate = (-80, 80, 100)
    float3 xformOp:rotateXYZ = (-32, -39, 0)
    uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:rotateXYZ"]
}
def DistantLight "sun"
{
    float inputs:angle = 4
    float inputs:intensity = 500
    float3 xformOp:rotateXYZ = (-25, 150, 0)
    uniform token[] xformOpOrder = ["xformOp:rotateXYZ"]
}
"""
EXAMPLE = """def Xform "%(name)s" ( prepend apiSchemas = ["MaterialBindingAPI"] )
{
    rel material:binding = </%(name)s/look/Materials/%(material)s>
    double3 xformOp:translate = (%(x)g, %(y)g, 0)
    uniform token[] xformOpOrder = ["xformOp:translate"]
    def Sphere "ball"
    {
        double radius = 2.5
        double3 xformOp:translate = (-1.6, 0, 0)
        uniform token[] xformOpOrder = ["xformOp:translate"]
    }
    def Cube "leaf"
    {
        double size = 1
        double3 xformOp:translate = (2.9, 0, 0)
        float3 xformOp:rotateXYZ = (0, -25, 0)
        float3 xformOp:scale = (2.6, 5, 0.3)
        uniform token[] xformOpOrder = ["xformOp:translate", "xformOp:rotateXYZ", "xformOp:scale"]
    }
    def "look" ( references = @%(file)s@</MaterialX> )
    {
    }
}
"""


def main():
    program, examples, out = map(os.path.abspath, sys.argv[1:4])
    text = HEAD
    for i, name in enumerate(NAMES):
        file = os.path.join(examples, "open_pbr_%s.mtlx" % name)
        material = re.search(r'<surfacematerial name="(\w+)"', open(file).read()).group(1)
        text += EXAMPLE % {"name": name, "material": material, "file": file, "x": (i % 5 - 2) * 10, "y": 5 - i // 5 * 10}
    with tempfile.TemporaryDirectory() as folder:
        stage = os.path.join(folder, "sheet.usda")
        with open(stage, "w") as f:
            f.write(text)
        sys.exit(subprocess.run([program, "render", stage, "-o", out, "--allow", examples, *(sys.argv[4:] or ["--size", "1200x480", "--spp", "256"])]).returncode)


if __name__ == "__main__":
    main()
