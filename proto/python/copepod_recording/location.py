"""Where the recordings of a run are."""

from pathlib import Path

from copepod_run.errors import ExitCode, Stop


def wire_file(run_directory, attempt=None):
    """The recording of an attempt, the newest if not given. Raises Stop(2)."""
    return _chosen(Path(run_directory) / "wire", "*.rec", attempt, "wire")


def trace_folder(run_directory, attempt=None):
    """Folder with one file per process. Raises Stop(2)."""
    return _chosen(Path(run_directory) / "trace", "attempt_*", attempt, "trace")


def _chosen(folder, pattern, attempt, key):
    found = sorted(folder.glob(pattern))
    if attempt is not None:
        found = [path for path in found if path.stem == f"attempt_{attempt:03d}"]
    if not found:
        raise Stop(
            ExitCode.BAD_CASE,
            f"{folder} holds no recording{f' of attempt {attempt}' if attempt else ''} (the run was not recorded). "
            f"Run the case with --set output.{key}=true.",
        )
    return found[-1]
