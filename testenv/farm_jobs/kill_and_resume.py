#!/usr/bin/env python3
"""Kills checkpointed renders at random moments and compares what they become with renders that nothing interrupted.

  kill_and_resume.py PROGRAM [--kills 100] [--seed 1] [--size 96x64]

A trial begins a render with --checkpoint, kills it with SIGKILL at a moment spread evenly over the time that it takes,
begins the same command again with --resume, and so on until it has been killed as often as the trial asks for (one to
three times); then it lets the render end. The pixels of all layers must be those of the render without interruption, to
the bit, and no file but theirs may be left. Trials take turns among evenly sampled, adaptive and target-error renders. Exits
with 1 at the first that differs.
"""
import argparse
import pathlib
import random
import signal
import subprocess
import sys
import tempfile
import time

SCENE = pathlib.Path(__file__).resolve().parents[1] / "scenes/backlit/backlit.json"
LAYERS = ["depth", "normal", "albedo", "primId", "sampleCount", "diffuse", "subsurface", "error"]
MODES = {
    "even": ["--spp", "24"],
    "adaptive": ["--spp", "40", "--set", "adaptive=true"],
    "target error": ["--spp", "256", "--target-error", "0.2"],
}


def command(args, mode, output, checkpoint=None):
    words = [args.program, "render", str(SCENE), "--size", args.size, "--quiet", "-o", str(output), *MODES[mode]]
    for layer in LAYERS:
        words += ["--aov", layer]
    if checkpoint:
        words += ["--checkpoint", str(checkpoint), "--checkpoint-interval", "0.02", "--resume"]
    return words


def finish(words):
    done = subprocess.run(words, capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(words)}\nended with {done.returncode}: {done.stderr}")


def same_pixels(a, b):
    done = subprocess.run(["oiiotool", str(a), str(b), "--fail", "0", "--warn", "0", "--diff"], capture_output=True, text=True)
    return done.returncode == 0


# promise: farm.checkpoint, farm.checkpoint.whole_file, pipeline.output.killed
def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("program")
    parser.add_argument("--kills", type=int, default=100)
    parser.add_argument("--seed", type=int, default=1)
    parser.add_argument("--size", default="96x64")
    args = parser.parse_args()
    moments = random.Random(args.seed)
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        whole, seconds = {}, {}
        for mode in MODES:
            whole[mode] = folder / f"{mode.replace(' ', '_')}.exr"
            begun = time.monotonic()
            finish(command(args, mode, whole[mode]))
            seconds[mode] = time.monotonic() - begun
        kills = trials = went_on = 0
        while kills < args.kills:
            mode = list(MODES)[trials % len(MODES)]
            checkpoint, output = folder / "render.checkpoint", folder / "resumed.exr"
            checkpoint.unlink(missing_ok=True)
            words = command(args, mode, output, checkpoint)
            for _ in range(min(moments.randint(1, 3), args.kills - kills)):
                process = subprocess.Popen(words, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
                try:
                    process.wait(moments.uniform(0, 1.2 * seconds[mode]))
                except subprocess.TimeoutExpired:
                    process.send_signal(signal.SIGKILL)
                    process.wait()
                kills += 1
                went_on += checkpoint.exists()
            finish(words)
            if not same_pixels(whole[mode], output):
                sys.exit(f"trial {trials} ({mode}, seed {args.seed}): the picture differs from that of the render in one")
            for file in folder.glob(".alabaster-*.tmp"):  # of a process that was killed while it wrote
                file.unlink()
            if strangers := set(folder.iterdir()) - {checkpoint, output, *whole.values()}:
                sys.exit(f"trial {trials} ({mode}, seed {args.seed}): files are left: {sorted(p.name for p in strangers)}")
            trials += 1
    print(f"{kills} kills in {trials} renders, {went_on} with a checkpoint: all pictures equal to the bit")


if __name__ == "__main__":
    main()
