"""Processes on this machine and on others: a guard on each of those reports what is wrong, and ends what is left."""

import json
import os
import shutil
import signal
import subprocess
import time
from collections.abc import Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from contextlib import suppress
from pathlib import Path
from subprocess import PIPE
from typing import Any

from copepod_run import components, hosts
from copepod_run.checkout import MODULES
from copepod_run.cleanup import remove_folders
from copepod_run.errors import BadCase
from copepod_run.host_guard import GUARD, digest
from copepod_run.launcher import Launcher
from copepod_run.messages import Stage, say
from copepod_run.outcome import Failure, lost
from copepod_run.plan import Plan
from copepod_run.processes import Wrong, family_of, start_child
from copepod_run.progress import Event, EventReader
from copepod_run.scratch import Scratch, fresh_folder

_READY_WITHIN_S = 30.0
_REACHED_WITHIN_S = 4.0  # a guard ends within half a second, or is killed after two
_ENDED_WITHIN_S = 3.5  # asked to, a guard needs half a second, and two more if a process hangs in the kernel
_WORTH_A_LINE_S = 3.0  # of silence
_PASSED_ON = ("OMPI_", "PMIX_MCA_", "UCX_", "OMP_", "COPEPOD_", "LD_LIBRARY_PATH", "PATH", "HDF5_")


class HostConnection:
    """The connection to the guard on another host: what it reports, and whether it still does.

    Ends with this command; the guard then ends everything on that host.
    """

    def __init__(self, host: str, order: Mapping[str, Any]) -> None:
        """Sends the order at once; wait_until_ready() has the answer."""
        self.host = host
        self.wrong: list[Wrong] = []  # what the last answer reported
        self.address = ""  # of this host as seen from there, empty if unknown
        self.left: int | None = None  # processes that could not be ended, once the guard has ended the others
        self.answered = time.monotonic()
        self._asked = self._received = 0
        self._reader = EventReader()  # ignores what a login script prints
        self._is_ready = self.is_closed = False
        command = hosts.connecting_command(host, hosts.guard_command(GUARD, order["mark"]))
        self._popen = start_child(command, signal.SIGKILL, stdin=PIPE, stdout=PIPE, stderr=PIPE)
        self.pid = self._popen.pid
        self._order = {**order, "host": host}
        streams = (self._popen.stdin, self._popen.stdout, self._popen.stderr)
        self._stdin, self._stdout, self._stderr = self._pipes = [stream for stream in streams if stream]
        for pipe in self._pipes:
            os.set_blocking(pipe.fileno(), False)
        self.send(self._order)

    def wait_until_ready(self) -> None:
        """Raises Stop(2) if the host cannot take part."""
        deadline = self.answered + _READY_WITHIN_S
        while not self._is_ready:
            self.read()
            if self.is_closed or time.monotonic() > deadline:
                why = self.why_closed() if self.is_closed else f"no answer within {_READY_WITHIN_S:.0f} s"
                raise BadCase(hosts.not_reached(self.host, why))
            time.sleep(0.01)

    def ask(self) -> None:
        """One question more; answers to earlier ones are read."""
        self.read()
        self._asked += 1
        self.send({"ping": self._asked, "received": self._received})

    @property
    def silent_s(self) -> float:
        """Since the last answer."""
        return time.monotonic() - self.answered

    def may_still_end(self) -> bool:
        """Whether the guard has not reported yet that everything has ended, and is still connected."""
        self.read()
        return self.left is None and not self.is_closed

    def end_stopped_guard(self) -> None:
        """Reaches the host anew to end a guard that does not answer; nothing happens if the host does not either."""
        command = hosts.connecting_command(self.host, hosts.ending_command(GUARD, self._order["mark"]))
        nowhere: Any = dict.fromkeys(("stdin", "stdout", "stderr"), subprocess.DEVNULL)
        with suppress(subprocess.TimeoutExpired):
            subprocess.run(command, **nowhere, start_new_session=True, timeout=_REACHED_WITHIN_S)

    def read(self) -> None:
        """Takes what has arrived."""
        while not self.is_closed:
            try:
                received = os.read(self._stdout.fileno(), 1 << 16)
            except BlockingIOError:
                return
            self.is_closed = not received
            for answer in self._reader.feed(received):
                self._take(answer)

    def why_closed(self) -> str:
        """The last line of ssh, or how it ended."""
        code, written = None, b""
        with suppress(subprocess.TimeoutExpired):
            code = self._popen.wait(timeout=1)
        with suppress(OSError):
            written = self._stderr.read() or b""
        lines = written.decode(errors="replace").strip().splitlines()
        if code is not None and code < 0:
            return f"its connection, process {self.pid}, was killed by signal {-code}"
        return lines[-1].strip().rstrip(".") if lines else f"the connection ended with code {code}"

    def close(self) -> None:
        self._popen.kill()
        self._popen.wait()
        for pipe in self._pipes:
            with suppress(OSError):
                pipe.close()

    def _take(self, answer: Event) -> None:
        self.answered = time.monotonic()
        if answer["event"] == "ready":
            if answer["problem"]:
                raise BadCase(f"host {self.host}: {answer['problem']}")
            if self._order["build"] not in ("", answer["build"]):
                raise BadCase(
                    f"host {self.host}: {self._order['program']} is of another build than here. "
                    "Copy the checkout, or build it there."
                )
            self.address, self._is_ready = answer["address"], True
        elif answer["event"] == "pong":
            self._received = answer["ping"]
            self.wrong = [Wrong(**wrong) for wrong in answer["wrong"]]
        elif answer["event"] == "ended":
            self.left = answer["left"]

    def send(self, words: Mapping[str, Any]) -> None:
        """The order, a question, or {"end": True}, which asks the guard to end everything there."""
        with suppress(OSError):  # full, because nothing has been read for long, or closed: seen where answers are read
            os.write(self._stdin.fileno(), json.dumps(words).encode() + b"\n")


class HostsLauncher(Launcher):
    """mpirun is a child of this command and starts ranks elsewhere through `python3 -m copepod_run.hosts`."""

    def __init__(self, scratch: Scratch, locks: Sequence[int], plan: Plan) -> None:
        self._sign = scratch.run_path / ".alive" / scratch.mark  # a file that exists as long as the run does
        scratch.folders.append(self._sign.parent)
        super().__init__(scratch, locks)
        self.ended_for_s = plan.silence_s  # the news may travel over a network that is cut for a while
        self._plan = plan
        self._connections: list[HostConnection] = []
        self._silent: set[str] = set()  # hosts about which a line has been written

    def connect(self, program: str) -> tuple[dict[str, Path], str]:
        """(key files by role, where the coupler listens), once all other hosts have answered.

        Raises Stop(2) if one cannot take part.
        @param program   of the fluid, which must be at the same path everywhere
        """
        first, planned = hosts.host_of_rank_0(self._plan), self._plan.transport
        keys = self._scratch.keys(planned if first is None else "tcp://", self._plan.roles, is_private=True)
        others = hosts.others(self._plan)
        program = str(Path(shutil.which(program) or program).absolute())
        order = {
            "mark": self._scratch.mark,
            "folders": [str(self._scratch.files), str(self._scratch.shared_memory)],
            "sign": str(self._sign),
            "program": program,
            "build": "" if "fluid" in self._plan.commands else digest(program),
            "silence_s": self._plan.silence_s,
        }
        fresh_folder(self._sign.parent, self._scratch.mark)
        self._sign.touch()
        with Stage(f"connecting to {', '.join(others)}"):
            for host in others:
                files = {str(keys["fluid"]): keys["fluid"].read_text()} if keys and host == first else {}
                self._connections.append(HostConnection(host, {**order, "files": files}))
            for connection in self._connections:
                connection.wait_until_ready()
        if first is None or planned.startswith("tcp://"):
            return keys, self._scratch.endpoint(planned)
        address = next(connection.address for connection in self._connections if connection.host == first)
        return keys, hosts.free_endpoint(address, first)

    def environment(self, environment: Mapping[str, str]) -> dict[str, str]:
        """Of mpirun, so that it starts ranks through us; the same settings go to the other hosts."""
        order_file = self._scratch.files / "order.json"
        settings = {
            "OMPI_MCA_plm": "rsh",
            "OMPI_MCA_ras": "^slurm",
            "OMPI_MCA_plm_rsh_agent": "/usr/bin/python3 -S -P -B -m copepod_run.hosts",
            "OMPI_MCA_plm_rsh_no_tree_spawn": "1",
            "OMPI_MCA_orte_leave_session_attached": "1",
            "OMPI_MCA_orte_default_hostfile": str(self._scratch.files / "hosts"),
            "OMPI_MCA_rmaps_base_mapping_policy": "slot",
            **components.ON_SHARED_CORES,
            hosts.ORDER: str(order_file),
            "PYTHONPATH": os.pathsep.join([str(MODULES), *environment.get("PYTHONPATH", "").split(os.pathsep)]),
        }
        complete = {**environment, **settings}
        passed_on = {name: value for name, value in complete.items() if name.startswith(_PASSED_ON)}
        order = {"mark": self._scratch.mark, "component": "fluid", "cwd": os.getcwd(), "environment": passed_on}
        order_file.write_text(json.dumps(order))
        (self._scratch.files / "hosts").write_text(hosts.hostfile_text(self._plan))
        return complete

    def look(self) -> Failure | None:
        for connection in self._connections:
            connection.ask()
        failure = super().look()
        if self._was_away:
            for connection in self._connections:
                connection.answered = time.monotonic()  # the silence was ours
        return failure or next(self._lost(), None)

    def end_all(self) -> int:
        remove_folders([self._sign.parent])  # which hosts see that cannot be reached
        for connection in self._connections:
            connection.send({"end": True})
        left = super().end_all()
        deadline = time.monotonic() + _ENDED_WITHIN_S
        while time.monotonic() < deadline and any(
            connection.may_still_end() and connection.silent_s < _ENDED_WITHIN_S for connection in self._connections
        ):
            time.sleep(0.02)
        silent = [connection for connection in self._connections if connection.may_still_end()]
        with ThreadPoolExecutor(len(silent) or 1) as pool:
            list(pool.map(HostConnection.end_stopped_guard, silent))
        return left + sum(connection.left or 0 for connection in self._connections)

    def close(self) -> None:
        super().close()
        for connection in self._connections:
            connection.close()

    def _wrong(self) -> Iterator[Wrong]:
        yield from super()._wrong()
        pids = [pid for connection in self._connections for pid in family_of(connection.pid)]
        yield from self._looker.wrong(pids, fluid_lives=False)
        fluid_lives = self._fluid_lives()
        for connection in self._connections:
            yield from (wrong for wrong in connection.wrong if fluid_lives or wrong.what != "ended")

    def _lost(self) -> Iterator[Failure]:
        """Hosts whose guard has gone or answers no more."""
        for connection in self._connections:
            host = connection.host
            if connection.is_closed:
                yield lost("guard", host, "", f"the connection to host {host} broke: {connection.why_closed()}.")
            elif connection.silent_s > self._plan.silence_s:
                how = f"for {connection.silent_s:.0f} s; network or host"
                yield lost("guard", host, "", f"host {host} does not answer ({how}).")
            elif connection.silent_s > _WORTH_A_LINE_S and host not in self._silent:
                self._silent.add(host)
                say(f"host {host} does not answer; waiting for it, up to {self._plan.silence_s:g} s")
            elif connection.silent_s < 1.0 and host in self._silent:
                self._silent.remove(host)
                say(f"host {host} answers again")
