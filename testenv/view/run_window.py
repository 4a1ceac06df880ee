#!/usr/bin/env python3
"""Tests the window by scripts of a user's actions, on a screen of its own (Xvfb, software OpenGL), and looks at the pixels.

  run_window.py --build build/release             the tests, as ctest runs them; skipped without the window or Xvfb
  run_window.py --build build/release --results   frame rates and a screenshot of each panel, into testenv/view/results

`apt-get install $(sed 's/#.*//' testenv/packages_window.txt)` installs what it needs. Exit code 77: skipped.
"""
import argparse
import contextlib
import ctypes
import json
import os
import pathlib
import shutil
import struct
import subprocess
import sys
import tempfile

import panels
import story

SKIPPED = 77


@contextlib.contextmanager
def asked_density(display, dots_per_inch):
    """Sets the resource that desktops set, as xrdb does. The server forgets it with its last client, so one stays."""
    x11 = ctypes.CDLL("libX11.so.6")
    x11.XOpenDisplay.restype = ctypes.c_void_p
    connection = ctypes.c_void_p(x11.XOpenDisplay(display.encode()))
    text = f"Xft.dpi:\t{dots_per_inch}\n".encode()
    resource_manager, string, replace = 23, 31, 0  # of Xatom.h and X.h
    x11.XDefaultRootWindow.restype = ctypes.c_ulong
    root = ctypes.c_ulong(x11.XDefaultRootWindow(connection))
    x11.XChangeProperty(connection, root, ctypes.c_ulong(resource_manager), ctypes.c_ulong(string), 8, replace, text, len(text))
    x11.XSync(connection, 0)
    try:
        yield
    finally:
        x11.XCloseDisplay(connection)


@contextlib.contextmanager
def screen(width=1600, height=1000, dots_per_inch=None):
    """A screen for the programs that are started within; its name. `dots_per_inch`: those that the desktop asks programs to use."""
    read, write = os.pipe()
    server = subprocess.Popen(["Xvfb", "-displayfd", str(write), "-screen", "0", f"{width}x{height}x24", "-nolisten", "tcp"],
                              pass_fds=[write], stderr=subprocess.DEVNULL)
    os.close(write)
    try:
        with os.fdopen(read) as pipe:
            number = pipe.readline().strip()
        if not number:
            raise SystemExit("error: Xvfb did not start")
        name = ":" + number
        with asked_density(name, dots_per_inch) if dots_per_inch else contextlib.nullcontext():
            yield name
    finally:
        server.terminate()
        server.wait()


def as_ppm(file):
    """By way of a TGA: oiiotool 2.5 writes a PPM upside down."""
    copy = file.with_suffix(".converted.tga")
    subprocess.run(["oiiotool", str(file), "--ch", "R,G,B", "-d", "uint8", "--compression", "none", "-o", str(copy)], check=True)
    data = copy.read_bytes()
    width, height, _, descriptor = struct.unpack_from("<HHBB", data, 12)
    begin, size = 18 + data[0], 3 * width
    rows = [data[begin + size * y:begin + size * (y + 1)] for y in range(height)]
    pixels = bytearray(b"".join(rows if descriptor & 0x20 else reversed(rows)))
    pixels[0::3], pixels[2::3] = pixels[2::3], pixels[0::3]
    return b"P6\n%d %d\n255\n" % (width, height) + bytes(pixels)


class Window:
    """Runs `alabaster view` in a folder. `display`: None for none."""

    def __init__(self, build, folder, display, oidn):
        self.program = pathlib.Path(build).resolve() / "bin" / "alabaster"
        self.player = self.program.with_name("alabaster-view-player")
        self.folder = pathlib.Path(folder)
        self.environment = {k: v for k, v in os.environ.items() if k not in ("DISPLAY", "WAYLAND_DISPLAY", "OCIO")}
        self.environment["LIBGL_ALWAYS_SOFTWARE"] = "1"
        if display:
            self.environment["DISPLAY"] = display
        if oidn:
            self.environment["ALABASTER_OIDN"] = str(oidn)

    def run(self, *arguments, program=None):
        return subprocess.run([str(program or self.program), *map(str, arguments)], cwd=self.folder, env=self.environment,
                              capture_output=True, text=True, timeout=1800)

    def play(self, scene, lines, *arguments):
        """The states that a script prints, one after the other; ends the test where it fails."""
        script = self.folder / "script.txt"
        script.write_text("\n".join(lines) + "\nquit\n")
        done = self.run(script, scene, *arguments, program=self.player)
        if done.returncode != 0:
            numbered = "\n".join(f"{i:3} {line}" for i, line in enumerate(lines, 1))
            raise SystemExit(f"error: exit code {done.returncode}\n{done.stdout}{done.stderr}\n{numbered}")
        return [json.loads(line) for line in done.stdout.splitlines()]

    def picture(self, name):
        """A picture of the folder."""
        file = self.folder / name
        return story.Picture(file.read_bytes() if file.suffix == ".ppm" else as_ppm(file))


def why_not(build):
    """The reason why the window cannot be tested here, or None."""
    if not (pathlib.Path(build) / "bin" / "alabaster-view-player").exists():
        return "the build has no alabaster-view-player: install testenv/packages_window.txt and configure again"
    for program, package in (("Xvfb", "xvfb"), ("oiiotool", "openimageio-tools")):
        if not shutil.which(program):
            return f"{program} is missing: apt-get install {package}"
    return None


def main():
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("--build", required=True, help="the build folder")
    parser.add_argument("--oidn", help="the library that denoises; default: the one that the program finds")
    parser.add_argument("--results", action="store_true")
    options = parser.parse_args()
    reason = why_not(options.build)
    if reason:
        print("skipped: " + reason)
        return SKIPPED
    with tempfile.TemporaryDirectory() as folder, screen() as display:
        window = Window(options.build, folder, display, options.oidn and pathlib.Path(options.oidn).resolve())
        if options.results:
            panels.write_results(window)
            return 0
        story.tell(window)
        with screen(3200, 1900, dots_per_inch=192) as dense:
            story.dense_screens(window, Window(options.build, folder, dense, None))
        blind = Window(options.build, folder, None, options.oidn)
        story.refusals(blind)
    print(f"{story.checks} checks passed")
    return 0


if __name__ == "__main__":
    sys.exit(main())
