"""What mpirun starts instead of ssh for every other host (plm_rsh_agent): a guard there that carries out the command.

    python3 -m copepod_run.host_agent HOST WORDS…     COPEPOD_HOSTS: a private file with the order for the guards
"""

import json
import os
import signal
import subprocess
import sys
from contextlib import suppress
from pathlib import Path

from copepod_run import hosts
from copepod_run.host_guard import STARTER
from copepod_run.processes import start_child

ORDER = "COPEPOD_HOSTS"


def main(host: str, words: list[str]) -> int:
    order = json.loads(Path(os.environ[ORDER]).read_text())
    command = hosts.connecting_command(host, hosts.guard_command(STARTER, order["mark"]))
    process = start_child(command, signal.SIGKILL, stdin=subprocess.PIPE)
    assert process.stdin is not None
    with suppress(OSError):  # seen below
        process.stdin.write(json.dumps({**order, "host": host, "command": " ".join(words)}).encode() + b"\n")
        process.stdin.flush()
    code = process.wait()
    if code < 0 or code == 255:
        how = f"was killed by signal {-code}" if code < 0 else "ended with code 255"
        print(f"copepod: host {host}: its connection, process {process.pid}, {how}.", file=sys.stderr, flush=True)
    return code if code >= 0 else 128 - code


if __name__ == "__main__":
    sys.exit(main(sys.argv[1], sys.argv[2:]))
