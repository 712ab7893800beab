"""What the coupler says on its stdout: one JSON object per line."""

import json


class EventReader:
    """Puts lines together from the bytes of a pipe and parses them."""

    def __init__(self):
        self._rest = b""

    def feed(self, received):
        """Events (dictionaries) that `received` completes; lines that are no events are dropped."""
        *lines, self._rest = (self._rest + received).split(b"\n")
        events = []
        for line in lines:
            try:
                event = json.loads(line)
            except ValueError:
                continue
            if isinstance(event, dict) and "event" in event:
                events.append(event)
        return events
