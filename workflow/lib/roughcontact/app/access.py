"""Who gets an answer of the server: this host, with the token, from the one page that has the study."""

import secrets
import time
from functools import partial

from starlette.datastructures import MutableHeaders
from starlette.requests import Request
from starlette.responses import PlainTextResponse
from starlette.types import ASGIApp, Message, Receive, Scope, Send

from roughcontact.errors import SettingsError

_SILENCE = 5.0  # s after which a page that no longer asks for news counts as closed


_HEADERS = {
    "Cache-Control": "no-store",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
}


async def _with_headers(send: Send, message: Message) -> None:
    """Send a message, of the begin of an answer with headers that keep it here."""
    if message["type"] == "http.response.start":
        MutableHeaders(scope=message).update(_HEADERS)
    await send(message)


class Guard:
    """Lets requests through that name this host and the token, and come from its own page or from none."""

    def __init__(self, app: ASGIApp, *, token: str, port: int) -> None:
        self.app, self.token = app, token
        self.hosts = {f"{name}:{port}" for name in ("127.0.0.1", "localhost")}

    async def __call__(self, scope: Scope, receive: Receive, send: Send) -> None:
        """Answer a request, or refuse it."""
        if scope["type"] == "websocket":  # there is none
            await send({"type": "websocket.close", "code": 1008})
        elif scope["type"] == "http" and not self._admits(Request(scope)):
            await PlainTextResponse("refused", status_code=403)(scope, receive, send)
        else:
            await self.app(scope, receive, partial(_with_headers, send))

    def _admits(self, request: Request) -> bool:
        """Return whether a request may have an answer."""
        headers, (_, token, *path) = request.headers, request.url.path.split("/")
        host, site = headers.get("host", ""), headers.get("sec-fetch-site", "none")
        # links of the report, which is an origin of its own, are followed
        of_report = path[:1] == ["results"] and headers.get("sec-fetch-mode") == "navigate"
        if host not in self.hosts or headers.get("origin", f"http://{host}") != f"http://{host}":
            return False
        if site not in ("none", "same-origin") and not of_report:
            return False
        return secrets.compare_digest(token.encode(), self.token.encode())


class Claim:
    """The page that the study is open in: one at a time."""

    def __init__(self) -> None:
        self.page, self.heard = "", 0.0

    def open(self) -> str:
        """Return the name of a new page; empty while another one is open."""
        if self.page and time.monotonic() - self.heard < _SILENCE:
            return ""
        self.page, self.heard = secrets.token_hex(8), time.monotonic()
        return self.page

    def check(self, page: str) -> None:
        """Note that a page is there; a SettingsError if it is not the one that has the study."""
        if page != self.page:
            raise SettingsError("This study was opened in another page: reload this one to use it here")
        self.heard = time.monotonic()

    def leave(self, page: str) -> None:
        """Note that a page was closed."""
        if page == self.page:
            self.page = ""
