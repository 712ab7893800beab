"""What the coupler says on its stdout, and a run on its stderr: one JSON object per line."""

import json


class EventReader:
    """Puts lines together from the bytes of a pipe and parses them."""

    def __init__(self, on_other=lambda line: None):
        """`on_other(line)`: called with the bytes of every line that is no event."""
        self._rest = b""
        self._on_other = on_other

    def feed(self, received):
        """Events (dictionaries) that `received` completes."""
        *lines, self._rest = (self._rest + received).split(b"\n")
        events = []
        for line in lines:
            try:
                event = json.loads(line)
            except ValueError:
                event = None
            if isinstance(event, dict) and "event" in event:
                events.append(event)
            else:
                self._on_other(line)
        return events
