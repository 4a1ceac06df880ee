#!/usr/bin/env python3
"""Measures what the models of a folder cost to load: CPU seconds of reading and of building the scene, and peak memory.

  asset_load.py PROGRAM [PROGRAM ...] --assets FOLDER [--md FILE]

Every .gltf and .glb below FOLDER/valid, FOLDER/sss and FOLDER/subdiv is rendered in 8 x 6 pixels at one sample without a studio. A number
is the least of two runs. Two programs take turns and give two columns each: before and after.
"""
import argparse
import os
import pathlib
import tempfile


def measure(program, model, folder):
    """(CPU seconds of the whole run, peak bytes)"""
    pid = os.fork()
    if pid == 0:
        with open(os.devnull, "w") as null:
            os.dup2(null.fileno(), 1)
            os.dup2(null.fileno(), 2)
        os.execv(program, [program, "render", str(model), "-o", f"{folder}/p.exr", "--size", "8x6", "--spp", "1", "--studio", "off"])
    _, status, usage = os.wait4(pid, 0)
    return None if status else (usage.ru_utime + usage.ru_stime, usage.ru_maxrss * 1024)


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("programs", nargs="+")
    parser.add_argument("--assets", type=pathlib.Path, required=True)
    parser.add_argument("--md", type=pathlib.Path)
    options = parser.parse_args()
    models = sorted(f for part in ("valid", "sss", "subdiv") for f in (options.assets / part).rglob("*.gl*") if f.suffix in (".gltf", ".glb"))
    head = "| file |" + "".join(f" CPU s {k} | MB {k} |" for k in range(1, len(options.programs) + 1)).replace(" 1 |", " |" if len(options.programs) == 1 else " 1 |")
    rows, totals = [head, "| --- |" + " --- | --- |" * len(options.programs)], [[0, 0] for _ in options.programs]
    with tempfile.TemporaryDirectory() as folder:
        for model in models:
            best = [None] * len(options.programs)
            for _ in range(2):
                for k, program in enumerate(options.programs):
                    got = measure(program, model, folder)
                    if got:
                        best[k] = got if best[k] is None else tuple(map(min, best[k], got))
            cells = ""
            for k, one in enumerate(best):
                cells += f" {one[0]:.2f} | {one[1] / 1e6:.0f} |" if one else " refused | - |"
                if one:
                    totals[k] = [totals[k][0] + one[0], max(totals[k][1], one[1])]
            rows.append(f"| {model.relative_to(options.assets)} |{cells}")
            print(rows[-1], flush=True)
    rows.append("| sum, largest |" + "".join(f" {t:.2f} | {m / 1e6:.0f} |" for t, m in totals))
    print(rows[-1])
    if options.md:
        options.md.write_text("\n".join(rows) + "\n")


if __name__ == "__main__":
    main()
