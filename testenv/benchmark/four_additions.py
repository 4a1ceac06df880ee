#!/usr/bin/env python3
"""Counts what an addition touches: a render setting, a mesh option, a light parameter and an AOV.

  four_additions.py FOLDER COMMIT...

Makes a worktree of HEAD in FOLDER with the four additions, each a commit, and prints the files and lines that each changes by hand. The
additions have names, ranges and sentences and travel as far as core's descriptions; no integrator reads them. Then it prints the files
and lines of an existing row of each kind that `alabaster schema --write .` writes, and those of each COMMIT that name four properties
of meshes, and the lines of delegate's rooms. try_additions.py tries the additions once they are built, and `git worktree remove --force
FOLDER` throws them away.
"""
import argparse
import pathlib
import subprocess

TOP = pathlib.Path(__file__).resolve().parents[2]

# (file, line after which the text is put, text)
ADDITIONS = {
    "trialSetting": [
        ("core/session/render_settings.h", "  bool denoise = false;", "  float trial_setting = 0;"),
        ("core/session/render_settings.cpp", "  static constexpr SettingParameter kTable[] = {",
         '      {"trialSetting", &S::trial_setting, 0, 1, {},\n       "none", "A setting that a trial adds."},'),
    ],
    "trialOption": [
        ("core/scene/mesh_options.h", "  bool holdout = false;", "  Rgb trial_option{0.0f};"),
        ("core/scene/mesh_options.cpp", "  static constexpr Parameter<O> kTable[] = {",
         '      {"trialOption", &O::trial_option, 0, 1, {},\n       "none", "An option that a trial adds."},'),
    ],
    "trialParameter": [
        ("core/light/light_parameters.h", "  bool treat_as_point = false;", "  float trial_parameter = 0;"),
        ("core/light/light_parameters.cpp", '       "none", "Colour in the rendering space; multiplies intensity."},',
         '      {"trialParameter", &P::trial_parameter, 0, 1, {},\n       "none", "A parameter that a trial adds."},'),
    ],
    "trialAov": [
        ("core/film/aov.h", "  motion,        // of the first hit over the picture, in pixels, while the shutter is open", "  trial,"),
        ("core/film/aov.h", '    {Aov::motion, "motion", AovSource::closest, AovValue::exact, 0, "motion", "XY"},',
         '    {Aov::trial, "trialAov", AovSource::samples, AovValue::number, 0.25f, "trialAov", "X"},'),
        ("delegate/manual/pipeline.md", "| `sampleCount` | sampleCount.X | number of samples", "| `trialAov` | trialAov.X | an AOV that a trial adds |"),
    ],
}


def git(folder, *arguments):
    return subprocess.run(["git", "-C", folder, *arguments], check=True, capture_output=True, text=True).stdout


def make(folder):
    git(TOP, "worktree", "add", "--detach", folder, "HEAD")
    for name, edits in ADDITIONS.items():
        for file, anchor, text in edits:
            path = folder / file
            before = path.read_text()
            at = before.index(anchor) + len(anchor)
            at = before.index("\n", at)
            path.write_text(before[:at] + "\n" + text + before[at:])
        git(folder, "commit", "-qam", name)


def by_hand(folder):
    print("| addition | files by hand | lines by hand |\n| --- | --- | --- |")
    for place, name in reversed(list(enumerate(reversed(ADDITIONS)))):
        files = git(folder, "diff", "--numstat", f"HEAD~{place + 1}", f"HEAD~{place}").splitlines()
        print(f"| {name} | {len(files)} | {sum(int(line.split()[0]) for line in files)} |")


def written():
    print("| existing row | files written | lines that name it |\n| --- | --- | --- |")
    for name, pattern in (("setting glossyFilter", '[`" ]glossyFilter["`:]'), ("mesh option holdout", '[`" ]holdout["`:]'),
                          ("light parameter shaping:focus", '[`"]shaping:focus[`"]'), ("AOV Neye", '^ *"Neye",?$')):
        found = grep(pattern, "HEAD", "schemas", "delegate/manual/parameters", "delegate/python/hdalabaster/_fields.pyi")
        print(f"| {name} | {len(files_of(found))} | {len(found)} |")


def grep(pattern, commit, *paths):
    return subprocess.run(["git", "-C", TOP, "grep", "-i", "-E", pattern, commit, "--", *paths], capture_output=True, text=True).stdout.splitlines()


def files_of(lines):
    return {line.split(":")[1] for line in lines}


def names(commits):
    print("| named | " + " | ".join(f"{c}: files, lines" for c in commits) + " |\n| --- |" + " --- |" * len(commits))
    for name, pattern in (("doubleSided", "double_?sided|single_?sided"), ("cullStyle", "cull_?style|CULL_"), ("holdout", "hold_?out"),
                          ("renderTag", "render_?tag")):
        lines = [grep(pattern, commit, "core", "delegate", "schemas", ":!delegate/manual") for commit in commits]
        print(f"| {name} | " + " | ".join(f"{len(files_of(found))}, {len(found)}" for found in lines) + " |")


def rooms(commits):
    """Lines of delegate's rooms, and those that are neither empty nor a comment, an include or a bracket alone."""
    counts = []
    for commit in commits:
        count = {"all": [0, 0]}
        listed = git(TOP, "ls-tree", "-r", "--name-only", commit, "delegate").splitlines()
        for file in (name for name in listed if name.endswith((".cpp", ".h", ".hpp", ".py", ".cmake"))):
            lines = [line.strip() for line in git(TOP, "show", f"{commit}:{file}").splitlines()]
            statements = [line for line in lines if line.strip("{}()[],;") and not line.startswith(("//", "/*", "*", "# ", "#include", "#pragma"))]
            for room in ("all", file.split("/")[1]):
                count[room] = [a + b for a, b in zip(count.get(room, [0, 0]), (len(lines), len(statements)))]
        counts.append(count)
    print("| room | " + " | ".join(f"{commit}: lines, statements" for commit in commits) + " |\n| --- |" + " --- |" * len(commits))
    for room in sorted(set().union(*counts), key=lambda room: -counts[-1].get(room, [0, 0])[0]):
        print(f"| {room} | " + " | ".join("{}, {}".format(*count[room]) if room in count else "-" for count in counts) + " |")


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("folder", type=pathlib.Path)
    parser.add_argument("commits", nargs="+")
    options = parser.parse_args()
    make(options.folder.resolve())
    by_hand(options.folder.resolve())
    written()
    names(options.commits)
    rooms(options.commits)


if __name__ == "__main__":
    main()
