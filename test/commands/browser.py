"""Headless Chromium, told by its own protocol over a pipe: opens a page, runs scripts, sends keys, mouse and fingers, takes pictures."""
import base64
import contextlib
import json
import os
import shutil
import signal
import subprocess
import tempfile
import time

PATIENCE = 60  # for an answer, on a busy machine [s]


class Browser:
    """`with Browser(width, height) as page`. `arguments`: of chromium; `requests`: addresses that pages asked for."""

    def __init__(self, width, height, *arguments, scale=1, touch=False):
        self.size, self.scale, self.touch = (width, height), scale, touch
        self.arguments = ["--headless=new", "--no-sandbox", "--disable-dev-shm-usage", "--disable-background-networking", "--no-first-run",
                          "--disable-extensions", "--disable-component-update", "--use-angle=swiftshader", "--enable-unsafe-swiftshader",
                          "--hide-scrollbars", "--disable-renderer-backgrounding", "--disable-backgrounding-occluded-windows",
                          "--disable-background-timer-throttling", f"--window-size={width},{height}", *arguments]
        self.requests, self.errors, self._number = [], [], 0

    def __enter__(self):
        self.folder = tempfile.mkdtemp(prefix="haptic_browser_")
        down_read, down_write = os.pipe()
        up_read, up_write = os.pipe()

        def place():
            os.dup2(down_read, 3)
            os.dup2(up_write, 4)

        # The ends are 3 and 4 in the child: moved there from above them, lest one overwrites the other.
        import fcntl
        down_read, up_write = (fcntl.fcntl(end, fcntl.F_DUPFD, 10) for end in (down_read, up_write))
        self.process = subprocess.Popen(["chromium", *self.arguments, "--remote-debugging-pipe", "--user-data-dir=" + self.folder, "about:blank"],
                                        stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL, close_fds=False,
                                        preexec_fn=place, start_new_session=True)
        os.close(down_read)
        os.close(up_write)
        self._out, self._in, self._rest, self.session = down_write, up_read, b"", None
        os.set_blocking(self._in, False)
        target = self.call("Target.getTargets")["targetInfos"]
        page = next(info["targetId"] for info in target if info["type"] == "page")
        self.session = self.call("Target.attachToTarget", targetId=page, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "Network", "Performance"):
            self.call(domain + ".enable")
        self.call("Emulation.setDeviceMetricsOverride", width=self.size[0], height=self.size[1], deviceScaleFactor=self.scale, mobile=self.touch)
        if self.touch:
            self.call("Emulation.setTouchEmulationEnabled", enabled=True)
        return self

    def __exit__(self, *_):
        with contextlib.suppress(ProcessLookupError):
            os.killpg(self.process.pid, signal.SIGKILL)
        self.process.wait()
        os.close(self._out)
        os.close(self._in)
        shutil.rmtree(self.folder, ignore_errors=True)

    def call(self, method, **parameters):
        self._number += 1
        message = {"id": self._number, "method": method, "params": parameters}
        if self.session:
            message["sessionId"] = self.session
        os.write(self._out, json.dumps(message).encode() + b"\0")
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            for answer in self._messages():
                if answer.get("id") == self._number:
                    if "error" in answer:
                        raise RuntimeError(f"{method}: {answer['error']['message']}")
                    return answer["result"]
        raise RuntimeError(f"{method}: no answer within {PATIENCE} s")

    def _messages(self):
        try:
            read = os.read(self._in, 1 << 20)
        except BlockingIOError:
            time.sleep(0.002)
            return
        *whole, self._rest = (self._rest + read).split(b"\0")
        for raw in whole:
            message = json.loads(raw)
            if message.get("method") == "Network.requestWillBeSent":
                self.requests.append(message["params"]["request"]["url"])
            if message.get("method") == "Runtime.exceptionThrown":
                details = message["params"]["exceptionDetails"]
                self.errors.append(details.get("exception", {}).get("description") or details["text"])
            yield message

    def open(self, path):
        self.call("Page.navigate", url="file://" + path)

    def run(self, script):
        """Value of an expression, awaited."""
        done = self.call("Runtime.evaluate", expression=script, awaitPromise=True, returnByValue=True)
        if "exceptionDetails" in done:
            raise RuntimeError(done["exceptionDetails"].get("exception", {}).get("description", script))
        return done["result"].get("value")

    def wait(self, condition):
        """Until an expression is true; its value."""
        end = time.monotonic() + PATIENCE
        while time.monotonic() < end:
            value = self.run(condition)
            if value:
                return value
            time.sleep(0.02)
        raise RuntimeError(f"{condition} did not come true within {PATIENCE} s; errors: {self.errors}")

    def key(self, key, modifiers=0):
        text = {"text": key} if len(key) == 1 else {}
        self.call("Input.dispatchKeyEvent", type="keyDown", key=key, modifiers=modifiers, **text)
        self.call("Input.dispatchKeyEvent", type="keyUp", key=key, modifiers=modifiers)

    def choose(self, identity, path):
        """A file, in an input of that id."""
        found = self.call("Runtime.evaluate", expression=f"document.getElementById('{identity}')")["result"]["objectId"]
        self.call("DOM.setFileInputFiles", files=[path], objectId=found)

    def drag(self, *points):
        for index, (x, y) in enumerate(points):
            kind = "mousePressed" if index == 0 else "mouseMoved"
            self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, button="left", buttons=1, clickCount=1)
        self.call("Input.dispatchMouseEvent", type="mouseReleased", x=points[-1][0], y=points[-1][1], button="left", clickCount=1)

    def fingers(self, *steps):
        """Each step: the places of all fingers."""
        for index, step in enumerate(steps):
            self.call("Input.dispatchTouchEvent", type="touchStart" if index == 0 else "touchMove", touchPoints=[{"x": x, "y": y, "id": i} for i, (x, y) in enumerate(step)])
        self.call("Input.dispatchTouchEvent", type="touchEnd", touchPoints=[])

    def picture(self, path=None, whole=False):
        """PNG bytes of the window or the whole page; kept at `path` as well."""
        raw = base64.b64decode(self.call("Page.captureScreenshot", format="png", captureBeyondViewport=whole)["data"])
        if path:
            with open(path, "wb") as file:
                file.write(raw)
        return raw

    def processor_seconds(self):
        """CPU time of all processes of this browser so far [s]."""
        ticks = 0
        for pid in filter(str.isdigit, os.listdir("/proc")):
            with contextlib.suppress(OSError, IndexError, ValueError):
                with open(f"/proc/{pid}/stat", encoding="utf-8") as file:
                    fields = file.read().rsplit(")", 1)[1].split()
                if int(fields[3]) == self.process.pid:  # its session
                    ticks += int(fields[11]) + int(fields[12])
        return ticks / os.sysconf("SC_CLK_TCK")
