"""What the solver's thread lets the control lane know, and the other way round; one component per process."""

from .schema import control


class Vitals:
    def __init__(self):
        self.step = -1
        self.phase = control.PHASE_GREETING
        self.progress = 0
        self.received_sequence = 0
        self.replied_sequence = 0
        self.stop_code = 0  # set by the control lane


VITALS = Vitals()


def report_progress():
    """Shows that the computation moves on; for a setup, step or checkpoint that may take longer than `progress_deadline_s`.

    The coupler takes a component whose step, phase and progress all stand still for so long for hung.
    """
    VITALS.progress += 1


def stop_request():
    """Non-zero when the coupler is gone or has aborted the run: the exit code to end with.

    A solver in a long loop may look at it and raise; a process that does not end within 2 s is ended.
    """
    return VITALS.stop_code
