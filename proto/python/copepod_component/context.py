"""What the solver's thread and the control lane share."""

from .messages import control


class SolverContext:
    """Given to `make_solver`. A solver uses the three methods; the attributes belong to the kit."""

    def __init__(self):
        self.step = -1
        self.phase = control.PHASE_HANDSHAKE
        self.progress = 0
        self.awaited_rank = 0
        self.received_sequence = 0
        self.replied_sequence = 0
        self.stop_code = 0  # set by the control lane

    def report_progress(self):
        """Shows that a long computation advances; call it in one that may exceed `services.progress_deadline_s`.

        The coupler reports a component as hanging once its step, phase and progress have all stood still for so long.
        """
        self.progress += 1

    def stop_requested(self):
        """The exit code to end with once the coupler is gone or has aborted the run; 0 before.

        A solver in a long loop may check it and raise; a process that has not ended 2 s later is ended.
        """
        return self.stop_code

    def await_rank(self, rank):
        """Names the process of a parallel solver that the others wait for, in case it hangs; 0: none."""
        self.awaited_rank = rank
