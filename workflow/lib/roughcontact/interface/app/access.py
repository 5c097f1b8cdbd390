"""Who gets an answer of the server: this host, with the token, from the one page that has the study."""

import asyncio
import secrets
import time
from collections.abc import Collection

from starlette.requests import Request
from uvicorn.protocols.http.h11_impl import H11Protocol

from roughcontact.errors import SettingsError

_MAX_CONNECTIONS = 40  # with three times those accepted at once fewer than the files a process may open
_SILENCE = 5.0  # s after which a page that no longer asks for news, or a connection, counts as closed
_POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src 'self'; "
    "frame-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
# a report, which may be of another's study, is an origin of its own: its scripts reach nothing here
_POLICY_OF_RESULTS = "sandbox allow-scripts allow-popups allow-downloads; frame-ancestors 'self'"
_HEADERS = {
    "Cache-Control": "no-store",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
}


def headers_of(path: str) -> dict[str, str]:
    """Return the headers of the answer to a request for a path, which is stored nowhere else."""
    is_result = path.split("/")[2:3] == ["results"]
    return _HEADERS | {"Content-Security-Policy": _POLICY_OF_RESULTS if is_result else _POLICY}


def is_admitted(request: Request, *, token: str, hosts: Collection[str]) -> bool:
    """Return whether a request names a host and the token, and comes from its own page or from none."""
    headers, (_, request_token, *path) = request.headers, request.url.path.split("/")
    host, site = headers.get("host", ""), headers.get("sec-fetch-site", "none")
    same_origin = host in hosts and headers.get("origin", f"http://{host}") == f"http://{host}"
    # links of the report, an origin of its own, and the file that opens the page are followed
    is_link = path[:1] in (["results"], [""]) and headers.get("sec-fetch-mode") == "navigate"
    from_page = site in ("none", "same-origin") or is_link
    return same_origin and from_page and secrets.compare_digest(request_token.encode(), token.encode())


class Connection(H11Protocol):
    """A connection that ends where no whole request comes in time; of too many one that waits makes room."""

    def connection_made(self, transport: asyncio.Transport) -> None:  # type: ignore[override]  # as uvicorn has it
        """Begin to wait for a request."""
        super().connection_made(transport)
        self.timeout_keep_alive_task = self.loop.call_later(_SILENCE, self.timeout_keep_alive_handler)
        rivals = [peer for peer in self.connections if isinstance(peer, Connection) and peer is not self]
        waiting = [
            peer for peer in rivals if peer.timeout_keep_alive_task and not peer.transport.is_closing()
        ]
        if len(waiting) > _MAX_CONNECTIONS:
            waiting[0].transport.abort()

    def data_received(self, data: bytes) -> None:
        """Read a part of a request, which in uvicorn gives time for the rest without limit."""
        self.conn.receive_data(data)
        self.handle_events()
        if self.cycle and not self.cycle.response_complete:
            self._unset_keepalive_if_required()


class Claim:
    """The page that the study is open in: one at a time."""

    page, heard = "", -_SILENCE

    def open(self, *, here: bool = False) -> str:
        """Return the name of a new page; empty while another one is open, unless it is wanted `here`."""
        if not here and time.monotonic() - self.heard < _SILENCE:
            return ""
        self.page, self.heard = secrets.token_hex(8), time.monotonic()
        return self.page

    def check(self, page: str) -> None:
        """Note that a page is there; a SettingsError if it is not the one with the study."""
        if page != self.page:
            raise SettingsError("This study was opened in another page: reload this one to use it here")
        self.heard = time.monotonic()

    def close(self) -> None:
        """Let another page be opened at once."""
        self.heard = -_SILENCE
