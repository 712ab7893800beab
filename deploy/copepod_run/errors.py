"""The one exception that ends the command with a message of ours."""


class Stop(Exception):
    """Ends the command: exit code and, if there is one, the last line on stderr («problem (why). What to do.»)."""

    def __init__(self, code, message=""):
        super().__init__(message)
        self.code = code
        self.message = message
