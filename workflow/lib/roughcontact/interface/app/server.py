"""The server of the page: on the loopback interface, for one page with the token in its address."""

import asyncio
import os
import secrets
import signal
import socket
import sys
import webbrowser
from pathlib import Path

import uvicorn
from starlette.applications import Starlette
from starlette.concurrency import run_in_threadpool
from starlette.datastructures import QueryParams
from starlette.middleware import Middleware
from starlette.middleware.base import BaseHTTPMiddleware, RequestResponseEndpoint
from starlette.requests import Request
from starlette.responses import HTMLResponse, JSONResponse, PlainTextResponse, Response
from starlette.routing import Mount, Route
from starlette.staticfiles import StaticFiles

from roughcontact.errors import SettingsError
from roughcontact.interface.app.access import Claim, Connection, headers_of, is_admitted
from roughcontact.interface.app.measurements import cut, save_upload, whole
from roughcontact.interface.app.page import FOLDER, Page
from roughcontact.interface.app.study import check_within_study, error_in_words
from roughcontact.study.run_lock import lock_file

_TRIES = 75  # of 20 ms, in which a page that is closed says so
_LOCK, _OPENING = Path(".snakemake/page"), Path(".snakemake/page.html")


def application(page: Page, *, token: str, port: int) -> Starlette:
    """Return the application of the study in the working directory."""
    claim, one_by_one = Claim(), asyncio.Lock()

    async def first(request: Request) -> Response:
        for _ in range(_TRIES):  # the same page before it was loaded again may still say farewell
            if name := claim.open(here="here" in request.query_params):
                break
            await asyncio.sleep(0.02)
        async with one_by_one:
            return HTMLResponse(page.first(name), 200 if name else 409, {} if name else {"Refresh": "2"})

    async def answer(request: Request) -> Response:
        action, query = request.path_params["action"], request.query_params
        claim.check(query.get("page", ""))
        if action == "drop":
            return PlainTextResponse(await save_upload(query.get("name", ""), request.stream()))
        form = QueryParams(await request.body())
        try:
            async with one_by_one:  # a page that is left sends what was typed last, if anything
                text = await run_in_threadpool(page.after, action, form) if form or action != "leave" else ""
        finally:
            if action == "leave":  # what the next page shows is written
                claim.close()
        return HTMLResponse(text)

    def of_map(request: Request) -> Response:
        inspection = page.reader.readings[request.path_params["key"]].result()
        if line := request.query_params.get("line"):
            return JSONResponse(cut(inspection["row"], line))
        is_whole = "whole" in request.query_params
        return Response(
            whole(inspection["row"]) if is_whole else inspection["picture"], media_type="image/png"
        )

    async def guard(request: Request, call_next: RequestResponseEndpoint) -> Response:
        try:
            admitted = is_admitted(request, token=token, hosts=hosts)
            response = await call_next(request) if admitted else PlainTextResponse("refused", 403)
        except Exception as error:  # whatever it is
            response = HTMLResponse(page.html(["problem"], problem=error_in_words(error)), 400)
        response.headers.update(headers_of(request.url.path))
        return response

    routes = [
        Route("/", first),
        Route("/map/{key}", of_map),
        Route("/{action}", answer, methods=["POST"]),
        Mount("/page", StaticFiles(directory=FOLDER)),
        Mount("/results", StaticFiles(directory="results", check_dir=False)),
    ]
    hosts = (f"127.0.0.1:{port}", f"localhost:{port}")
    guard_layer = Middleware(BaseHTTPMiddleware, dispatch=guard)
    return Starlette(routes=[Mount(f"/{token}", routes=routes)], middleware=[guard_layer])


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
        token, page, port = secrets.token_urlsafe(24), Page(), listener.getsockname()[1]
        address = f"http://127.0.0.1:{port}/{token}/"
        print(f"{Path.cwd()}: {address}\nCtrl-C ends the page, and a run that it has started.", flush=True)
        app = application(page, token=token, port=port)
        config = uvicorn.Config(
            app,
            http=Connection,
            ws="none",
            log_config=None,
            backlog=30,  # what asyncio accepts at once, before a connection can make room
            timeout_graceful_shutdown=1,
        )
        # uvicorn raises the signal again: it ends the program by what follows
        signal.signal(signal.SIGTERM, lambda number, _: sys.exit(128 + number))
        try:
            if browser:
                open_in_browser(address)
            uvicorn.Server(config).run(sockets=[listener])
        finally:
            page.run.cancel()
            page.reader.pool.shutdown(wait=False, cancel_futures=True)
            _OPENING.unlink(missing_ok=True)
    return 0
