#!/usr/bin/env python3
"""Compares layers of media given by their coefficients with the transport equation. Needs our Python module in PYTHONPATH.

A pixel of a camera that looks straight at a wall, under a sky of 1, is by reciprocity what the layers reflect of a beam that comes from
there. Each is within 3 standard errors of theory; that of the picture is at most .0005.
"""
import pathlib
import sys
from typing import NamedTuple

import hdalabaster
import numpy as np

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "matrix"))
from measure import Series, picture, renderer_of  # noqa: E402
from scenes import box  # noqa: E402

ERROR, DEEP = 0.0005, 25.0  # mm; of a half-space


class Row(NamedTuple):
    what: str
    layers: tuple  # thickness, absorption and scattering per mm, from the top down; isotropic
    ior: float
    reflectance: float
    error: float = 5e-5
    half: float = DEEP  # mm of the layers' half width


ROWS = (
    # 1 - sqrt(1 - a) H(1): Chandrasekhar 1960.
    Row("half-space, albedo .5", ((DEEP, 5, 5),), 1.0, 0.11523),
    Row("half-space, albedo .9", ((DEEP, 1, 9),), 1.0, 0.41495),
    Row("half-space, albedo .99", ((DEEP, 0.1, 9.9),), 1.0, 0.75272),
    Row("10,000 mean free paths wide", ((1000, 1, 9),), 1.0, 0.41495, half=1000.0),
    # Giovanelli 1955, with the mirror's .04.
    Row("half-space of index 1.5", ((DEEP, 1, 9),), 1.5, 0.2600),
    # Adding-doubling (iadpython) and a photon Monte Carlo, which agree.
    Row("skin", ((0.1, 1, 10), (DEEP, 0.05, 10)), 1.0, 0.6028, 3e-4),
    Row("skin of index 1.4", ((0.1, 1, 10), (DEEP, 0.05, 10)), 1.4, 0.4452, 3e-4),
    Row("enamel", ((1, 0.005, 0.6), (DEEP, 0.1, 4)), 1.0, 0.6655, 3e-4),
    Row("enamel of index 1.4", ((1, 0.005, 0.6), (DEEP, 0.1, 4)), 1.4, 0.5277, 3e-4),
)


def drawn(row):
    scene, top = hdalabaster.Scene(), 0.0
    for k, (thickness, absorption, scattering) in enumerate(row.layers):
        points, faces = box(row.half, top, row.half, (-row.half, top - thickness, -row.half))
        top -= thickness
        scene.set_material(f"/medium{k}", **hdalabaster.medium(absorption, scattering, 0, row.ior, unit=1e-3))
        scene.set_mesh(f"/layer{k}", np.float32(points), [np.int32(f) for f in faces], material=f"/medium{k}")
    scene.set_light("/sky", "domeLight", intensity=1.0, visibleToCamera=True)
    down = np.array([[1, 0, 0, 0], [0, 0, -1, 0], [0, 1, 0, 0], [0.1, 5, 0.07, 1]], float)
    camera = {"transform": down, "projection": "orthographic", "horizontalAperture": 1e-3, "verticalAperture": 1e-3}
    renderer = renderer_of(scene, samples=1024)

    def one(seed):
        renderer.set(seed=seed)
        return picture(renderer, camera, 4).mean()
    return one


def main():
    wrong = 0
    for row in ROWS:
        series = Series(drawn(row))
        for count in (24, 48):  # of fewer the standard error itself is too uncertain for a bound of 3
            series.extend(count)
            if series.error[0] <= ERROR:
                break
        found, error = series.mean[0], series.error[0]
        holds = error <= ERROR and abs(found - row.reflectance) <= 3 * np.hypot(error, row.error)
        wrong += not holds
        print(f"{'holds' if holds else 'WRONG'}: {row.what}: {found:.5f} ± {error:.5f} for {row.reflectance}", flush=True)
    print(f"{len(ROWS) - wrong} of {len(ROWS)} hold")
    return 1 if wrong else 0


if __name__ == "__main__":
    sys.exit(main())
