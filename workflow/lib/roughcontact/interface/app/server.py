"""The server of the page: on the loopback interface, for this computer and those who know the token."""

import asyncio
import os
import signal
import socket
import sys
import webbrowser
from collections.abc import Sequence
from functools import partial
from pathlib import Path
from secrets import compare_digest, token_urlsafe
from typing import Any
from urllib.request import urlopen

import uvicorn
from starlette.applications import Starlette
from starlette.concurrency import run_in_threadpool
from starlette.middleware.base import BaseHTTPMiddleware, RequestResponseEndpoint
from starlette.requests import Request
from starlette.responses import FileResponse, HTMLResponse, PlainTextResponse, Response
from starlette.routing import Mount, Route
from starlette.staticfiles import StaticFiles
from uvicorn.protocols.http.h11_impl import H11Protocol

from roughcontact.errors import SettingsError
from roughcontact.interface.app import commands
from roughcontact.interface.app.measurements import cut, large_picture, save_upload
from roughcontact.interface.app.page import Page
from roughcontact.interface.app.study import FOLDER, check_within_study, error_in_words
from roughcontact.report.template import script_digests
from roughcontact.study.run_lock import lock_file

_MAX_CONNECTIONS = 40  # with six times those accepted at once fewer than the files a process may open
_LOCK, _OPENING = Path(".snakemake/page"), Path(".snakemake/page.html")
_NOTHING = "default-src 'none'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
_POLICY = f"{_NOTHING}; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src 'self'"
# a report may be of another's study: its scripts, which would read the token in the address, do not run
_POLICY_OF_RESULTS = (
    f"{_NOTHING}; sandbox allow-scripts allow-popups allow-downloads; img-src data:; "
    f"style-src 'unsafe-inline'; script-src {script_digests()}"
)
_HEADERS = {
    "Cache-Control": "no-store",
    "Cross-Origin-Resource-Policy": "same-origin",
    "Referrer-Policy": "no-referrer",
    "X-Content-Type-Options": "nosniff",
}


def application(page: Page, *, token: str, port: int) -> Starlette:
    """Return the application of the study in the working directory."""
    one_by_one = asyncio.Lock()

    async def answer(request: Request) -> Response:
        draw = partial(page.since, request.query_params.get("seen", ""))
        if request.method == "POST":
            draw = partial(page.after, await request.json())
        async with one_by_one:
            return HTMLResponse(await run_in_threadpool(draw))

    async def drop(request: Request) -> Response:
        return PlainTextResponse(await save_upload(request.query_params.get("name", ""), request.stream()))

    def of_map(request: Request) -> Response:
        inspection, query = page.reader.readings[request.path_params["key"]].result(), request.query_params
        if "line" in query:
            return HTMLResponse(page.filled("cut", **cut(inspection["row"], query["line"])))
        # of which the type is stated in the picture itself
        picture = urlopen(large_picture(inspection) if "whole" in query else inspection["picture"])
        return Response(picture.read(), media_type=picture.headers["Content-Type"])

    async def guard(request: Request, call_next: RequestResponseEndpoint) -> Response:
        _, word, *path = request.url.path.split("/")
        try:
            admitted = is_admitted(request, path, port) and compare_digest(word.encode(), token.encode())
            response = await call_next(request) if admitted else PlainTextResponse("refused", 403)
        except Exception as error:  # whatever it is
            response = PlainTextResponse(error_in_words(error), 400)
        policy = _POLICY_OF_RESULTS if path[:1] == ["results"] else _POLICY
        response.headers.update(_HEADERS | {"Content-Security-Policy": policy})
        return response

    def report(request: Request) -> Response:
        file, exists = results.lookup_path(f"{request.path_params['name']}.html")
        return HTMLResponse(page.with_bar(Path(file), f"/{token}/") if exists else "", 200 if exists else 404)

    def export(request: Request) -> Response:
        result, form, previous = (request.query_params.get(name, "") for name in ("result", "form", "before"))
        if form == "compare" and not previous:
            return HTMLResponse(page.filled("compared", result=result))
        file, words = commands.export(result, form, previous or result, plan=page.checked["plan"])
        return FileResponse(file, filename=file.name) if file.is_file() else PlainTextResponse(words)

    results = StaticFiles(directory="results", check_dir=False)
    routes = [
        Route("/", answer, methods=["GET", "POST"]),
        Route("/drop", drop, methods=["POST"]),
        Route("/map/{key}", of_map),
        Route("/export", export),
        Route("/results/{name:path}.html", report),
        Mount("/page", StaticFiles(directory=FOLDER)),
        Mount("/results", results),
    ]
    served = Starlette(routes=[Mount(f"/{token}", routes=routes)])
    served.add_middleware(BaseHTTPMiddleware, dispatch=guard)
    return served


def is_admitted(request: Request, path: Sequence[str], port: int) -> bool:
    """Return whether a request for a path names this host, and comes from its own page or from none."""
    host, site = request.headers.get("host", ""), request.headers.get("sec-fetch-site", "none")
    same_origin = request.headers.get("origin", f"http://{host}") == f"http://{host}"
    # links of the report, an origin of its own, and the file that opens the page are followed
    is_followed = request.headers.get("sec-fetch-mode") == "navigate"
    is_link = is_followed and path[:1] in (["results"], ["export"], [""])
    from_page = site in ("none", "same-origin") or is_link
    return host in (f"127.0.0.1:{port}", f"localhost:{port}") and same_origin and from_page


class Connection(H11Protocol):
    """A connection; the oldest one that waits for a request makes room where there are too many."""

    def connection_made(self, transport: Any) -> None:  # narrower in uvicorn than in asyncio
        """Begin; what was sent with it is read in the next round of the loop, and room is made after that."""
        super().connection_made(transport)
        self.begin = self.loop.time()
        self.loop.call_soon(self.loop.call_soon, self.make_room)

    def make_room(self) -> None:
        """End the oldest connection without a request, where this is one too many."""
        waiting = [peer for peer in self.connections if isinstance(peer, Connection) and peer.is_waiting()]
        if len(waiting) > _MAX_CONNECTIONS:
            min(waiting, key=lambda peer: peer.begin).transport.abort()

    def is_waiting(self) -> bool:
        """Return whether no request is being answered."""
        is_answering = self.cycle and not self.cycle.response_complete
        return not (is_answering or self.transport.is_closing())


def open_in_browser(address: str) -> None:
    """Open an address by a file that this user alone may read: everybody sees the words of a command."""
    _OPENING.unlink(missing_ok=True)
    _OPENING.touch(0o600, exist_ok=False)
    _OPENING.write_text(f'<meta http-equiv="refresh" content="0; url={address}">', encoding="ascii")
    webbrowser.open(_OPENING.absolute().as_uri())


def serve(folder: Path, *, port: int = 0, browser: bool = True) -> int:
    """Open the page of a study folder, which is made if there is none, and serve it until interrupted."""
    folder.mkdir(parents=True, exist_ok=True)
    os.chdir(folder)
    check_within_study(_LOCK)
    _LOCK.parent.mkdir(exist_ok=True)
    with _LOCK.open("ab") as lock, socket.create_server(("127.0.0.1", port)) as listener:
        if os.name != "nt" and lock_file(lock.fileno()) is False:
            raise SettingsError(
                f"{Path.cwd()}: its page is open already, by another `roughcontact app`: use that one, or "
                "end it first (Ctrl-C where it was started)"
            )
        token, page, port = token_urlsafe(24), Page(), listener.getsockname()[1]
        address = f"http://127.0.0.1:{port}/{token}/"
        print(f"{Path.cwd()}: {address}\nCtrl-C ends the page, and a run that it has started.", flush=True)
        app = application(page, token=token, port=port)
        # the backlog is what asyncio accepts at once, before a connection can make room
        config = uvicorn.Config(
            app, http=Connection, ws="none", log_config=None, backlog=20, timeout_graceful_shutdown=1
        )
        # uvicorn raises the signals again: they end the program by what follows
        signal.signal(signal.SIGTERM, lambda number, _: sys.exit(128 + number))
        signal.signal(signal.SIGINT, signal.default_int_handler)
        try:
            if browser:
                open_in_browser(address)
            uvicorn.Server(config).run(sockets=[listener])
        finally:
            page.run.cancel()
            page.reader.pool.shutdown(wait=False, cancel_futures=True)
            _OPENING.unlink(missing_ok=True)
    return 0
