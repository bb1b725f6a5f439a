"""A headless Chromium that the tests drive over its DevTools pipe, where the machine has one."""

import base64
import fcntl
import itertools
import json
import os
from pathlib import Path
import select
import shutil
import subprocess

_NAMES = ("chromium-headless-shell", "chromium", "chromium-browser", "google-chrome", "chrome")
# The page's clock in the tests' hand: pictures come when they are asked for, at the given time.
CLOCK = """
const waiting = [];
window.requestAnimationFrame = callback => waiting.push(callback);
window.picture = milliseconds => waiting.splice(0).forEach(callback => callback(milliseconds));
"""


def find():
    """The program of a Chromium, REFIMPL_CHROMIUM or one that is installed, or None."""
    own = os.environ.get("REFIMPL_CHROMIUM")
    cached = sorted(Path.home().glob(".cache/ms-playwright/chromium*/chrome-linux*/*"))
    return next((path for path in [own, *map(shutil.which, _NAMES), *map(str, cached)]
                 if path and os.access(path, os.X_OK) and Path(path).is_file()
                 and (path == own or "chrom" in Path(path).name or "headless" in path)), None)


class Browser:
    """One page in one browser; a context manager."""

    def __init__(self, folder):
        near, self._write = os.pipe()
        self._read, far = os.pipe()
        to_it, from_it = (fcntl.fcntl(end, fcntl.F_DUPFD, 10) for end in (near, far))
        os.close(near), os.close(far)                            # 3 and 4 must be free

        self._process = subprocess.Popen(
            ["bash", "-c", f'exec "$0" "$@" 3<&{to_it} 4>&{from_it}',    # as it wants
             find(), "--headless", "--no-sandbox", "--disable-gpu", "--remote-debugging-pipe",
             "--hide-scrollbars", f"--user-data-dir={folder}", "about:blank"],
            pass_fds=(to_it, from_it), stdin=subprocess.DEVNULL, stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL)
        os.close(to_it), os.close(from_it)
        self._ids, self._rest, self._session = itertools.count(1), b"", None
        target = next(one for one in self.call("Target.getTargets")["targetInfos"]
                      if one["type"] == "page")["targetId"]
        self._session = self.call("Target.attachToTarget", targetId=target,
                                  flatten=True)["sessionId"]
        self.requests, self.errors = [], []
        for domain in ("Page", "Runtime", "Network"):
            self.call(f"{domain}.enable")

    def call(self, method, **params):
        """One DevTools command and its result."""
        number = next(self._ids)
        message = {"id": number, "method": method, "params": params}
        if self._session:
            message["sessionId"] = self._session
        os.write(self._write, json.dumps(message).encode() + b"\0")
        while True:
            answer = self._message()
            if answer.get("method") == "Runtime.exceptionThrown":
                self.errors.append(answer["params"]["exceptionDetails"])
            if answer.get("method") == "Network.requestWillBeSent":
                self.requests.append(answer["params"]["request"]["url"])
            if answer.get("id") == number:
                assert "error" not in answer, answer["error"]
                return answer["result"]

    def _message(self):
        while b"\0" not in self._rest:
            assert select.select([self._read], [], [], 120)[0], "the browser does not answer"
            data = os.read(self._read, 1 << 20)
            assert data, "the browser has gone"
            self._rest += data
        one, _, self._rest = self._rest.partition(b"\0")
        return json.loads(one)

    def evaluate(self, expression):
        """The value of an expression of JavaScript, awaited."""
        answer = self.call("Runtime.evaluate", expression=expression, awaitPromise=True,
                           returnByValue=True)
        assert "exceptionDetails" not in answer, answer["exceptionDetails"]
        return answer["result"].get("value")

    def open(self, path, width=1280, height=800, dark=False, still=False, clock=True, touch=False):
        """Load a page and wait for its players."""
        self.requests.clear(), self.errors.clear()
        self.call("Emulation.setDeviceMetricsOverride", width=width, height=height,
                  deviceScaleFactor=1, mobile=touch)
        self.call("Emulation.setTouchEmulationEnabled", enabled=touch)
        self.call("Emulation.setEmulatedMedia", features=[
            {"name": "prefers-color-scheme", "value": "dark" if dark else "light"},
            {"name": "prefers-reduced-motion", "value": "reduce" if still else "no-preference"}])
        script = self.call("Page.addScriptToEvaluateOnNewDocument",
                           source=CLOCK if clock else "")["identifier"]
        self.call("Page.navigate", url=Path(path).as_uri())
        self.evaluate("""new Promise(done => { const look = () => {
            const hosts = [...document.querySelectorAll(".refimpl-player")];
            if (document.readyState === "complete" && hosts.every(h => h.dataset.ready === "yes"))
              done(true); else setTimeout(look, 10); }; look(); })""")
        self.evaluate(_SHORT)
        self.call("Page.removeScriptToEvaluateOnNewDocument", identifier=script)

    def key(self, key, shift=False):
        """Press a key."""
        text = {"text": key} if len(key) == 1 else {}
        for kind in ("keyDown", "keyUp"):
            self.call("Input.dispatchKeyEvent", type=kind, key=key, modifiers=8 * shift,
                      **(text if kind == "keyDown" else {}))

    def touch(self, *steps):
        """Fingers down, moved and up again: for each step the places of all of them."""
        for number, places in enumerate(steps):
            self.call("Input.dispatchTouchEvent", type="touchMove" if number else "touchStart",
                      touchPoints=[{"x": x, "y": y, "id": n} for n, (x, y) in enumerate(places)])
        self.call("Input.dispatchTouchEvent", type="touchEnd", touchPoints=[])

    def screenshot(self, path):
        """The page as a PNG."""
        data = self.call("Page.captureScreenshot", format="png", captureBeyondViewport=True)["data"]
        Path(path).write_bytes(base64.b64decode(data))

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self._process.terminate()
        self._process.wait()
        os.close(self._write), os.close(self._read)


# Within the page: the n-th player's parts, and where its picture has colour, which paper, floor and
# letters lack.
_SHORT = """
window.player = (n = 0) => document.querySelectorAll(".refimpl-player")[n].shadowRoot;
window.part = (name, n = 0) => player(n).querySelector(name);
window.said = (n = 0) => part("output", n).textContent;
window.pressed = name => part(name).getAttribute("aria-pressed") === "true";
window.scrub = frame => { const slide = part("input");
  slide.value = frame, slide.oninput(), picture(0); return coloured(); };
window.drawn = places => places.map(place =>
  part(".scene").getContext("2d").getImageData(...place, 1, 1).data[3] > 60);
window.has_colour = (name, places) => { const pen = part(name).getContext("2d");
  return places.map(place => pen.getImageData(...place, 1, 1).data.slice(0, 3))
    .map(rgb => Math.max(...rgb) - Math.min(...rgb) > 50); };
window.coloured = (n = 0) => {
  const {width, height} = part(".scene", n), pen = part(".scene", n).getContext("2d");
  const data = pen.getImageData(0, 0, width, height).data, columns = new Array(width).fill(0);
  let all = 7, left = width, right = 0, written = 0;             // letters of the names
  for (let i = 0; i < 4 * 24 * width; i += 4)
    written += data[i + 3] > 128 && data[i] + data[i + 1] + data[i + 2] < 200;
  for (let i = 0; i < data.length; i += 4) {
    const r = data[i], g = data[i + 1], b = data[i + 2];
    if (Math.max(r, g, b) - Math.min(r, g, b) <= 50) continue;
    const x = i / 4 % width;
    columns[x]++;
    all = (31 * all + i) | 0;
    if (i > 4 * 60 * width) { left = Math.min(left, x); right = Math.max(right, x); }  // not names
  }
  const within = (from, to) => columns.slice(from * width, to * width).reduce((a, b) => a + b, 0);
  return {sum: within(0, 1), left, right, in_left: within(0, 0.5), in_right: within(0.5, 1),
    in_middle: within(0.4, 0.6), width, height, all, written};
};
"""
