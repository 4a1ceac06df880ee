#!/usr/bin/env python3
"""Counts what the models of setting `energy` cost: the instructions of one camera sample (valgrind's callgrind).

  energy_cost.py PROGRAM [--scene NAME ...] [--size WxH] > testenv/benchmark/results/energy_cost.md

testenv/statistical/results/energy.md has how far they depart from the published model. Paths that keep more light are longer, which
counts, too.
"""
import argparse
import pathlib
import tempfile

from compare_programs import add_size, require
from feature_cost import per_sample

SCENES = ["skin_closeup", "thick_thin", "mixed_no_subsurface"]
MODELS = ["burley2015", "bounded", "conserving"]


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("--scene", action="append", choices=SCENES, help="only this scene; may be repeated")
    add_size(parser)
    arguments = parser.parse_args()
    require(arguments.program, "valgrind", "callgrind_annotate")
    print(f"""# Cost of the energy models

`testenv/benchmark/energy_cost.py PROGRAM`: instructions of one camera sample, {arguments.size[0]} x {arguments.size[1]} pixels, and beside them the ratio to
the published model. `bounded` is the default.
`testenv/statistical/results/energy.md` has what each reflects.

| scene | {" | ".join(MODELS)} |
|--|{"--|" * len(MODELS)}""")
    with tempfile.TemporaryDirectory() as name:
        for scene in arguments.scene or SCENES:
            counts = [per_sample(arguments.program, scene, pathlib.Path(name), arguments.size, ["--set", f"energy={model}"])[1] for model in MODELS]
            print(f"| {scene} | " + " | ".join(f"{count:.0f} ({count / counts[0]:.3f})" for count in counts) + " |", flush=True)


if __name__ == "__main__":
    main()
