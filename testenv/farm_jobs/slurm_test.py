#!/usr/bin/env python3
"""Renders a frame as a Slurm job array of four tasks, one of which is killed, and compares it with one machine's.

  slurm_test.py PROGRAM          as ctest runs it; skipped where Slurm is missing
apt-get install slurm-wlm installs Debian's; the test starts its daemons itself, as root. Exit code 77: skipped.
"""
import os
import pathlib
import re
import signal
import subprocess
import sys
import tempfile

from slurm_cluster import SlurmCluster, missing

TOP = pathlib.Path(__file__).resolve().parents[2]
SCENE = TOP / "testenv/scenes/thick_thin/thick_thin.json"
LOOK = ["--size", "60x40", "--spp", "800", "--threads", "1", "--aov", "normal"]
SKIPPED, TASKS, LOST = 77, 4, 2
HOSTILE = "a farm's %j %% `touch PWNED` $(touch PWNED) \"#SBATCH --wrap=x"  # is a name like any other
ENDED = ("COMPLETED", "FAILED", "CANCELLED")


def run(*words, environment=None):
    done = subprocess.run([str(word) for word in words], capture_output=True, text=True, env=environment)
    if done.returncode != 0:
        raise SystemExit(f"{' '.join(str(word) for word in words)}\nended with {done.returncode}\n{done.stdout}{done.stderr}")
    return done.stdout + done.stderr


def renders_of(part):
    """The processes that render a part of the farm."""
    found = []
    for process in pathlib.Path("/proc").glob("[0-9]*"):
        try:
            words = (process / "cmdline").read_bytes().split(b"\0")
        except OSError:
            continue
        if b"render" in words and str(part).encode() in words:
            found.append(int(process.name))
    return found


def submit(cluster, folder):
    """The numbers of the array and of the merge."""
    merge = run("sh", folder / "submit.sh", "--comment=ours", environment=cluster.environment).split()[-1]
    array = max(cluster.ask("squeue", "--noheader", "--states=all", "--name=alabaster", "--format=%F").split(), key=int)
    check(all("Comment=ours" in cluster.ask("scontrol", "show", "job", job) for job in (array, merge)), "sbatch gets the options")
    return array, merge


def check(holds, what):
    if not holds:
        raise SystemExit(f"FAILED: {what}")
    print(f"holds: {what}", flush=True)


def lose_a_task(cluster, folder):
    array, merge = submit(cluster, folder)
    part = folder / f"part.{LOST:05}.checkpoint"
    mark = folder / f"task.{LOST:05}.running"
    cluster.wait(lambda: mark.exists() and renders_of(part), 120, f"task {LOST} to render")
    for process in renders_of(part):
        os.kill(process, signal.SIGKILL)
    tasks = [f"{array}_{k}" for k in range(TASKS)]
    cluster.wait(lambda: all(cluster.state(task) in ENDED for task in tasks), 300, "the tasks to end")
    states = [cluster.state(task) for task in tasks]
    check(states == ["FAILED" if k == LOST else "COMPLETED" for k in range(TASKS)], f"one task was lost: {' '.join(states)}")
    cluster.wait(lambda: cluster.state(merge) in ENDED, 120, "the merge to be given up")
    check(cluster.state(merge) == "CANCELLED", "a merge that lacks a part is cancelled")


# promise: farm.engine.slurm
def main():
    if reason := missing():
        print(f"skipped: {reason}")
        sys.exit(SKIPPED)
    program = pathlib.Path(sys.argv[1]).resolve()
    with tempfile.TemporaryDirectory() as place:
        folder, frame, whole = (pathlib.Path(place) / name for name in (HOSTILE, "frame.exr", "whole.exr"))
        run(program, "farm", SCENE, "-o", frame, *LOOK, "--tasks", TASKS, "--engine", "slurm", "--folder", folder)
        with SlurmCluster(pathlib.Path(place) / "slurm", os.cpu_count()) as cluster:
            lose_a_task(cluster, folder)
            told = subprocess.run([program, "farm", "status", folder], capture_output=True, text=True)
            print(told.stdout, end="")
            check(told.returncode == 4 and re.search(rf"^task {LOST} +lost ", told.stdout, re.M) and not frame.exists(),
                  "the status names the task that is lost")
            _, merge = submit(cluster, folder)
            cluster.wait(lambda: cluster.state(merge) in ENDED, 300, "the merge")
            check(cluster.state(merge) == "COMPLETED" and frame.exists(), "submitted again, the rest is rendered and merged")
            logs = [f"task_{k}.log" for k in range(TASKS)] + ["merge.log"]
            check(all((folder / log).exists() for log in logs), "the logs lie in the folder, by number")
        run(program, "render", SCENE, "-o", whole, *LOOK)
        run("oiiotool", frame, whole, "--fail", "0", "--warn", "0", "--diff")
        print("holds: all layers have the bits of one machine's")


if __name__ == "__main__":
    main()
