"""The server of the live page: on loopback only, for requests that name this machine and show a token, with nothing but
the page.
"""

import json
import secrets
import sys
import threading
import time
from functools import partial
from http import HTTPStatus
from http.server import BaseHTTPRequestHandler, ThreadingHTTPServer
from pathlib import Path
from typing import Any
from urllib.parse import parse_qs, unquote, urlsplit

from copepod_report.page import Canvas, page
from copepod_report.report import opening_figures, page_of
from copepod_report.run_record import DAMAGE
from copepod_report.run_status import state_of
from copepod_report.view import scripts
from copepod_run.errors import BadCase, Stop
from copepod_run.messages import say
from copepod_run.plan import plan_of
from copepod_watch.follower import LIVE, CampaignFollower, RunFollower, runs_in

_LOOPBACK = "127.0.0.1"
_OUR_NAMES = (_LOOPBACK, "localhost")  # another name that leads here is that of a page elsewhere (DNS rebinding)
_SCRIPT = f"<script>{Path(__file__).with_name('live.js').read_text()}</script>"
_HEADERS = {
    "Cache-Control": "no-store",
    "Content-Security-Policy": "default-src 'none'; script-src 'unsafe-inline'; style-src 'unsafe-inline'; "
    "img-src data:; connect-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'",
    "Cross-Origin-Resource-Policy": "same-origin",
    "X-Content-Type-Options": "nosniff",
    "Referrer-Policy": "no-referrer",
}


class WatchServer(ThreadingHTTPServer):
    """Serves the page of a run, or of each run of a campaign."""

    daemon_threads = True

    def __init__(self, directory: Path, port: int) -> None:
        """Raises Stop(2) for a bad port."""
        self.directory = directory
        self._campaign = CampaignFollower(directory, partial(opening_figures, canvas=Canvas(None)))
        self._lock = threading.Lock()  # followers and plots work for one request at a time
        self._followers: dict[str, RunFollower] = {}
        self._states: dict[str, str] = {}
        self._next_look = 0.0
        self.root = f"/{secrets.token_urlsafe(16)}/"  # of every path, secret to other users of this machine
        try:
            super().__init__((_LOOPBACK, port), _Handler)
        except (OSError, OverflowError) as problem:
            reason = getattr(problem, "strerror", None) or problem
            raise BadCase(f"port {port} cannot be used ({reason}). Choose another --port.") from None

    @property
    def address(self) -> str:
        return f"http://{_LOOPBACK}:{self.server_address[1]}{self.root}"

    def handle_error(self, request: Any, client_address: Any) -> None:
        """A signal that arrives while a connection is accepted ends the server, too."""
        if isinstance(sys.exception(), Stop):
            raise
        super().handle_error(request, client_address)

    def service_actions(self) -> None:
        """Between requests: announces the end of a run, once."""
        if time.monotonic() < self._next_look:
            return
        self._next_look = time.monotonic() + 1.0
        with self._lock:
            followers = dict(self._followers)
        for name, follower in followers.items():
            state, _ = state_of(follower.directory)
            if self._states.get(name, "running") == "running" and state != "running":
                say(f"{follower.name}: {state}; the page stays until Ctrl-C.")
            self._states[name] = state

    def content_of(self, path: str, known: str) -> tuple[str, str] | None:
        """(type, content) of the root, «state», «report», or of these below «NAME/»; None if there is no such page."""
        if not secrets.compare_digest(path[: len(self.root)].encode(), self.root.encode()):
            return None
        path = path.removeprefix(self.root)
        name, _, last = path.rpartition("/")
        with self._lock:
            runs = runs_in(self.directory)
            if path == "" and "" not in runs:
                section = LIVE.runs(self.directory, self._campaign.content())
                return "text/html", page(f"Copepod: {self.directory.resolve().name}", [section, _SCRIPT])
            if path == "state" and "" not in runs:
                return "application/json", json.dumps(self._campaign.content(known))
            if name not in runs or last not in ("", "state", "report"):
                return None
            follower = self.follower(name)
            if last == "state":
                return "application/json", json.dumps(follower.content(known))
            if last == "report":
                return "text/html", page_of(follower.directory, lambda _: follower.case)
            section = LIVE.live(follower.directory, self.root if name else "")
            return "text/html", page(f"Copepod: {follower.name}", [section, scripts(), _SCRIPT])

    def follower(self, name: str) -> RunFollower:
        """Of a run, from the first time on that it is asked for."""
        if name not in self._followers:
            path = runs_in(self.directory)[name]
            plan = plan_of(path / "case.yaml", asked=["--surfaces"])  # the coupler is the only parser of cases
            case = {**plan.case, "surfaces": plan.surfaces}
            self._followers[name] = RunFollower(path, case, plan.estimate.get("cells", 0))
        return self._followers[name]


class _Handler(BaseHTTPRequestHandler):
    server: WatchServer
    server_version = "copepod"
    sys_version = ""

    def do_GET(self) -> None:
        if (self.headers.get("Host") or "").rsplit(":", 1)[0].lower() not in _OUR_NAMES:
            self._send(HTTPStatus.FORBIDDEN, "text/plain", "Only http://127.0.0.1 and http://localhost lead here.\n")
            return
        place = urlsplit(self.path)
        known = parse_qs(place.query).get("have", [""])[0]
        try:
            found = self.server.content_of(unquote(place.path), known)
        except (Stop, OSError, *DAMAGE) as problem:  # a file that is damaged, or just being replaced
            self._send(HTTPStatus.SERVICE_UNAVAILABLE, "text/plain", f"{problem}\n")
            return
        if found is None:
            text = "There is no such page (use the address that copepod watch printed).\n"
            self._send(HTTPStatus.NOT_FOUND, "text/plain", text)
        else:
            self._send(HTTPStatus.OK, *found)

    def _send(self, status: HTTPStatus, kind: str, text: str) -> None:
        content = text.encode()
        self.send_response(status)
        self.send_header("Content-Type", f"{kind}; charset=utf-8")
        self.send_header("Content-Length", str(len(content)))
        for name, value in _HEADERS.items():
            self.send_header(name, value)
        self.end_headers()
        try:
            self.wfile.write(content)
        except OSError:  # the browser has closed the page
            self.close_connection = True

    def log_message(self, format: str, *arguments: Any) -> None:
        """No line for every request."""
