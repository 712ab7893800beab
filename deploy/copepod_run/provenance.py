"""Adds to provenance.json how the run ended when the coupler could not do so itself."""

import datetime
import json
import os
from contextlib import suppress


def record_exit(directory, code, reason):
    """Sets status, exit_code, exit_reason and, if missing, end; does nothing if the coupler wrote no provenance. Never raises."""
    path = directory / "provenance.json"
    try:
        provenance = json.loads(path.read_text())
    except (OSError, ValueError):
        return
    provenance["status"] = "failed"
    provenance["exit_code"] = code
    provenance["exit_reason"] = reason
    if not provenance.get("end"):
        provenance["end"] = datetime.datetime.now(datetime.timezone.utc).isoformat(timespec="seconds")
    _replace(path, json.dumps(provenance, indent=2) + "\n")


def _replace(path, text):
    """In one go; on a full disk in the blocks that the file has. What cannot be written is lost: the run's own failure matters more."""
    fresh = path.with_suffix(".json.new")
    try:
        fresh.write_text(text)
        os.replace(fresh, path)
    except OSError:
        with suppress(OSError):
            fresh.unlink()
        with suppress(OSError):
            _overwrite(path, text.encode())


def _overwrite(path, content):
    """Needs no new block; leaves the file alone if the content does not fit into its blocks."""
    with open(path, "r+b") as file:
        if len(content) <= os.fstat(file.fileno()).st_blocks * 512:
            file.write(content)
            file.truncate()
