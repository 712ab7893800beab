"""A Slurm cluster on one machine: the three hosts are its nodes, and the first one also has the controller."""

import json
import os
import re
import shlex
import shutil
import signal
import subprocess
from pathlib import Path

import three_hosts
from hurt_hosts import HALT_AT
from hurt_run import CASE, PROGRAMS, ROOT, wait_for
from three_hosts import NAMES, Hosts

from copepod_run.processes import state_of

SCRIPT = ROOT / "deploy/slurm/copepod.sbatch"
PATIENCE_S = 60  # for what Slurm does within seconds; it looks for time limits every 30 s
_PAUSE_S = 0.1  # between two commands of Slurm
RANKS = 2
STEPS = 60
SILENCE_S = 5
_CORES = 4  # of every node, whatever this machine has
_CONFIGURATION = f"""
ClusterName=copepod
SlurmctldHost=a
SlurmUser=root
AuthType=auth/munge
AuthInfo=socket=/tmp/munge/socket,cred_expire=5
ProctrackType=proctrack/linuxproc
TaskPlugin=task/none
MpiDefault=none
SelectType=select/cons_tres
SelectTypeParameters=CR_Core
SlurmdParameters=config_overrides
ReturnToService=2
SchedulerParameters=batch_sched_delay=0,sched_interval=1
StateSaveLocation=/tmp/slurmctld
SlurmdSpoolDir=/tmp/slurmd
SlurmctldPidFile=/tmp/slurmctld.pid
SlurmdPidFile=/tmp/slurmd.pid
SlurmctldLogFile={{folder}}/slurmctld.log
SlurmdLogFile={{folder}}/slurmd_%n.log
SlurmdDebug=verbose
NodeName=a CPUs={_CORES} Weight=2
NodeName=b,c CPUs={_CORES} Weight=1
PartitionName=all Nodes=ALL Default=YES MaxTime=INFINITE State=UP
"""  # cred_expire is also the time before a job starts again; a is used only if b and c are not there


def settings(steps):
    """Arguments of `copepod run`."""
    changes = (f"run.steps={steps}", "output.checkpoint.every_steps=20", f"services.silence_s={SILENCE_S}")
    return [word for change in changes for word in ("--set", change)]


def missing():
    """Why there cannot be a cluster here; empty if there can."""
    for program in ("munged", "slurmctld", "slurmd", "sbatch", "srun"):
        if not shutil.which(program):
            return f"{program} is missing"
    return three_hosts.missing()


class SlurmHosts(Hosts):
    """The nodes have no sshd: a job reaches the others by srun alone."""

    _DAEMONS = ("munged ", "slurmctld ", ": slurmscriptd", "slurmd ")

    def slurm(self, *words, before=()):
        """What a command of Slurm prints on the host of the controller."""
        variables = {**os.environ, "SLURM_CONF": str(self._folder / "slurm.conf")}
        command = self.command("a", *before, *words)
        done = subprocess.run(command, env=variables, stdin=subprocess.DEVNULL, capture_output=True, text=True)
        if done.returncode:
            raise AssertionError(f"{' '.join(map(str, words))}: {done.stderr}")
        return done.stdout

    def crash(self, name):
        """A host loses its power, which Slurm has not noticed yet."""
        os.kill(self._init.pop(name), signal.SIGKILL)
        self._boots.pop(name).wait()

    def set_down(self, name):
        self.slurm("scontrol", "update", f"nodename={name}", "state=down", "reason=test")

    def restart(self, name):
        self._boot(name)
        self._wait_until_up()

    def log(self, name):
        """Of slurmd on a host."""
        return (self._folder / f"slurmd_{name}.log").read_text()

    def _prepare(self):
        (self._folder / "slurm.conf").write_text(_CONFIGURATION.format(folder=self._folder))
        (self._folder / "cgroup.conf").write_text("CgroupPlugin=cgroup/v1\n")  # which is not used, but looked for
        key = self._folder / "munge.key"
        key.write_bytes(os.urandom(128))
        key.chmod(0o600)

    def _daemons(self, name):
        """They serve, or soon will, when their commands return."""
        folder, socket = self._folder, "/tmp/munge/socket --pid-file /tmp/munge/pid --seed-file /tmp/munge/seed"
        munge = f"munged --key-file {folder}/munge.key --log-file {folder}/munged_{name}.log --socket {socket}; "
        controller = f"slurmctld -f {folder}/slurm.conf; " if name == "a" else ""
        return f"mkdir -m 755 /tmp/munge; {munge}{controller}slurmd -f {folder}/slurm.conf -N {name}; "

    def _wait_until_up(self):
        if not wait_for(self._are_idle, PATIENCE_S, _PAUSE_S):
            logs = "".join(path.read_text() for path in self._folder.glob("*.log"))
            raise AssertionError(f"the nodes are not ready:\n{logs}")

    def _are_idle(self):
        try:
            return self.slurm("sinfo", "--noheader", "--Node", "--format=%t").split() == ["idle"] * len(NAMES)
        except AssertionError:  # the controller does not answer yet
            return False


class Job:
    """A run that stands still in its first step from HALT_AT on, each time that it is started."""

    def __init__(self, hosts, folder, nodes, halt=("exchange", HALT_AT), steps=STEPS, options=(), programs=""):
        """`programs`: a folder whose programs the job finds before others."""
        self.hosts, self.folder = hosts, Path(folder)
        self.steps = steps
        self.folder.mkdir()
        self._halted = self.folder / "halted"
        place, step = halt
        words = [PROGRAMS / "halting_fluid", "--halt-in", place, "--halt-at-step", step, "--halt-file", self._halted]
        fluid = shlex.join(map(str, words))
        before = ["env", "-C", folder, f"COPEPOD={ROOT}/deploy/copepod", f"COPEPOD_BIN_DIR={PROGRAMS}"]
        before += [f"PATH={programs}:{os.environ['PATH']}"] if programs else []
        cores = f"--cpus-per-task={RANKS // nodes}"
        run = [SCRIPT, CASE, *settings(steps), "--fluid", fluid]
        command = ["sbatch", "--parsable", f"--nodes={nodes}", cores, *options, *run]
        self.number = hosts.slurm(*command, before=before).strip()

    @property
    def record(self):
        """Of Slurm: {"JobState": "RUNNING", …}"""
        return dict(re.findall(r"(\S+?)=(\S*)", self.hosts.slurm("scontrol", "--oneliner", "show", "job", self.number)))

    @property
    def log(self):
        path = self.folder / f"copepod-{self.number}.log"
        return path.read_text() if path.exists() else ""

    @property
    def summary(self):
        return json.loads((self.folder / f"runs/job-{self.number}/summary.json").read_text())

    def control(self, verb):
        """scontrol suspend, resume or requeue"""
        self.hosts.slurm("scontrol", verb, self.number)

    def cancel(self):
        self.hosts.slurm("scancel", self.number)

    def set_time_limit(self, minutes):
        self.hosts.slurm("scontrol", "update", f"jobid={self.number}", f"timelimit={minutes}")

    def wait_until_halted(self, restarts=0):
        self.wait_for(JobState="RUNNING", Restarts=str(restarts))
        if not wait_for(self._halted.exists, PATIENCE_S):
            raise AssertionError(f"the step was never reached:\n{self.log}")

    def let_go(self):
        self._halted.unlink()

    def wait_for(self, **values):
        """Until the record of the job has these values."""
        if not wait_for(lambda: values.items() <= self.record.items(), PATIENCE_S, _PAUSE_S):
            raise AssertionError(f"without {values}: {self.record}\n{self.log}")

    def processes(self, host):
        """{process: environment} of the job on a host."""
        found = self.hosts.processes(host)
        return {pid: variables for pid, variables in found.items() if variables.get("SLURM_JOB_ID") == self.number}

    def states(self, host):
        """Of its processes, as letters of ps."""
        return {state_of(pid) for pid in self.processes(host)}

    def ranks(self, host):
        """Of the fluid."""
        numbers = (variables.get("OMPI_COMM_WORLD_RANK") for variables in self.processes(host).values())
        return {int(number) for number in numbers if number}
