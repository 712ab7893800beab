"""A copy of the programs in the campaign's folder, so that a build in the middle of it changes nothing."""

import os
import shutil
import tempfile
from dataclasses import dataclass
from pathlib import Path

from copepod_run import cleanup
from copepod_run.checkout import build_digest, present_programs, program
from copepod_run.destinations import make_folder


@dataclass(frozen=True)
class Programs:
    """Where the copies are, and the digest that identifies them."""

    folder: Path
    build: str

    def environment(self) -> dict[str, str]:
        """Settings that make `copepod run` use the copies, and share the machine with its like.

        Several mpirun at once would each bind their first rank to the same core.
        """
        return {
            "OMPI_MCA_hwloc_base_binding_policy": "none",
            "OMPI_MCA_mpi_yield_when_idle": "1",
            **os.environ,
            "COPEPOD_BIN_DIR": str(self.folder),
        }


def keep_copy(campaign_folder: Path) -> Programs:
    """Copies the present programs; copies of other builds are removed, because this one continues their runs."""
    source = program("coupler").parent
    build = build_digest()
    shelf = campaign_folder / "programs"
    target = shelf / build
    if not target.exists():
        make_folder(shelf)
        cleanup.remove_folders(shelf.iterdir())
        fresh = Path(tempfile.mkdtemp(prefix="new-", dir=shelf))
        cleanup.claim(fresh, build)
        for name in present_programs():
            shutil.copy2(source / name, fresh / name)
        fresh.rename(target)
    return Programs(target.absolute(), build)
