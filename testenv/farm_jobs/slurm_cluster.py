"""A Slurm of one machine, for tests: a controller and its nodes in a folder of its own, on free ports."""
import os
import pathlib
import shutil
import signal
import socket
import subprocess
import time

PROGRAMS = ("slurmctld", "slurmd", "sbatch", "sinfo", "squeue", "scontrol", "scancel")
SEARCHED = os.environ["PATH"] + ":/usr/sbin:/sbin"


def missing():
    """Why there can be no cluster here, or nothing."""
    absent = [program for program in PROGRAMS if not shutil.which(program, path=SEARCHED)]
    if absent:
        return f"{', '.join(absent)} not found: apt-get install slurm-wlm"
    return "" if os.geteuid() == 0 else "Slurm's daemons start tasks as their users, so they need to be root"


def free_ports(count):
    held = [socket.socket() for _ in range(count)]
    for one in held:
        one.bind(("127.0.0.1", 0))
    ports = [one.getsockname()[1] for one in held]
    for one in held:
        one.close()
    return ports


class SlurmCluster:
    """Runs from enter to exit. No cgroups, no accounting, no authentication: nothing of the machine is changed. `nodes`: each
    with its own daemon and, where there are several, its own host name; by default one, this machine."""

    def __init__(self, folder, cores, nodes=()):
        self.folder = pathlib.Path(folder)
        self.daemons = []
        for name in ("state", "spool"):
            (self.folder / name).mkdir(parents=True)
        host = socket.gethostname().split(".")[0]
        self.nodes = nodes or (host,)
        controller, *ports = free_ports(1 + len(self.nodes))
        lines = [
            "ClusterName=test", f"SlurmctldHost={host}(127.0.0.1)", f"SlurmctldPort={controller}",
            "SlurmUser=root", "AuthType=auth/none", "CredType=cred/none", "ProctrackType=proctrack/linuxproc",
            "TaskPlugin=task/none", "JobAcctGatherType=jobacct_gather/none", "MpiDefault=none", "ReturnToService=2",
            "SelectType=select/cons_tres", "SelectTypeParameters=CR_Core", "SchedulerParameters=sched_interval=1", "MinJobAge=7200",
            f"StateSaveLocation={self.folder}/state", f"SlurmdSpoolDir={self.folder}/spool/%n",
            f"SlurmctldPidFile={self.folder}/controller.pid", f"SlurmdPidFile={self.folder}/%n.pid",
            f"SlurmctldLogFile={self.folder}/controller.log", f"SlurmdLogFile={self.folder}/%n.log",
            *(f"NodeName={node} NodeHostname={host} NodeAddr=127.0.0.1 Port={port} CPUs={cores} State=UNKNOWN"
              for node, port in zip(self.nodes, ports)),
            "PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP",
        ]
        (self.folder / "slurm.conf").write_text("\n".join(lines) + "\n")
        self.environment = {**os.environ, "PATH": SEARCHED, "SLURM_CONF": str(self.folder / "slurm.conf")}

    def daemon(self, program, *options):
        path = shutil.which(program, path=SEARCHED)
        words = [path, "-D", *options]
        if len(self.nodes) > 1 and options:
            words = ["unshare", "--uts", "sh", "-c", 'hostname "$1"; shift; exec "$@"', "sh", options[-1], *words]
        self.daemons.append(subprocess.Popen(words, env=self.environment, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL))

    def __enter__(self):
        try:
            self.daemon("slurmctld")
            for node in self.nodes:
                self.daemon("slurmd", "-N", node)
            idle = ["idle"] * len(self.nodes)
            self.wait(lambda: self.ask("sinfo", "--noheader", "--Node", "--format=%T").split() == idle, 60, "the nodes to be idle")
        except BaseException:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_):
        if self.daemons:
            subprocess.run(["scancel", "--user=root"], env=self.environment, capture_output=True)
        for daemon in reversed(self.daemons):
            daemon.send_signal(signal.SIGTERM)
            try:
                daemon.wait(20)
            except subprocess.TimeoutExpired:
                daemon.kill()
                daemon.wait()

    def ask(self, *command):
        return subprocess.run(command, env=self.environment, capture_output=True, text=True).stdout.strip()

    def state(self, job):
        """A job's, or that of a task of an array: "12_3"."""
        words = self.ask("scontrol", "show", "job", job).split()
        return next((word[9:] for word in words if word.startswith("JobState=")), "")

    def wait(self, condition, seconds, what):
        end = time.monotonic() + seconds
        while not condition():
            if time.monotonic() > end:
                logs = "".join(log.read_text()[-2000:] for log in self.folder.glob("*.log"))
                raise SystemExit(f"waited {seconds} s for {what}\n{self.ask('squeue')}\n{logs}")
            time.sleep(0.2)
