"""The server of the page: on the loopback interface, for one page with the token in its address."""

import os
import secrets
import socket
import webbrowser
from functools import partial
from pathlib import Path

import uvicorn
from starlette.applications import Starlette
from starlette.concurrency import run_in_threadpool
from starlette.datastructures import QueryParams
from starlette.middleware import Middleware
from starlette.middleware.base import BaseHTTPMiddleware
from starlette.requests import Request
from starlette.responses import HTMLResponse, PlainTextResponse, Response
from starlette.routing import Mount, Route
from starlette.staticfiles import StaticFiles

from roughcontact.app.access import Claim, guard
from roughcontact.app.measurements import save_upload
from roughcontact.app.page import FOLDER, Page
from roughcontact.command_line.run_lock import lock_file
from roughcontact.errors import RoughContactError, SettingsError

_LOCK = Path(".snakemake/page")


def application(page: Page, *, token: str, port: int) -> Starlette:
    """Return the application of the study in the working directory."""
    claim = Claim()

    def first(_: Request) -> Response:
        if name := claim.open():
            return HTMLResponse(page.first(name))
        return HTMLResponse(page.first(""), 409, {"Refresh": "2"})

    async def answer(request: Request) -> Response:
        action, query = request.path_params["action"], request.query_params
        try:
            claim.check(query.get("page", ""), closed=action == "leave")
            if action == "drop":
                return PlainTextResponse(await save_upload(query.get("name", ""), request.stream()))
            form = QueryParams(await request.body())
            return HTMLResponse(await run_in_threadpool(page.after, action, form))
        except (RoughContactError, OSError) as error:
            return HTMLResponse(page.html(["problem"], problem=str(error)), status_code=400)

    def picture(request: Request) -> Response:
        inspection = page.inspections.get(request.path_params["key"], {})
        return Response(inspection.get("picture"), media_type="image/svg+xml")

    routes = [
        Route("/", first),
        Route("/map/{key}", picture),
        Route("/{action}", answer, methods=["POST"]),
        Mount("/page", StaticFiles(directory=FOLDER)),
        Mount("/results", StaticFiles(directory="results", check_dir=False)),
    ]
    dispatch = partial(guard, token=token, hosts=(f"127.0.0.1:{port}", f"localhost:{port}"))
    guarded = Middleware(BaseHTTPMiddleware, dispatch=dispatch)
    return Starlette(routes=[Mount(f"/{token}", routes=routes)], middleware=[guarded])


def serve(folder: Path, *, port: int = 0, browser: bool = True) -> int:
    """Open the page of a study folder, which is made if there is none, and serve it until interrupted."""
    folder.mkdir(parents=True, exist_ok=True)
    os.chdir(folder)
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
        if browser:
            webbrowser.open(address)
        app = application(page, token=token, port=port)
        config = uvicorn.Config(app, log_level="warning", ws="none", timeout_graceful_shutdown=1)
        try:
            uvicorn.Server(config).run(sockets=[listener])
        finally:
            page.run.cancel()
    return 0
