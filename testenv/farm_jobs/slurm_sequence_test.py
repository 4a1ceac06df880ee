#!/usr/bin/env python3
"""Renders 24 frames as a Slurm job array on two nodes, one of which is slow; one task is killed, and one frame fails. What
`alabaster farm status` tells of them, and the frames after another submission, beside one machine's.

  slurm_sequence_test.py PROGRAM          as ctest runs it; skipped where Slurm is missing
Exit code 77: skipped.
"""
import json
import os
import pathlib
import signal
import subprocess
import sys
import tempfile
import threading
import time

from slurm_cluster import SlurmCluster, missing
from slurm_test import SCENE, SKIPPED, check, run

FRAMES, KILLED, FAILING = 24, 5, 13
LOOK = ["--turntable", FRAMES, "--size", "36x24", "--spp", "60", "--threads", "1", "--aov", "normal"]
SHARE = 0.2  # of the time that tasks of the slow node run


def status(program, folder):
    """What is told in text and in JSON, which agree in their exit code."""
    text, told = (subprocess.run([program, "farm", "status", folder, *words], capture_output=True, text=True)
                  for words in ([], ["--json"]))
    every = json.loads(told.stdout)
    return every, text.stdout, told.returncode


def renders(wanted):
    """The processes that render, of whose environment `wanted` is true."""
    found = []
    for process in pathlib.Path("/proc").glob("[0-9]*"):
        try:
            words = (process / "cmdline").read_bytes().split(b"\0")
            variables = dict(line.partition("=")[::2] for line in (process / "environ").read_text(errors="replace").split("\0"))
        except OSError:
            continue
        if b"render" in words and wanted(variables):
            found.append(int(process.name))
    return found


class SlowNode:
    """Stops the renders of a node most of the time, as a node does that is too hot or shared."""

    def __init__(self, name):
        self.ended = threading.Event()
        self.thread = threading.Thread(target=self.turn, args=(name,))

    def turn(self, name):
        while not self.ended.is_set():
            of_node = renders(lambda variables: variables.get("SLURMD_NODENAME") == name)
            for number, pause in ((signal.SIGSTOP, 0.25 * (1 - SHARE)), (signal.SIGCONT, 0.25 * SHARE)):
                for process in of_node:
                    try:
                        os.kill(process, number)
                    except ProcessLookupError:
                        pass
                time.sleep(pause)

    def __enter__(self):
        self.thread.start()

    def __exit__(self, *_):
        self.ended.set()
        self.thread.join()


def submit(cluster, folder):
    """Submits the frames, and the number of their array."""
    return run("sh", folder / "submit.sh", environment=cluster.environment).split()[-1]


def is_over(cluster, array):
    return not cluster.ask("squeue", "--noheader", "--job", array)


def frame_of(folder, number):
    return folder / f"frame.{number:04}.exr"


def lose_two(program, cluster, jobs, pictures):
    frame_of(pictures, FAILING + 1).mkdir()
    array = submit(cluster, jobs)
    is_killed = lambda variables: variables.get("SLURM_ARRAY_TASK_ID") == str(KILLED)
    cluster.wait(lambda: (jobs / f"task.{KILLED:05}.running").exists() and renders(is_killed), 120, f"task {KILLED} to render")
    for process in (caught := renders(is_killed)):
        os.kill(process, signal.SIGSTOP)  # until it has been seen
    every, _, code = status(program, jobs)
    check(every["tasks"][KILLED]["state"] == "running" and every["tasks"][-1]["state"] == "waiting" and code == 1,
          "meanwhile a task runs, the last one waits, and the exit code is 1")
    for process in caught:
        os.kill(process, signal.SIGKILL)
    cluster.wait(lambda: is_over(cluster, array), 300, "the tasks to end")
    every, text, code = status(program, jobs)
    print(text, end="")
    states = [task["state"] for task in every["tasks"]]
    check(code == 4 and every["counts"]["done"] == FRAMES - 2, f"{FRAMES - 2} tasks are done, and the exit code is 4")
    lost, failed = every["tasks"][KILLED], every["tasks"][FAILING]
    check(states[KILLED] == "lost" and f"task_{KILLED}.log" in lost["reason"] and lost["host"] in cluster.nodes,
          f"the one that was killed is lost: {lost['reason']}")
    check(states[FAILING] == "failed" and failed["exitCode"] == 5 and "a folder has this name" in failed["reason"],
          f"the one that fails says why: {failed['reason']}")
    rest = [task for task in every["tasks"] if task["state"] == "done"]
    check(all(task["seconds"] > 0 and task["noise"] > 0 for task in rest), "the others have their time and noise")
    mean = {node: sum(times) / len(times) for node in cluster.nodes
            if (times := [task["seconds"] for task in rest if task["host"] == node])}
    check(set(mean) == set(cluster.nodes) and mean["slow"] > 2 * mean["fast"],
          f"the slow node shows: {mean['slow']:.1f} s a frame, {mean['fast']:.1f} s on the other")
    check(f"on slow took {max(task['seconds'] for task in rest):.1f} s" in text, "the summary names it")
    check(f"sh {jobs}/submit.sh" in text, "and the command that renders the rest")


# promise: farm.engine.slurm, farm.frames, farm.frames.again, farm.status
def main():
    if reason := missing():
        print(f"skipped: {reason}")
        sys.exit(SKIPPED)
    program = pathlib.Path(sys.argv[1]).resolve()
    with tempfile.TemporaryDirectory() as place:
        jobs, pictures, alone = (pathlib.Path(place) / name for name in ("jobs", "pictures", "alone"))
        for folder in (pictures, alone):
            folder.mkdir()
        run(program, "farm", SCENE, "-o", pictures / "frame.####.exr", *LOOK, "--engine", "slurm", "--folder", jobs)
        with SlurmCluster(pathlib.Path(place) / "slurm", 1, ("fast", "slow")) as cluster:
            with SlowNode("slow"):
                lose_two(program, cluster, jobs, pictures)
            frame_of(pictures, FAILING + 1).rmdir()
            before = {file: file.stat().st_mtime_ns for file in pictures.iterdir()}
            array = submit(cluster, jobs)
            cluster.wait(lambda: is_over(cluster, array), 300, "the rest")
            every, text, code = status(program, jobs)
            check(code == 0 and every["counts"]["done"] == FRAMES, "submitted again, all tasks are done, and the exit code is 0")
            again = [file.name for file in pictures.iterdir() if before.get(file) != file.stat().st_mtime_ns]
            check(sorted(again) == [frame_of(pictures, k + 1).name for k in (KILLED, FAILING)],
                  f"which rendered {' '.join(sorted(again))} alone")
        run(program, "render", SCENE, "-o", alone / "frame.####.exr", *LOOK)
        for k in range(1, FRAMES + 1):
            run("oiiotool", frame_of(pictures, k), frame_of(alone, k), "--fail", "0", "--warn", "0", "--diff")
        print(f"holds: the {FRAMES} frames have the bits of one machine's in all layers")


if __name__ == "__main__":
    main()
