#!/usr/bin/env python3
"""Measures whole frames against Embree's own limit: a render's CPU time over that of tracing the same rays alone.

  render_time.py PROGRAM [PROGRAM ...] [--scene NAME ...] [--rounds N]

Every round renders each scene with each program, turn by turn, in one thread, and traces the same rays again, bare and in the
same order, in one thread of a second run (replay_rays.cpp). Times are CPU seconds of the render phase and of the replay; a
row has the least of all rounds. Each program finds its library beside itself, in ../lib; the first one's lib also has
libreplay_rays.so.
"""
import argparse
import json
import os
import pathlib
import subprocess
import sys
import tempfile

from compare_programs import BUNDLED, SCENES, environment, require, require_benchmark

DEFAULT_SCENES = ["skin_closeup", "thick_thin", "backlit", "sample", "mixed_no_subsurface"]


def render(program, scene, arguments, folder, recorder=None):
    """CPU seconds of the render phase, rays, and what the replay says, if there is one."""
    stats, replay = folder / "stats.json", folder / "replay.json"
    command = [program, "render", str(SCENES / scene / f"{scene}.json"), "-o", str(folder / "picture.exr"), "--quiet",
               "--stats", str(stats), "--size", arguments.size, "--spp", str(arguments.spp), "--threads", "1", "--set", "denoise=false"]
    variables = environment(program)
    if recorder:
        variables.update(LD_PRELOAD=str(recorder), ALABASTER_REPLAY=str(replay))
    done = subprocess.run(command, env=variables, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(command)}\nended with {done.returncode}: {done.stderr}")
    told = json.loads(stats.read_text())
    return told["phases"]["render"]["cpu"], told, json.loads(replay.read_text()) if recorder else None


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("programs", nargs="+")
    parser.add_argument("--scene", action="append", choices=[*BUNDLED, "sample"], help="only this scene; may be repeated")
    parser.add_argument("--rounds", type=int, default=5)
    parser.add_argument("--size", default="240x160")
    parser.add_argument("--spp", type=int, default=4)
    arguments = parser.parse_args()
    require(*arguments.programs)
    recorder = pathlib.Path(arguments.programs[0]).resolve().parents[1] / "lib" / "libreplay_rays.so"
    require_benchmark(recorder)
    print("| scene | program | rays a sample | render: CPU s | bare Embree: CPU s | ns a ray: render | bare | render : bare |")
    print("|--|--|--|--|--|--|--|--|")
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        for scene in arguments.scene or DEFAULT_SCENES:
            least = {program: [float("inf"), float("inf")] for program in arguments.programs}
            for _ in range(arguments.rounds):
                for program in arguments.programs:
                    seconds, told, _ = render(program, scene, arguments, folder)
                    replay = render(program, scene, arguments, folder, recorder)[2]
                    least[program][0] = min(least[program][0], seconds)
                    least[program][1] = min(least[program][1], replay["seconds"])
            for i, program in enumerate(arguments.programs):
                whole, bare = least[program]
                rays, samples = replay["rays"], told["samples"]["total"]
                print(f"| {scene} | {i + 1} | {rays / samples:.1f} | {whole:.3f} | {bare:.3f} | {1e9 * whole / rays:.0f} | "
                      f"{1e9 * bare / rays:.0f} | {whole / bare:.2f} |", flush=True)


if __name__ == "__main__":
    main()
