"""The fluid alone, and the memory it runs at, by the program fluid_benchmark."""

import json
import os
import statistics
import subprocess

from copepod_run.checkout import program
from copepod_run.errors import ExitCode, Stop

_OPEN_MPI = {
    "OMPI_ALLOW_RUN_AS_ROOT": "1",
    "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
    "OMPI_MCA_hwloc_base_binding_policy": "none",
}


def measure(domain, ranks, precision="double", collision="bgk", samples=5, steps=20):
    """One configuration: the samples as printed, with medians and the share of the limit.

    The limit is the rate of 19 streams updated in place; each sample's share compares it with the fluid
    of the same moment.
    """
    command = [
        "mpirun",
        "-n",
        str(ranks),
        "--oversubscribe",
        str(program("fluid_benchmark")),
        "--domain",
        *map(str, domain),
        "--samples",
        str(samples),
        "--steps",
        str(steps),
    ]
    command += ["--single"] if precision == "single" else []
    command += ["--trt"] if collision == "trt" else []
    done = subprocess.run(command, capture_output=True, text=True, env={**_OPEN_MPI, **os.environ})
    if done.returncode != 0:
        raise Stop(
            ExitCode.SOLVER_FAILED,
            f"{' '.join(command)} failed ({done.stderr.strip()[-500:]}). " "Check that mpirun works on this machine.",
        )
    result = json.loads(done.stdout)
    shares = [fluid / limit for fluid, limit in zip(result["fluid_mlups"], result["streams_mcells_per_s"])]
    return {
        **result,
        "median_fluid_mlups": statistics.median(result["fluid_mlups"]),
        "median_streams_mcells_per_s": statistics.median(result["streams_mcells_per_s"]),
        "median_copy_gb_per_s": statistics.median(result["copy_gb_per_s"]),
        "median_share_of_limit": statistics.median(shares),
    }
