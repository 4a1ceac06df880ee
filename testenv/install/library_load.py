#!/usr/bin/env python3
"""Measures what it costs a host to load the library, as a table; fails above what the project promises.

  library_load.py PROBE LIBRARY SCENE SCENE_WITH_IMAGES [--runs 20]

PROBE is load_probe.c as a program. Each run is a fresh process; the last two render a scene without images and one with
images. Needs readelf and c++filt (binutils).
"""
import argparse
import re
import statistics
import subprocess
import sys

LIBRARIES = 12  # besides our own, at most, and TBB's allocator, which Embree 4 links
MILLISECONDS = 30  # the fastest run, so that a busy machine fails no test
OURS = re.compile(r"^(alabaster_|AlabasterVersions$|CreateAlabasterRenderDelegate$|DestroyAlabasterRenderDelegate$|"
                  r"(vtable for |typeinfo for |typeinfo name for )?alabaster::hd::)")


def probe(*command):
    """One run: a number by key, and the libraries that were mapped or kept."""
    numbers, lists = {}, {"maps": [], "opens": [], "keeps": []}
    for line in subprocess.run(command, check=True, capture_output=True, text=True).stdout.splitlines():
        key, value = line.split(" ", 1)
        if key in lists:
            lists[key].append(value)
        else:
            numbers[key] = float(value)
    return numbers, lists


def exported(library):
    """Pairs (binding, demangled name) of the symbols that the library defines for others."""
    listing = subprocess.run(["readelf", "-W", "--dyn-syms", library], check=True, capture_output=True, text=True).stdout
    symbols = [line.split() for line in listing.splitlines()]
    symbols = [(s[4], s[7].split("@")[0]) for s in symbols if len(s) > 7 and s[0].rstrip(":").isdigit() and s[6] != "UND"]
    names = subprocess.run(["c++filt"], input="\n".join(name for _, name in symbols), check=True, capture_output=True,
                           text=True).stdout.splitlines()
    return [(binding, name) for (binding, _), name in zip(symbols, names)]


# promise: embedding.process
def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("probe")
    parser.add_argument("library")
    parser.add_argument("scene")
    parser.add_argument("scene_with_images")
    parser.add_argument("--runs", type=int, default=20)
    arguments = parser.parse_args()
    times = [probe(arguments.probe, arguments.library)[0]["milliseconds"] for _ in range(arguments.runs)]
    numbers, lists = probe(arguments.probe, arguments.library, arguments.scene)
    with_images = probe(arguments.probe, arguments.library, arguments.scene_with_images)[1]
    symbols = exported(arguments.library)
    foreign = [name for _, name in symbols if not OURS.match(name)]
    unique = [name for binding, name in symbols if binding == "UNIQUE"]
    kept = [name for name in lists["keeps"] if "labaster" in name]
    kept_with_images = [name for name in with_images["keeps"] if "labaster" in name]
    others = [name for name in lists["maps"] if "labaster" not in name]

    opened, opened_with_images = (any("OpenImageIO" in name for name in run["opens"]) for run in (lists, with_images))

    print("| dlopen | |\n| --- | --- |")
    print(f"| milliseconds, p50 of {len(times)} fresh processes (fastest) | {statistics.median(times):.1f} ({min(times):.1f}) |")
    print(f"| libraries mapped besides ours and glibc's | {len(others)} |")
    print(f"| MB mapped, ours and theirs | {numbers['bytes'] / 1e6:.0f} |")
    print(f"| threads started | {numbers['threads']:.0f} |")
    print(f"| symbols exported; not ours; GNU_UNIQUE | {len(symbols)}; {len(foreign)}; {len(unique)} |")
    print(f"| after a render and dlclose: libraries of ours; of others; threads | {len(kept)}; {len(lists['keeps']) - len(kept)}; "
          f"{numbers['threads_left']:.0f} |")

    faults = []
    most = LIBRARIES + any("libembree4" in name for name in others)
    if len(others) > most:
        faults.append(f"more than {most} libraries: " + ", ".join(others))
    if min(times) > MILLISECONDS:
        faults.append(f"more than {MILLISECONDS} ms")
    faults += [f"exports {name}" for name in foreign + unique]
    faults += [f"dlclose leaves {name} mapped" for name in kept + kept_with_images]
    if opened or not opened_with_images:
        faults.append("OpenImageIO must be loaded with the first image, and not before")
    if numbers["threads"] or numbers["threads_left"]:
        faults.append("starts threads")
    for fault in faults:
        print("error: " + fault, file=sys.stderr)
    return 1 if faults else 0


if __name__ == "__main__":
    sys.exit(main())
