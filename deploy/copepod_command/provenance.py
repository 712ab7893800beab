"""Adds to provenance.json how the run ended when the coupler could not do so itself."""

import datetime
import json
import os


def record_exit(directory, code, reason):
    """Sets status, exit_code, exit_reason and, if missing, end; does nothing if the coupler wrote no provenance."""
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
    fresh = path.with_suffix(".json.new")
    fresh.write_text(json.dumps(provenance, indent=2) + "\n")
    os.replace(fresh, path)
