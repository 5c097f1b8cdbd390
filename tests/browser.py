"""A headless Chromium, driven by its debugging protocol over two pipes: keys, clicks, scripts, pictures."""

import base64
import contextlib
import json
import os
import shutil
import subprocess
import time

CHROMIUM = shutil.which("chromium") or shutil.which("google-chrome") or shutil.which("chrome")
_KEYS = {"Tab": 9, "Enter": 13, "Space": 32, "ArrowDown": 40, "Home": 36, "End": 35}
_LONGEST = 1150  # pixels of a picture
_TEXTS = {"Enter": "\r", "Space": " "}


class Browser:
    """A browser with one page; `problems` are the errors that its scripts have raised."""

    def __init__(self, folder, *, width=1200, height=1000):
        read_commands, self.commands = os.pipe()
        self.events, write_events = os.pipe()
        shell = f'exec "$0" "$@" 3<&{read_commands} 4>&{write_events}'
        words = [CHROMIUM, "--headless", "--no-sandbox", "--disable-gpu", "--no-first-run", "--disable-sync"]
        words += ["--disable-background-networking", "--remote-debugging-pipe"]
        words += [f"--user-data-dir={folder}", f"--window-size={width},{height}", "about:blank"]
        self.process = subprocess.Popen(
            ["bash", "-c", shell, *words],
            pass_fds=(read_commands, write_events),
            stdout=subprocess.DEVNULL,
            stderr=subprocess.DEVNULL,
        )
        os.close(read_commands)
        os.close(write_events)
        self.number, self.buffer, self.session, self.problems = 0, b"", None, []
        self.attach(self.send("Target.getTargets")["targetInfos"][0]["targetId"])

    def __enter__(self):
        return self

    def __exit__(self, *_):
        with contextlib.suppress(OSError, EOFError):
            self.session = None
            self.send("Browser.close")
        self.process.wait(timeout=30)
        os.close(self.commands)
        os.close(self.events)

    def attach(self, target):
        """Drive the page of a target."""
        self.session = None
        self.session = self.send("Target.attachToTarget", targetId=target, flatten=True)["sessionId"]
        for domain in ("Page", "Runtime", "DOM"):
            self.send(f"{domain}.enable")

    def new_page(self):
        """Open a further page, drive it, and return the target of the former one."""
        self.session, previous_page = None, self.session
        self.attach(self.send("Target.createTarget", url="about:blank")["targetId"])
        return previous_page

    def follow(self, selector):
        """Click on a link that opens a page of its own, and drive that."""
        known = {target["targetId"] for target in self._targets()}
        self.evaluate(f"document.querySelector({json.dumps(selector)}).click()")
        while not (opened := {target["targetId"] for target in self._targets()} - known):
            time.sleep(0.05)
        self.attach(opened.pop())

    def start_again(self):
        """Close all pages, drive a new one, and forget the problems."""
        self.session = None
        pages = [target["targetId"] for target in self._targets() if target["type"] == "page"]
        self.new_page()
        for page in pages:
            self.send("Target.closeTarget", targetId=page)
        self.resize(1200)
        self.problems.clear()

    def send(self, method, **params):
        """Send a command and return its result."""
        self.number += 1
        message = {"id": self.number, "method": method, "params": params}
        message |= {"sessionId": self.session} if self.session else {}
        os.write(self.commands, json.dumps(message).encode() + b"\0")
        while True:
            while b"\0" not in self.buffer:
                data = os.read(self.events, 65536)
                if not data:
                    raise EOFError("the browser has ended")
                self.buffer += data
            text, _, self.buffer = self.buffer.partition(b"\0")
            event = json.loads(text)
            if event.get("method") == "Runtime.exceptionThrown":
                self.problems.append(event["params"]["exceptionDetails"])
            if event.get("id") == self.number:
                if "error" in event:
                    raise RuntimeError(f"{method}: {event['error']}")
                return event["result"]

    def open(self, address):
        """Go to an address and wait until it is loaded."""
        self.send("Page.navigate", url=address)
        self.wait("document.readyState === 'complete' && location.href !== 'about:blank'")

    def evaluate(self, script):
        """Return the value of a script, of a promise when it is kept."""
        result = self.send(
            "Runtime.evaluate", expression=script, returnByValue=True, awaitPromise=True, userGesture=True
        )
        if "exceptionDetails" in result:
            raise RuntimeError(f"{script}: {result['exceptionDetails']}")
        return result["result"].get("value")

    def wait(self, condition, *, seconds=60):
        """Wait until a script is true."""
        deadline = time.monotonic() + seconds
        while time.monotonic() < deadline:
            with contextlib.suppress(RuntimeError):  # while another page is loaded
                if self.evaluate(f"Boolean({condition})"):
                    return
            time.sleep(0.05)
        page_text = self.evaluate("document.body.innerText")
        raise TimeoutError(f"{condition} is not so after {seconds} s:\n{page_text[-6000:]}")

    def text(self, selector):
        """Return the text of an element."""
        return self.evaluate(f"document.querySelector({json.dumps(selector)}).textContent")

    def _targets(self):
        """Return the pages and frames that the browser has."""
        return self.send("Target.getTargets")["targetInfos"]

    def press(self, key, *, shift=False):
        """Press a key."""
        code = {"key": " " if key == "Space" else key, "code": key, "windowsVirtualKeyCode": _KEYS[key]}
        code["modifiers"] = 8 if shift else 0
        texts = {"text": _TEXTS[key]} if key in _TEXTS else {}
        self.send("Input.dispatchKeyEvent", type="keyDown", **code, **texts)
        self.send("Input.dispatchKeyEvent", type="keyUp", **code)

    def type(self, text):
        """Type a text where the focus is."""
        self.send("Input.insertText", text=text)

    def tab_to(self, selector, *, most=400):
        """Press Tab until an element has the focus, as who has no mouse does."""
        passed = []
        for _ in range(most):
            if self.evaluate(f"document.activeElement.matches({json.dumps(selector)})"):
                return
            passed.append(self.evaluate("document.activeElement.outerHTML.slice(0, 60)"))
            self.press("Tab")
        raise AssertionError(f"no Tab reaches {selector}, but {passed}")

    def choose_files(self, selector, *paths):
        """Choose files in a field, as in the dialogue of the system."""
        root = self.send("DOM.getDocument")["root"]["nodeId"]
        node = self.send("DOM.querySelector", nodeId=root, selector=selector)["nodeId"]
        self.send("DOM.setFileInputFiles", nodeId=node, files=[str(path) for path in paths])

    def resize(self, width, height=1000):
        """Show the page as wide as a screen of so many pixels."""
        self.send(
            "Emulation.setDeviceMetricsOverride",
            width=width,
            height=height,
            deviceScaleFactor=1,
            mobile=False,
        )

    def picture(self, path, *, selector="html"):
        """Write a picture of an element, or of its begin; frames that are out of view stay empty."""
        element = f"document.querySelector({json.dumps(selector)})"
        self.resize(self.evaluate("innerWidth"), 2 * _LONGEST)
        self.evaluate(f"{element}.scrollIntoView()")
        time.sleep(1)  # for what is drawn when it comes into view
        box = self.evaluate(
            f"(() => {{ const b = {element}.getBoundingClientRect(); "
            "return [b.x + scrollX, b.y + scrollY, b.width, b.height] })()"
        )
        clip = dict(zip(("x", "y", "width", "height"), box, strict=True)) | {"scale": 1}
        clip["height"] = min(clip["height"], _LONGEST)
        data = self.send("Page.captureScreenshot", clip=clip)["data"]
        path.write_bytes(base64.b64decode(data))
