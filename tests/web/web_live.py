#!/usr/bin/env python3
# SPDX-License-Identifier: MIT
"""Pages of svocl export-web in a browser that is driven from outside: what a page shows while it arrives and when it
was cut off, where it begins, fly mode by keys and mouse, the density of pixels, and its light beside that of svocl
render.

The browser is spoken to by Chromium's DevTools protocol, over a pipe.

usage: web_live.py PROGRAM; exit code 77 (skipped) without chromium.
"""

import base64
import contextlib
import http.server
import json
import os
import pathlib
import shutil
import subprocess
import sys
import tempfile
import threading
import time

PROGRAM = sys.argv[1]
INSPECT = pathlib.Path(__file__).parent / "inspect.js"
BLOCK_END = b"</script><script>take()</script>\n"
failed = False


def expect(what, holds, seen=""):
    global failed
    if not holds:
        print(f"{what}: {seen}")
        failed = True


# ---- the browser ----


class Browser:
    def __init__(self, folder):
        to_read, self.to = os.pipe()
        self.answers, to_write = os.pipe()
        self.count = 0
        self.session = None
        self.received = b""

        def place_pipes():  # the browser reads 3 and writes 4, which may be ends of the pipes here
            ends = [os.dup(to_read), os.dup(to_write)]
            high = [os.dup2(end, 200 + i) for i, end in enumerate(ends)]
            os.dup2(high[0], 3)
            os.dup2(high[1], 4)

        self.process = subprocess.Popen(
            ["chromium", "--headless=new", "--no-sandbox", "--use-angle=swiftshader", "--enable-unsafe-swiftshader"]
            + ["--disable-background-networking", "--no-first-run", "--remote-debugging-pipe"]
            + [f"--user-data-dir={folder}/profile", "--window-size=640,620", "about:blank"],
            preexec_fn=place_pipes,
            close_fds=False,
            env={**os.environ, "HOME": str(folder)},
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        os.close(to_read)
        os.close(to_write)
        target = self.call("Target.createTarget", url="about:blank")["targetId"]
        self.session = self.call("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        self.call("Page.enable")

    def call(self, method, **values):
        self.count += 1
        message = {"id": self.count, "method": method, "params": values}
        if self.session is not None:
            message["sessionId"] = self.session
        os.write(self.to, json.dumps(message).encode() + b"\0")
        while True:
            while b"\0" not in self.received:
                more = os.read(self.answers, 1 << 20)
                if not more:
                    sys.exit("the browser has gone")
                self.received += more
            text, self.received = self.received.split(b"\0", 1)
            answer = json.loads(text)
            if answer.get("id") == self.count:
                if "error" in answer:
                    sys.exit(f"{method}: {answer['error']}")
                return answer["result"]

    def run(self, script):
        """The value of an expression in the page, which may be a promise."""
        answer = self.call("Runtime.evaluate", expression=script, awaitPromise=True, returnByValue=True)
        if "exceptionDetails" in answer:
            sys.exit(f"{script}: {answer['exceptionDetails']}")
        return answer["result"].get("value")

    def wait(self, script):
        """Until the expression holds; the test's own limit of time ends what never does."""
        while not self.run(script):
            time.sleep(0.05)

    def open(self, address):
        self.run("globalThis.isBefore = true")
        self.call("Page.navigate", url=address)
        self.wait("globalThis.isBefore === undefined")

    def open_whole(self, address):
        """Opens a page and waits for all of it and its picture. page is the viewer then."""
        self.open(address)
        self.wait("typeof viewer !== 'undefined'")
        self.run("viewer.then(shown => { globalThis.page = shown; })")
        self.wait("!page.scheduled")

    def key(self, kind, code, key):
        number = {"ArrowLeft": 37}.get(code, ord(key.upper()[0]))
        text = {"text": key} if kind == "keyDown" and len(key) == 1 else {}
        self.call("Input.dispatchKeyEvent", type=kind, code=code, key=key, windowsVirtualKeyCode=number, **text)

    def mouse(self, kind, x, y, **values):
        self.call("Input.dispatchMouseEvent", type=kind, x=x, y=y, **values)

    def close(self):
        self.call("Browser.close")
        self.process.wait()


# ---- pages ----


def export(path, *arguments):
    subprocess.run([PROGRAM, "export-web", *arguments, "-q", "-o", str(path)], check=True)
    return path.read_bytes()


@contextlib.contextmanager
def slow_server(page, pause_at, whole=True):
    """Serves a page: its bytes up to pause_at, the rest when .go is set, or never, where it is not whole."""

    class Handler(http.server.BaseHTTPRequestHandler):
        def do_GET(self):
            self.send_response(200)
            self.send_header("Content-Type", "text/html")
            self.send_header("Content-Length", str(len(page)))
            self.end_headers()
            self.wfile.write(page[:pause_at])
            self.wfile.flush()
            self.server.go.wait()
            if whole:
                self.wfile.write(page[pause_at:])

        def log_message(self, *_):
            pass

    server = http.server.ThreadingHTTPServer(("127.0.0.1", 0), Handler)
    server.go = threading.Event()
    thread = threading.Thread(target=server.serve_forever)
    thread.start()
    try:
        yield server, f"http://127.0.0.1:{server.server_address[1]}/"
    finally:
        server.go.set()
        server.shutdown()
        server.server_close()
        thread.join()


PICTURE = "document.querySelector('canvas').toDataURL()"
IDLE = "document.getElementById('refined').hidden"


def block_ends(page):
    ends = []
    at = page.find(BLOCK_END)
    while at >= 0:
        ends.append(at + len(BLOCK_END))
        at = page.find(BLOCK_END, ends[-1])
    return ends


# ---- tests ----


def levels_come_coarse_first(browser, folder):
    path = folder / "statue.html"
    page = export(path, "scene:statue", "-d", "8")
    ends = block_ends(page)
    expect("blocks of a page of depth 8", len(ends) >= 3, len(ends))
    browser.open_whole(path.as_uri())
    fine = browser.run(PICTURE)
    # The second block ends with a level, which is what a page shows whose slider is there.
    with slow_server(page, ends[1] + 1000) as (server, address):
        browser.open(address)
        browser.wait("document.getElementById('coming')?.textContent.startsWith('Level ')")
        browser.wait(f"arrival.packed > 0 && {IDLE} && document.querySelectorAll('body > script').length > 0")
        browser.wait("document.getElementById('coming').textContent !== ''")
        said = browser.run("new Promise(done => setTimeout(done, 200)).then(() => get('coming').textContent)")
        browser.wait(IDLE)
        early = browser.run(PICTURE)
        level = int(said.split()[1])
        expect("levels before the end", 1 <= level < 8 and said.startswith(f"Level {level} of 8, "), said)
        expect("the page says that it comes", not browser.run("get('coming').hidden"))
        server.go.set()
        browser.run("viewer.then(shown => { globalThis.page = shown; })")
        browser.wait("!page.scheduled")
        expect("the picture at the end", browser.run(PICTURE) == fine)
        expect("nothing comes any more", browser.run("get('coming').hidden"))
    expect("an early picture is another", early != fine)
    browser.open_whole(path.as_uri())
    browser.run(f"get('deepest').value = {level}, page.draw()")
    browser.wait("!page.scheduled")
    expect("an early picture is that of its level", browser.run(PICTURE) == early, level)


def cut_off_pages_say_so(browser, folder):
    page = export(folder / "whole.html", "scene:statue", "-d", "8")
    ends = block_ends(page)
    cut = folder / "cut.html"
    cut.write_bytes(page[: ends[-1] - 5000])
    browser.open_whole(cut.as_uri())
    said = browser.run("get('coming').textContent")
    expect("a page that was cut off", "was cut off: level " in said and not browser.run("get('coming').hidden"), said)
    expect("it shows what it has", browser.run("page.level > 0 && page.level < 8 && get('words').hidden"))
    with slow_server(page, ends[0] + 10, whole=False) as (server, address):
        browser.open(address)
        browser.wait("document.getElementById('coming')?.textContent.startsWith('Level ')")
        server.go.set()
        browser.wait("get('coming').textContent.endsWith('Was the page cut off?')")
    cut.write_bytes(page[: page.find(b"application/octet-stream") + 500])
    browser.open(cut.as_uri())
    browser.wait("typeof viewer !== 'undefined'")
    browser.run("viewer.catch(() => null)")
    said = browser.run("get('words').textContent")
    expect("a page without its first level", "cut off before its first level" in said, said)
    cut.write_bytes(page[: page.find(b'<script id="walk"')])
    browser.open(cut.as_uri())
    browser.wait("document.readyState === 'complete' && document.getElementById('words') !== null")
    said = browser.run("document.getElementById('words').textContent")
    expect("a page without its scripts", "its file was cut off" in said, said)


CAMERA = "(({yaw, pitch}, eye) => ({yaw, pitch, eye}))(page.camera, eyeOf(page.camera))"


def moved(before, after, direction):
    """How far the eye went along a direction, and beside it."""
    way = [b - a for a, b in zip(before["eye"], after["eye"])]
    along = sum(w * d for w, d in zip(way, direction))
    beside = sum((w - along * d) ** 2 for w, d in zip(way, direction)) ** 0.5
    return along, beside


def hold_key(browser, code, key):
    """Holds a key until the camera has moved, and waits until it stands still."""
    before = browser.run(CAMERA)
    browser.key("keyDown", code, key)
    browser.wait(f"Math.hypot(...add(eyeOf(page.camera), {[-x for x in before['eye']]})) > 0.01")
    browser.key("keyUp", code, key)
    browser.wait("page.flight.moved === null")
    return before, browser.run(CAMERA)


def keys_and_mouse_fly(browser, folder):
    path = folder / "hall.html"
    export(path, "scene:atrium", "-d", "6", "--eye", "0.6,1.7,3", "--at", "-0.9,1.75,-3", "--fov", "70")
    browser.open_whole(path.as_uri())
    start = browser.run(CAMERA)
    seen = browser.run("startOf(page.tree)")
    world = browser.run(f"eyeOf(page.camera).map((x, axis) => page.tree.origin[axis] + page.tree.edge * x)")
    expect("the page begins at --eye", all(abs(a - b) < 1e-4 for a, b in zip(world, [0.6, 1.7, 3])), world)
    expect("--fov", abs(seen["halfFov"] * 2 - 70 * 3.14159265 / 180) < 1e-4, seen["halfFov"])
    expect("a page that begins inside flies", browser.run("page.flight.on"))
    axes = browser.run("axesOf(page.camera)")
    for code, key, direction in [
        ("KeyW", "w", axes["forward"]),
        ("KeyS", "s", [-x for x in axes["forward"]]),
        ("KeyD", "d", axes["right"]),
        ("ArrowLeft", "ArrowLeft", [-x for x in axes["right"]]),
        ("KeyE", "e", [0, 1, 0]),
    ]:
        before, after = hold_key(browser, code, key)
        along, beside = moved(before, after, direction)
        expect(f"{code} moves", along > 0.01 and beside < 1e-6, (along, beside))
        expect(f"{code} does not turn", before["yaw"] == after["yaw"] and before["pitch"] == after["pitch"])
    # Dragging looks around; what is grabbed stays below the mouse, so to the right turns to the left.
    before = browser.run(CAMERA)
    browser.mouse("mousePressed", 300, 250, button="left", buttons=1, clickCount=1)
    browser.mouse("mouseMoved", 340, 250, button="left", buttons=1)
    browser.mouse("mouseReleased", 340, 250, button="left", clickCount=1)
    after = browser.run(CAMERA)
    expect("a drag looks to the left", after["yaw"] > before["yaw"], (before["yaw"], after["yaw"]))
    expect("a drag does not move", max(abs(a - b) for a, b in zip(before["eye"], after["eye"])) < 1e-9)
    speed = browser.run("page.flight.speed")
    browser.mouse("mouseWheel", 300, 250, deltaX=0, deltaY=-120)
    browser.wait(f"page.flight.speed > {speed}")
    expect("the wheel does not move", browser.run(CAMERA) == after)
    # A click hands the mouse to the page, which then turns to where it moves.
    browser.mouse("mousePressed", 300, 250, button="left", buttons=1, clickCount=1)
    browser.mouse("mouseReleased", 300, 250, button="left", clickCount=1)
    browser.wait("document.pointerLockElement === canvas")
    before = browser.run(CAMERA)
    browser.mouse("mouseMoved", 330, 250)
    browser.wait(f"page.camera.yaw !== {before['yaw']}")
    expect("the mouse looks to the right", browser.run(CAMERA)["yaw"] < before["yaw"])
    browser.key("keyDown", "KeyF", "f")
    browser.key("keyUp", "KeyF", "f")
    browser.wait("!page.flight.on && document.pointerLockElement === null")
    browser.run("get('start').click()")
    expect("First view", browser.run(CAMERA) == start and browser.run("page.flight.on"))
    browser.run("get('home').click()")
    expect("Whole tree", not browser.run("page.flight.on") and not browser.run("page.touched"))


def pixels_of_the_screen_are_followed(browser, folder):
    path = folder / "pixels.html"
    export(path, "scene:cube", "-d", "4")
    browser.open_whole(path.as_uri())
    # The canvas keeps its size, so that the density alone changes. Chromium's emulation looks at it anew where the
    # window has another size.
    browser.run("canvas.style.width = '160px', canvas.style.height = '120px'")
    for i, density in enumerate((2, 1.25, 3, 1.25, 1)):
        browser.call(
            "Emulation.setDeviceMetricsOverride", width=600 + i, height=620, deviceScaleFactor=density, mobile=False
        )
        wanted = f"devicePixelRatio === {density} && canvas.width === {160 * density}"
        deadline = time.monotonic() + 20
        while not browser.run(wanted) and time.monotonic() < deadline:
            time.sleep(0.05)
        seen = browser.run("[devicePixelRatio, canvas.width, canvas.clientWidth]")
        expect(f"{density} pixels of the screen for one of the page", browser.run(wanted), seen)
    browser.call("Emulation.clearDeviceMetricsOverride")


def what_is_up_is_framed(browser, folder):
    path = folder / "up.html"
    export(path, "scene:statue", "-d", "6", "--up", "0,0,1", "--view", "normal")
    browser.open_whole(path.as_uri())
    expect("--view", browser.run("document.forms.controls.view.value") == "1")
    expect("--up", browser.run("axesOf(page.camera).up[2]") > 0.9)
    beyond = browser.run(
        """(() => {
      const axes = axesOf(page.camera);
      const eye = eyeOf(page.camera);
      const tangent = Math.tan(page.camera.halfFov);
      const sides = [[axes.up, tangent], [axes.right, tangent * canvas.width / canvas.height]];
      return Math.max(...sides.flatMap(([side, reach]) => [1, -1].map(sign => {
        const out = add(scale(side, sign), scale(axes.forward, -reach));
        return reachOf(page.nodes, out) - dot(out, eye);
      })));
    })()"""
    )
    expect("cells beyond a side of the picture", beyond <= 0, beyond)


def light_is_that_of_render(browser, folder):
    lights = folder / "lights.json"
    lights.write_text(json.dumps({
        "lights": [
            {"kind": "directional", "direction": [-0.62, -1, -0.34], "value": [6.5, 6.0, 5.2]},
            {"kind": "point", "position": [-5, 0.9, -4], "value": [0.9, 0.6, 0.3]},
            {"kind": "spot", "position": [4, 3.6, 4.5], "direction": [-0.3, -1, -0.5], "value": [3, 2.6, 2],
             "inner_angle": 18, "outer_angle": 32},
        ],
        "sky": [0.35, 0.45, 0.6],
        "camera": {"eye": [0.6, 1.7, 6.2], "at": [-0.9, 1.75, -3], "fov": 62},
    }))  # fmt: skip
    path = folder / "lit.html"
    tree = folder / "atrium.svo"
    subprocess.run([PROGRAM, "build", "scene:atrium", "-d", "7", "-q", "-o", str(tree)], check=True)
    export(path, str(tree), "--lights", str(lights), "--exposure", "1")
    browser.open_whole(path.as_uri())
    browser.run(INSPECT.read_text())
    browser.run("canvas.style.width = '160px', canvas.style.height = '120px', page.resize()")
    browser.wait("!page.scheduled")
    far = {}
    for view in ("full", "ao"):
        picture = folder / f"{view}.png"
        as_page = ["--range", "2"] if view == "ao" else ["--exposure", "1"]
        subprocess.run(
            [PROGRAM, "render", str(tree), "--lights", str(lights), "--view", view, "--size", "160x120", "-q"]
            + [*as_page, "--cones", "16", "-o", str(picture)],
            check=True,
        )
        address = "data:image/png;base64," + base64.b64encode(picture.read_bytes()).decode()
        browser.run(f"document.querySelector('#views input[value=\"{6 if view == 'full' else 5}\"]').click()")
        browser.wait("!page.scheduled")
        far[view] = float(browser.run(f"readPicture('{address}').then(picture => distance(readCanvas(page), picture))"))
    print(f"mean difference to svocl render, of 255: {far}")
    expect("light is that of svocl render", far["full"] < 14, far)
    expect("openness is that of svocl render", far["ao"] < 25, far)


def skies_are_those_of_render(browser, folder):
    # Eight columns and four rows, each of a color of its own; what lies between texels shows where they are.
    texels = bytes(value for i in range(32) for value in (40 + 6 * i, 255 - 7 * i, 90 + 50 * (i % 4), 127 + i % 2))
    (folder / "sky.hdr").write_bytes(b"#?RADIANCE\nFORMAT=32-bit_rle_rgbe\n\n-Y 4 +X 8\n" + texels)
    lights = folder / "sky.json"
    lights.write_text(json.dumps({"sky": {"file": "sky.hdr", "turn": 20}}))
    path = folder / "sky.html"
    picture = folder / "sky.png"
    far = []
    # From two sides, one of which has the seam of the map.
    for place in (["--eye", "3,2,4", "--at", "-0.5,1.5,0"], ["--eye", "0.3,-1,-4", "--at", "0,0,0"]):
        shown = ["scene:knot:2000", "-d", "5", "--lights", str(lights), "--exposure", "0.7", "--fov", "100", *place]
        export(path, *shown)
        as_page = ["--view", "full", "--size", "160x120", "--cones", "16", "-q", "-o", str(picture)]
        subprocess.run([PROGRAM, "render", *shown, *as_page], check=True)
        browser.open_whole(path.as_uri())
        browser.run(INSPECT.read_text())
        browser.run("canvas.style.width = '160px', canvas.style.height = '120px', page.resize()")
        browser.wait("!page.scheduled")
        address = "data:image/png;base64," + base64.b64encode(picture.read_bytes()).decode()
        far.append(float(browser.run(f"readPicture('{address}').then(picture => distance(readCanvas(page), picture))")))
    print(f"mean difference to svocl render, of 255: {far}")
    expect("a sky is that of svocl render", max(far) < 2.5, far)


TESTS = [
    levels_come_coarse_first,
    cut_off_pages_say_so,
    keys_and_mouse_fly,
    pixels_of_the_screen_are_followed,
    what_is_up_is_framed,
    light_is_that_of_render,
    skies_are_those_of_render,
]


def main():
    if shutil.which("chromium") is None:
        print("skipped: chromium is not installed")
        return 77
    with tempfile.TemporaryDirectory() as name:
        folder = pathlib.Path(name)
        browser = Browser(folder)
        for test in TESTS:
            if len(sys.argv) < 3 or test.__name__ in sys.argv[2:]:
                print(test.__name__, flush=True)
                test(browser, folder)
        browser.close()
    return 1 if failed else 0


sys.exit(main())
