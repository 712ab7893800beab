"""Processes on this machine and on others: a guard on each of those reports what is wrong, and ends what is left."""

import json
import os
import shutil
import time
from collections.abc import Callable, Iterator, Mapping, Sequence
from concurrent.futures import ThreadPoolExecutor
from pathlib import Path

from copepod_run import hosts
from copepod_run.cleanup import remove_folders
from copepod_run.host_agent import ORDER
from copepod_run.host_connection import HostConnection
from copepod_run.host_guard import digest
from copepod_run.launcher import Launcher, Trouble
from copepod_run.messages import Stage, say
from copepod_run.plan import Plan
from copepod_run.processes import Wrong, family_of
from copepod_run.scratch import Scratch, fresh_folder

_ENDED_WITHIN_S = 3.5  # asked to, a guard needs half a second, and two more if a process hangs in the kernel
_WORTH_A_LINE_S = 3.0  # of silence
_PASSED_ON = ("OMPI_", "PMIX_MCA_", "UCX_", "OMP_", "COPEPOD_", "LD_LIBRARY_PATH", "PATH", "HDF5_")


class HostsLauncher(Launcher):
    """mpirun is a child of this command and starts ranks elsewhere through host_agent.py."""

    def __init__(
        self,
        mark: str,
        scratch: Scratch,
        locks: Sequence[int],
        plan: Plan,
        clock: Callable[[], float] = time.monotonic,
    ) -> None:
        self._sign = scratch.run_path / ".alive" / mark  # a file that exists as long as the run does
        super().__init__(mark, [*scratch.folders, self._sign.parent], locks, clock)
        self.ended_for_s = plan.silence_s  # the news may travel over a network that is cut for a while
        self._plan = plan
        self._scratch = scratch
        self._connections: list[HostConnection] = []
        self._silent: set[str] = set()  # hosts about which a line has been written

    def connect(self, program: str) -> tuple[dict[str, Path], str]:
        """(key files by role, where the coupler listens), once all other hosts have answered.

        Raises Stop(2) if one cannot take part.
        @param program   of the fluid, which must be at the same path everywhere
        """
        first, planned = hosts.host_of_rank_0(self._plan), self._plan.transport
        keys = self._scratch.keys(planned if first is None else "tcp://", is_private=True)
        others = hosts.others(self._plan)
        program = str(Path(shutil.which(program) or program).absolute())
        order = {
            "mark": self._mark,
            "folders": [str(self._scratch.mpi_files), str(self._scratch.shared_memory)],
            "sign": str(self._sign),
            "program": program,
            "build": "" if self._plan.fluid_command else digest(program),
            "silence_s": self._plan.silence_s,
        }
        fresh_folder(self._sign.parent, self._mark)
        self._sign.touch()
        with Stage(f"connecting to {', '.join(host.name for host in others)}"):
            for host in others:
                files = {str(keys["fluid"]): keys["fluid"].read_text()} if keys and host == first else {}
                self._connections.append(HostConnection(host.name, self._mark, {**order, "files": files}))
            for connection in self._connections:
                connection.wait_until_ready()
        if first is None or planned.startswith("tcp://"):
            return keys, self._scratch.endpoint(planned)
        address = next(connection.address for connection in self._connections if connection.host == first.name)
        return keys, hosts.free_endpoint(address, first.name)

    def environment(self, environment: Mapping[str, str]) -> dict[str, str]:
        """Of mpirun, so that it starts ranks through us; the same settings go to the other hosts."""
        folder = Path(__file__).resolve().parent.parent
        order_file = self._scratch.mpi_files / "order.json"
        settings = {
            "OMPI_MCA_plm": "rsh",
            "OMPI_MCA_ras": "^slurm",
            "OMPI_MCA_plm_rsh_agent": "/usr/bin/python3 -S -P -B -m copepod_run.host_agent",
            "OMPI_MCA_plm_rsh_no_tree_spawn": "1",
            "OMPI_MCA_orte_leave_session_attached": "1",
            "OMPI_MCA_orte_default_hostfile": str(self._scratch.mpi_files / "hosts"),
            "OMPI_MCA_rmaps_base_mapping_policy": "slot",
            "OMPI_MCA_hwloc_base_binding_policy": "none",
            "OMPI_MCA_mpi_yield_when_idle": "1",
            ORDER: str(order_file),
            "PYTHONPATH": os.pathsep.join([str(folder), *environment.get("PYTHONPATH", "").split(os.pathsep)]),
        }
        complete = {**environment, **settings}
        passed_on = {name: value for name, value in complete.items() if name.startswith(_PASSED_ON)}
        order = {
            "mark": self._mark,
            "component": "fluid",
            "cwd": os.getcwd(),
            "environment": passed_on,
        }
        order_file.write_text(json.dumps(order))
        (self._scratch.mpi_files / "hosts").write_text(hosts.hostfile_text(self._plan))
        return complete

    def look(self) -> Trouble | None:
        for connection in self._connections:
            connection.ask()
        return super().look() or next(self._lost(), None)

    def end_all(self) -> int:
        remove_folders([self._sign.parent])  # which hosts see that cannot be reached
        for connection in self._connections:
            connection.end()
        left = super().end_all()
        deadline = time.monotonic() + _ENDED_WITHIN_S
        while time.monotonic() < deadline and any(self._may_still_end(connection) for connection in self._connections):
            time.sleep(0.02)
        silent = [
            connection for connection in self._connections if connection.left is None and not connection.is_closed
        ]
        with ThreadPoolExecutor(len(silent) or 1) as pool:
            list(pool.map(HostConnection.end_stopped_guard, silent))
        return left + sum(connection.left or 0 for connection in self._connections)

    def close(self) -> None:
        super().close()
        for connection in self._connections:
            connection.close()

    def _forgive(self) -> None:
        for connection in self._connections:
            connection.forgive()

    def _wrong(self) -> Iterator[Wrong]:
        yield from super()._wrong()
        yield from self._looker.wrong(
            [pid for connection in self._connections for pid in family_of(connection.pid)], fluid_lives=False
        )
        fluid_lives = self._fluid_lives()
        for connection in self._connections:
            yield from (wrong for wrong in connection.wrong if fluid_lives or wrong.what != "ended")

    def _lost(self) -> Iterator[Trouble]:
        """Hosts whose guard has gone or answers no more."""
        for connection in self._connections:
            host = connection.host
            if connection.is_closed:
                yield Trouble("guard", host, "", f"the connection to host {host} broke: {connection.why_closed()}.")
            elif connection.silent_s > self._plan.silence_s:
                yield Trouble(
                    "guard",
                    host,
                    "",
                    f"host {host} does not answer (for {connection.silent_s:.0f} s; network or host).",
                )
            elif connection.silent_s > _WORTH_A_LINE_S and host not in self._silent:
                self._silent.add(host)
                say(f"host {host} does not answer; waiting for it, up to {self._plan.silence_s:g} s")
            elif connection.silent_s < 1.0 and host in self._silent:
                self._silent.remove(host)
                say(f"host {host} answers again")

    @staticmethod
    def _may_still_end(connection: HostConnection) -> bool:
        connection.read()
        return connection.left is None and not connection.is_closed and connection.silent_s < _ENDED_WITHIN_S
