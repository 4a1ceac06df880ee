#!/usr/bin/env python3
"""Compares the noise that two builds of the program (or two settings of one) reach in the same CPU time.

  noise_gain.py BEFORE AFTER [--scene NAME|FILE.json ...] [--size WxH] [--spp N] [--seeds N] [--before-flag FLAG ...] [--after-flag FLAG ...] [--instructions]

Every scene is rendered by both, turn by turn, with several seeds. The variance over the seeds, divided by the squared level
of the picture (core/convergence/frame_error.h) and averaged over the pixels, is the relative mean squared error of an unbiased
picture. One column has it for pixels, one for the 98 % of the pixels that are least noisy in both (few rare bright paths would
else decide), one for the means of blocks of 8 x 8 pixels, the noise that neither eye nor denoiser averages away. A gain is the
ratio of error x CPU seconds of the render phase, BEFORE over AFTER: 2 means the same noise in half the time. --instructions takes
instructions of a sample (compare_programs.py) in place of seconds, which depend on what else the machine does. In brackets is its interval of 95 %, by the jackknife over the seeds. `bias z` is the largest z value of the three channels' means over the whole picture, and `block z` the root mean square
of Welch's t over blocks of 16 x 16 pixels: 1 to about 1.3 where both programs have the same expectation and few seeds are taken.
"""
import argparse
import json
import math
import pathlib
import subprocess
import sys
import tempfile

HERE = pathlib.Path(__file__).resolve().parent
sys.path.insert(0, str(HERE.parent / "statistical" / "calibration"))
from compare_programs import BUNDLED, HEIGHT, WIDTH, environment, instructions_per_sample, scene_file  # noqa: E402
from pictures import Reference, read_exr  # noqa: E402


def render(program, scene, seed, arguments, flags, folder):
    """The picture and its CPU seconds."""
    output, stats = folder / "picture.exr", folder / "stats.json"
    command = [program, "render", str(scene_file(scene)), "-o", str(output), "--quiet", "--stats", str(stats),
               "--size", arguments.size, "--spp", str(arguments.spp), "--set", f"seed={seed}", "--threads", str(arguments.threads),
               *flags]
    done = subprocess.run(command, env=environment(program), capture_output=True, text=True)
    if done.returncode != 0:
        sys.exit(f"{' '.join(command)}\nended with {done.returncode}: {done.stderr}")
    return read_exr(output), json.loads(stats.read_text())["delegate"][0]["phase.render.cpu"]


def block_means(picture, side):
    """Means of blocks of side x side pixels, a list for each channel, without incomplete blocks."""
    means = []
    for plane in picture.planes:
        means.append([sum(plane[(y + j) * picture.width + x + i] for j in range(side) for i in range(side)) / side ** 2
                      for y in range(0, picture.height - side + 1, side) for x in range(0, picture.width - side + 1, side)])
    return means


def mean_and_variance(values):
    mean = sum(values) / len(values)
    return mean, sum((v - mean) ** 2 for v in values) / (len(values) - 1)


class Side:
    """All renders of one program."""

    def __init__(self, pictures=(), costs=()):
        self.pictures, self.costs = list(pictures), list(costs)

    def without(self, i):
        """All renders but one."""
        return Side(self.pictures[:i] + self.pictures[i + 1:], self.costs[:i] + self.costs[i + 1:])

    def pixel_errors(self):
        """Relative squared error of each pixel, the mean of its channels."""
        reference = Reference(self.pictures)
        return [sum(variance) / 3 / scale * len(self.pictures) for *variance, scale in zip(*reference.variance, reference.scales)]

    def block_error(self):
        """Relative mean squared error of the 8 x 8 means; the level of the picture is each block's own and a floor."""
        total, count = 0.0, 0
        for channel in zip(*(block_means(p, 8) for p in self.pictures)):
            moments = [mean_and_variance(values) for values in zip(*channel)]
            floor = 0.05 * sum(mean for mean, _ in moments) / len(moments)
            total += sum(variance / (mean ** 2 + floor ** 2) for mean, variance in moments)
            count += len(moments)
        return total / count


def welch(a, b):
    (mean_a, variance_a), (mean_b, variance_b) = mean_and_variance(a), mean_and_variance(b)
    scatter = variance_a / len(a) + variance_b / len(b)
    return (mean_a - mean_b) / math.sqrt(scatter) if scatter > 0 else 0.0


def largest_bias(before, after):
    """Largest |z| of the channels' means, and the root mean square of Welch's t over 16 x 16 blocks."""
    means = [[[sum(plane) / len(plane) for plane in p.planes] for p in side.pictures] for side in (before, after)]
    whole = max(abs(welch([m[c] for m in means[0]], [m[c] for m in means[1]])) for c in range(3))
    blocks = [[block_means(p, 16) for p in side.pictures] for side in (before, after)]
    squares = []
    for c in range(3):
        for i in range(len(blocks[0][0][c])):
            squares.append(welch([b[c][i] for b in blocks[0]], [b[c][i] for b in blocks[1]]) ** 2)
    return whole, math.sqrt(sum(squares) / len(squares))


def gains(before, after, calm):
    """Of pixels, of the pixels `calm`, of 8 x 8 means."""
    cost = sum(after.costs) / sum(before.costs)
    pixels = [side.pixel_errors() for side in (before, after)]
    ratios = [sum(pixels[0]) / sum(pixels[1]), sum(pixels[0][i] for i in calm) / sum(pixels[1][i] for i in calm),
              before.block_error() / after.block_error()]
    return [ratio / cost for ratio in ratios]


# Two-sided 95 % of Student's distribution with 1, 2, ... degrees of freedom.
T95 = (12.706, 4.303, 3.182, 2.776, 2.571, 2.447, 2.365, 2.306, 2.262, 2.228, 2.201, 2.179, 2.160, 2.145, 2.131)


def with_intervals(before, after, calm):
    """The gains as text, with intervals of 95 % by the jackknife over pairs of renders of a seed."""
    count = len(before.pictures)
    parts = [[math.log(g) for g in gains(before.without(i), after.without(i), calm)] for i in range(count)]
    texts = []
    for gain, values in zip(gains(before, after, calm), zip(*parts)):
        mean = sum(values) / count
        error = math.sqrt((count - 1) / count * sum((v - mean) ** 2 for v in values))
        reach = math.exp(T95[min(count - 1, len(T95)) - 1] * error)
        texts.append(f"{gain:.2f} ({gain / reach:.2f} to {gain * reach:.2f})")
    return texts


def main():
    parser = argparse.ArgumentParser(description=__doc__, formatter_class=argparse.RawDescriptionHelpFormatter)
    parser.add_argument("before")
    parser.add_argument("after")
    parser.add_argument("--scene", action="append", help="a bundled scene, or a render description; may be repeated")
    parser.add_argument("--size", default="96x64")
    parser.add_argument("--spp", type=int, default=16)
    parser.add_argument("--seeds", type=int, default=8)
    parser.add_argument("--threads", type=int, default=1)
    parser.add_argument("--before-flag", action="append", default=[], help="passed to BEFORE's render; may be repeated")
    parser.add_argument("--after-flag", action="append", default=[], help="passed to AFTER's render; may be repeated")
    parser.add_argument("--instructions", action="store_true", help="cost is instructions of a sample, not CPU seconds")
    arguments = parser.parse_args()
    if arguments.seeds < 3:
        parser.error("--seeds must be 3 or more: noise is the difference between seeds, and its interval that without one of them")
    sides = ((arguments.before, arguments.before_flag), (arguments.after, arguments.after_flag))
    print(f"{arguments.size}, {arguments.spp} samples, {arguments.seeds} seeds\n")
    cost = "instructions" if arguments.instructions else "CPU"
    print(f"| scene | relative MSE: before | after | {cost}: after / before | gain, pixels | gain, 98 % | gain, 8 x 8 means | bias z | block z |")
    print("|--|--|--|--|--|--|--|--|--|")
    with tempfile.TemporaryDirectory() as name:
        for scene in arguments.scene or BUNDLED:
            before, after = Side(), Side()
            costs = [instructions_per_sample(scene, program, pathlib.Path(name), (WIDTH, HEIGHT), flags)
                     for program, flags in sides] if arguments.instructions else [None, None]
            for seed in range(1, arguments.seeds + 1):
                for side, (program, flags), counted in zip((before, after), sides, costs):
                    picture, seconds = render(program, scene, seed, arguments, flags, pathlib.Path(name))
                    side.pictures.append(picture)
                    side.costs.append(counted or seconds)
            pixels = [side.pixel_errors() for side in (before, after)]
            errors = [sum(errors) / len(errors) for errors in pixels]
            calm = sorted(range(len(pixels[0])), key=lambda i: pixels[0][i] + pixels[1][i])[:len(pixels[0]) * 98 // 100]
            ratio = sum(after.costs) / sum(before.costs)
            texts = with_intervals(before, after, calm)
            whole, block = largest_bias(before, after)
            print(f"| {pathlib.Path(scene).stem} | {errors[0]:.5f} | {errors[1]:.5f} | {ratio:.3f} | {' | '.join(texts)} | {whole:.1f} | {block:.2f} |",
                  flush=True)


if __name__ == "__main__":
    main()
