"""What a component says that it can do: `COMMAND --capabilities`."""

import json
import os
import subprocess

from copepod_run.component_settings import component_settings


def announced(command):
    """The component's answer as a dict with `name` and `features`, or None if it says nothing that can be read."""
    try:
        answer = subprocess.run(
            [*command, "--capabilities"],
            env={**component_settings(), **os.environ},
            stdin=subprocess.DEVNULL,
            stdout=subprocess.PIPE,
            stderr=subprocess.DEVNULL,
            text=True,
            timeout=20,
        )
        said, _ = json.JSONDecoder().raw_decode(answer.stdout.lstrip())  # under mpirun every rank may say it
    except (OSError, ValueError, subprocess.TimeoutExpired):
        return None
    return said if isinstance(said, dict) else None


def can(command, feature):
    """Whether a component announces `feature`."""
    return feature in (announced(command) or {}).get("features", [])
