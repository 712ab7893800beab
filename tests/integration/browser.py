"""Chromium without a window, driven through its DevTools protocol over two pipes: no port, no library."""

import base64
import json
import os
import shutil
import subprocess
import tempfile
import time

CHROMIUM = shutil.which("chromium")
_OPTIONS = (
    "--headless=new --no-sandbox --remote-debugging-pipe --use-angle=swiftshader --enable-unsafe-swiftshader "
    "--no-first-run --disable-extensions --disable-background-networking --disable-dev-shm-usage --hide-scrollbars"
)


class Browser:
    """One page. Use as a context; `problems` collects errors of scripts and requests for anything but the page."""

    def __init__(self, width=1280, height=900, dark=False, little_motion=False, options=()):
        self._folder = tempfile.mkdtemp(prefix="copepod_browser_")
        commands, self._commands = os.pipe()
        self._answers, answers = os.pipe()
        self._process = subprocess.Popen(
            # The descriptors of the protocol are 3 and 4.
            ["bash", "-c", f'exec {CHROMIUM} "$@" 3<&{commands} 4>&{answers}', "chromium", *_OPTIONS.split()]
            + [f"--user-data-dir={self._folder}", *options, "about:blank"],
            pass_fds=(commands, answers),
            stdin=subprocess.DEVNULL,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        os.close(commands)
        os.close(answers)
        self._rest = b""
        self._number = 0
        self._session = None
        self.problems = []
        self.requests = []
        targets = self.call("Target.getTargets")["targetInfos"]
        page = next(target for target in targets if target["type"] == "page")
        attached = self.call("Target.attachToTarget", targetId=page["targetId"], flatten=True)
        self._session = attached["sessionId"]
        for domain in ("Page", "Runtime", "Network", "Log"):
            self.call(f"{domain}.enable")
        self.resize(width, height)
        features = [
            {"name": "prefers-color-scheme", "value": "dark" if dark else "light"},
            {"name": "prefers-reduced-motion", "value": "reduce" if little_motion else "no-preference"},
        ]
        self.call("Emulation.setEmulatedMedia", features=features)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._process.kill()
        self._process.wait()
        os.close(self._commands)
        os.close(self._answers)
        shutil.rmtree(self._folder, ignore_errors=True)

    def call(self, method, **parameters):
        """Result of a command of the protocol."""
        self._number += 1
        message = {"id": self._number, "method": method, "params": parameters}
        if self._session:
            message["sessionId"] = self._session
        os.write(self._commands, json.dumps(message).encode() + b"\0")
        while True:
            answer = self._receive()
            if answer.get("id") == self._number:
                if "error" in answer:
                    raise RuntimeError(f"{method}: {answer['error']}")
                return answer["result"]
            self._note(answer)

    def _receive(self):
        while b"\0" not in self._rest:
            received = os.read(self._answers, 1 << 16)
            if not received:
                raise RuntimeError("chromium has ended")
            self._rest += received
        message, _, self._rest = self._rest.partition(b"\0")
        return json.loads(message)

    def _note(self, event):
        parameters = event.get("params", {})
        if event.get("method") == "Runtime.exceptionThrown":
            details = parameters["exceptionDetails"]
            self.problems.append(details.get("exception", {}).get("description") or details["text"])
        elif event.get("method") == "Log.entryAdded" and parameters["entry"]["level"] == "error":
            self.problems.append(parameters["entry"]["text"])
        elif event.get("method") == "Network.requestWillBeSent":
            self.requests.append(parameters["request"]["url"])

    def resize(self, width, height):
        self.call(
            "Emulation.setDeviceMetricsOverride", width=width, height=height, deviceScaleFactor=1, mobile=width < 600
        )

    def open(self, address):
        self.call("Page.navigate", url=str(address))
        self.wait_for("document.readyState === 'complete'")

    def value(self, expression):
        """Of an expression of JavaScript, once its promise is kept."""
        answer = self.call("Runtime.evaluate", expression=expression, awaitPromise=True, returnByValue=True)
        if "exceptionDetails" in answer:
            raise RuntimeError(answer["exceptionDetails"]["exception"].get("description", expression))
        return answer["result"].get("value")

    def wait_for(self, condition, timeout_s=60):
        """Until an expression of JavaScript is true; returns its value."""
        deadline = time.monotonic() + timeout_s
        while not (value := self.value(condition)):
            if time.monotonic() > deadline:
                raise AssertionError(f"{condition}: not within {timeout_s} s; {self.problems}")
            time.sleep(0.05)
        return value

    def drag(self, x, y, right, down, modifiers=0):
        """With the left button, in pixels of the window; modifiers: 8 for the shift key."""
        steps = [("mousePressed", 0, 0), ("mouseMoved", right / 2, down / 2), ("mouseMoved", right, down)]
        for kind, dx, dy in [*steps, ("mouseReleased", right, down)]:
            place = {"x": x + dx, "y": y + dy, "button": "left", "buttons": 1, "modifiers": modifiers}
            self.call("Input.dispatchMouseEvent", type=kind, clickCount=1, **place)

    def hover(self, x, y):
        self.call("Input.dispatchMouseEvent", type="mouseMoved", x=x, y=y)

    def press(self, key, code=0, text=None):
        """A key, such as «ArrowLeft» or « »."""
        typed = {"text": text or key} if len(key) == 1 else {}
        for kind in ("keyDown", "keyUp"):
            self.call("Input.dispatchKeyEvent", type=kind, key=key, windowsVirtualKeyCode=code, **typed)

    def screenshot(self, path, whole=False):
        answer = self.call("Page.captureScreenshot", format="png", captureBeyondViewport=whole)
        with open(path, "wb") as file:
            file.write(base64.b64decode(answer["data"]))
