"""Environment variables without which a component may not start at all."""

from copepod_run.checkout import program


def component_settings():
    """Where components in Python find the message classes; mpirun may be started by root."""
    return {
        "COPEPOD_BUILD_PYTHON": str(program("coupler").parent.parent / "python"),
        "OMPI_ALLOW_RUN_AS_ROOT": "1",
        "OMPI_ALLOW_RUN_AS_ROOT_CONFIRM": "1",
    }
