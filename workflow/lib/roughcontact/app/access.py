"""Who gets an answer of the server: this host, with the token, from the one page that has the study."""

import secrets
import time
from collections.abc import Collection

from starlette.middleware.base import RequestResponseEndpoint
from starlette.requests import Request
from starlette.responses import PlainTextResponse, Response

from roughcontact.errors import SettingsError

_SILENCE = 5.0  # s after which a page that no longer asks for news counts as closed
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


async def guard(
    request: Request, call_next: RequestResponseEndpoint, *, token: str, hosts: Collection[str]
) -> Response:
    """Answer a request that `is_admitted`, refuse any other; no answer is stored or read elsewhere."""
    admitted = is_admitted(request, token=token, hosts=hosts)
    response = await call_next(request) if admitted else PlainTextResponse("refused", status_code=403)
    is_result = request.url.path.split("/")[2:3] == ["results"]
    policy = {"Content-Security-Policy": _POLICY_OF_RESULTS if is_result else _POLICY}
    response.headers.update(_HEADERS | policy)
    return response


def is_admitted(request: Request, *, token: str, hosts: Collection[str]) -> bool:
    """Return whether a request names a host and the token, and comes from its own page or from none."""
    headers, (_, request_token, *path) = request.headers, request.url.path.split("/")
    host, site = headers.get("host", ""), headers.get("sec-fetch-site", "none")
    same_origin = host in hosts and headers.get("origin", f"http://{host}") == f"http://{host}"
    # links of the report, which is an origin of its own, are followed
    of_report = path[:1] == ["results"] and headers.get("sec-fetch-mode") == "navigate"
    from_page = site in ("none", "same-origin") or of_report
    return same_origin and from_page and secrets.compare_digest(request_token.encode(), token.encode())


class Claim:
    """The page that the study is open in: one at a time."""

    page, heard = "", -_SILENCE

    def open(self) -> str:
        """Return the name of a new page; empty while another one is open."""
        if time.monotonic() - self.heard < _SILENCE:
            return ""
        self.page, self.heard = secrets.token_hex(8), time.monotonic()
        return self.page

    def check(self, page: str, *, closed: bool) -> None:
        """Note that a page is there, or is closed; a SettingsError if it is not the one with the study."""
        if page != self.page:
            raise SettingsError("This study was opened in another page: reload this one to use it here")
        self.heard = -_SILENCE if closed else time.monotonic()
