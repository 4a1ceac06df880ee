#!/usr/bin/env python3
"""Tries one-line faults: each is put into a copy of HEAD, which is built, and the table that must notice it is run.

  faults.py FOLDER [--only REGEX] [--jobs N] [--list]

The copy and its build stay in FOLDER. Prints a table in Markdown, and exits with 1 if a fault is not noticed. A fault whose line is no
longer there, exactly once, is printed as gone. Takes a quarter of an hour of two cores.
"""
import argparse
import os
import pathlib
import re
import shutil
import subprocess
import sys
import time
from typing import NamedTuple

TOP = pathlib.Path(__file__).resolve().parents[2]
TARGETS = ("alabaster", "alabaster_python", "fake_oidn")
PYTHON_TABLES = ("settings_table", "dirty_bits_table", "picture_numbers")


class Fault(NamedTuple):
    number: str  # of the list in issue "11"
    what: str
    file: str
    line: str
    wrong: str
    table: tuple  # its name and arguments


FAULTS = [
    Fault("1", "weights of walks are not passed on", "core/session/render_settings.cpp", "  out.walk.weights = s.walk_weights;\n", "",
          ("settings_table",)),
    Fault("2", "walkGuiding has no effect", "core/session/render_settings.cpp", "shortcuts && s.walk_guiding", "shortcuts",
          ("settings_table", "walkGuiding")),
    Fault("3a", "twins in mode reference", "core/session/render_settings.cpp", "out.walk.twins = shortcuts;", "out.walk.twins = true;",
          ("settings_table", "subsurface")),
    Fault("4", "two layers are not exposed", "core/session/tile_renderer.cpp", "&layers->unscattered, &layers->single, ", "",
          ("picture_numbers", "PictureNumbers.test_layers_add_up_under_exposure")),
    Fault("5", "layers of a sample that is not finite are kept", "core/session/tile_renderer.cpp", "    *parts.layers = {};\n", "",
          ("picture_numbers", "PictureNumbers.test_layers_add_up_where_samples_are_not_finite")),
    Fault("6", "AOV error is twice the deviation", "core/film/film_tile.cpp", "*to = noise(i).deviation();",
          "*to = 2 * noise(i).deviation();", ("picture_numbers", "PictureNumbers.test_error_is_the_deviation_over_seeds")),
    Fault("7a", "--display is lost", "delegate/cli/outputs.cpp", "    if (!a.display.empty()) product.display = a.display;\n", "",
          ("flags_table", "--only=render --display$")),
    Fault("7b", "--view is lost", "delegate/cli/outputs.cpp", "    if (!a.view.empty()) product.view = a.view;\n", "",
          ("flags_table", "--only=render --view$")),
    Fault("7c", "--look is lost", "delegate/cli/outputs.cpp", "    if (!a.look.empty()) product.look = a.look;\n", "",
          ("flags_table", "--only=render --look$")),
    Fault("7d", "--exposure is lost", "delegate/cli/outputs.cpp", "    if (a.exposure) product.exposure = *a.exposure;\n", "",
          ("flags_table", "--only=render --exposure$")),
    Fault("8a", "check accepts products that cannot be", "delegate/cli/check_command.cpp", "? kRender : kInput;",
          "? kRender : kDone;", ("flags_table", "--only=^check")),
    Fault("8b", "check overlooks faults of the scene", "delegate/cli/check_command.cpp",
          "  session.require_whole();\n", "", ("flags_table", "--only=^check")),
    Fault("8c", "check ends well when its time is over", "delegate/cli/check_command.cpp", "std::_Exit(kRender);", "std::_Exit(kDone);",
          ("flags_table", "--only=^check")),
    Fault("9a", "statistics: the high end of the error is the low one", "delegate/cli/stats_file.cpp", '"error.high"', '"error.low"',
          ("flags_table", "--only=render --stats$")),
    Fault("9b", "statistics: shadow rays are those of bounces", "delegate/cli/stats_file.cpp", '{"shadow", count("rays.shadow")}',
          '{"shadow", count("rays.bounce")}', ("flags_table", "--only=render --stats$")),
    Fault("9c", "statistics: lost walks are those that left", "delegate/cli/stats_file.cpp", 'count("walk.lost")', 'count("walk.exits")',
          ("flags_table", "--only=render --stats$")),
    Fault("10", "metadata: low and high end of the error are swapped", "delegate/host/product_metadata.cpp",
          '{"error/low", "error.low"}', '{"error/low", "error.high"}', ("flags_table", "--only=render --stats$")),
    Fault("11a", "30 frames a second by default", "delegate/cli/render_options.cpp", "value_or(24)", "value_or(30)",
          ("flags_table", "--only=render --f(ps|rames)")),
    Fault("11b", "a checkpoint each 100 minutes by default", "delegate/host/frame_recorder.h", "checkpoint_seconds = 60;",
          "checkpoint_seconds = 6000;", ("flags_table", "--minute")),
    Fault("12", "Hydra: cull styles are swapped", "delegate/hydra/plugin/hydra_scene.cpp", "      return hd::CullStyle::back;\n",
          "      return hd::CullStyle::front;\n", ("hydra",)),
    Fault("13", "the poles of a dome mix", "core/light/light_image.cpp", "c.y0 = std::max(below - 1, 0);",
          "c.y0 = below > 0 ? below - 1 : height - 1;",
          ("picture_numbers", "PictureNumbers.test_a_pole_of_a_dome_shows_its_own_row")),
    Fault("14a", "the studio's key light is a tenth", "delegate/description/studio.cpp", "2.8, 8.0f,", "2.8, 0.8f,",
          ("picture_numbers", "PictureNumbers.test_a_scene_without_light_is_lit_well")),
    Fault("14b", "the studio's sky is a tenth", "delegate/description/studio.cpp", "kDomeRadiance = 0.2f", "kDomeRadiance = 0.02f",
          ("picture_numbers", "PictureNumbers.test_a_mirror_shows_the_studio")),
    Fault("15a", "info counts four times the triangles", "delegate/cli/info_command.cpp", "(growth / 4)", "growth",
          ("flags_table", "--only=^info")),
    Fault("15b", "a resumed render must have the same time limit", "delegate/rendering/checkpoint_file.cpp", '"timeLimit", ', "",
          ("settings_table", "timeLimit")),
]


class Copy:
    """A copy of HEAD, and its build."""

    def __init__(self, folder, jobs):
        self.source, self.jobs = folder / "source", jobs
        self.built = self.source / "build/release"

    def make(self):
        shutil.rmtree(self.source, ignore_errors=True)
        self.source.mkdir(parents=True)
        archive = subprocess.run(["git", "-C", str(TOP), "archive", "HEAD"], capture_output=True, check=True)
        subprocess.run(["tar", "-x", "-C", str(self.source)], input=archive.stdout, check=True)
        subprocess.run(["cmake", "-S", str(self.source), "-B", str(self.built), "-G", "Ninja", "-DCMAKE_BUILD_TYPE=Release",
                        "-DALABASTER_BENCHMARKS=OFF", f"-DALABASTER_WERROR={'ON' if os.environ.get('CI') else 'OFF'}"], check=True, stdout=subprocess.DEVNULL)
        if errors := self.build():
            sys.exit(errors)

    def build(self):
        """The compiler's errors; empty if it builds."""
        done = subprocess.run(["cmake", "--build", str(self.built), "-j", self.jobs, "--target", *TARGETS], capture_output=True, text=True)
        return done.stdout[-2000:] if done.returncode else ""

    def passes(self, table):
        """(whether the table is content, its last line)."""
        name, *arguments = table
        script = str(self.source / f"testenv/regression/{name}.py")
        environment = {**os.environ, "PYTHONPATH": str(self.built / "python"), "ALABASTER_OIDN": str(self.built / "lib/libfake_oidn.so")}
        if name == "flags_table":
            arguments = [str(self.built / "bin/alabaster"), "--oidn", environment["ALABASTER_OIDN"], *arguments]
        done = subprocess.run([sys.executable, "-B", script, *arguments], capture_output=True, text=True, env=environment)
        said = (done.stdout + done.stderr).strip().splitlines()
        return done.returncode == 0, next((line for line in said if "effect" in line or "Error" in line), said[-1] if said else "")


def tried(copy, fault):
    """(result, line of the table that says so)."""
    file = copy.source / fault.file
    text = file.read_text() if file.exists() else ""
    if text.count(fault.line) != 1:
        return "gone", ""
    if fault.table[0] == "hydra":
        return "not tried: needs OpenUSD", ""
    file.write_text(text.replace(fault.line, fault.wrong))
    try:
        if errors := copy.build():
            return "**does not compile**", errors
        content, said = copy.passes(fault.table)
    finally:
        file.write_text(text)
    return ("**not noticed**" if content else "noticed"), said


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("--only", default="", metavar="REGEX", help="of the number")
    parser.add_argument("--jobs", default=str(os.cpu_count()))
    parser.add_argument("--list", action="store_true")
    arguments = parser.parse_args()
    chosen = [fault for fault in FAULTS if re.fullmatch(arguments.only or ".*", fault.number)]
    if arguments.list:
        print("\n".join(f"{f.number}: {f.what} ({f.file}), for {' '.join(f.table)}" for f in chosen))
        return 0
    copy = Copy(arguments.folder.resolve(), arguments.jobs)
    copy.make()
    for table in sorted({fault.table for fault in chosen} - {("hydra",)}):
        content, said = copy.passes(table)
        if not content:
            sys.exit(f"{' '.join(table)} fails without a fault: {said}")
    print("| # | fault | table | |\n| --- | --- | --- | --- |", flush=True)
    missed = 0
    for fault in chosen:
        began = time.monotonic()
        result, said = tried(copy, fault)
        missed += result.startswith("**")
        print(f"| {fault.number} | {fault.what} | {' '.join(fault.table)} | {result} |", flush=True)
        print(f"{fault.number}: {time.monotonic() - began:.0f} s; {said}", file=sys.stderr)
    return 1 if missed else 0


if __name__ == "__main__":
    sys.exit(main())
