"""The server of the page: on the loopback interface, for one page with the token in its address."""

import os
import secrets
import socket
import webbrowser
from collections.abc import Callable
from pathlib import Path
from typing import Any

import uvicorn
from starlette.applications import Starlette
from starlette.concurrency import run_in_threadpool
from starlette.requests import Request
from starlette.responses import HTMLResponse, JSONResponse, Response
from starlette.routing import Mount, Route
from starlette.staticfiles import StaticFiles
from starlette.types import ASGIApp

from roughcontact.app import fields, look, study
from roughcontact.app.access import Claim, Guard
from roughcontact.app.run import COMMAND, Run
from roughcontact.command_line.run_lock import lock_file
from roughcontact.errors import RoughContactError, SettingsError
from roughcontact.report.template import template

_PAGE = Path(__file__).with_name("page")
_LOCK = Path(".snakemake/page")
_POLICY = (
    "default-src 'none'; script-src 'self'; style-src 'self'; img-src 'self' data:; connect-src 'self'; "
    "frame-src 'self'; base-uri 'none'; form-action 'none'; frame-ancestors 'none'"
)
# a report, which may be of another's study, is an origin of its own: its scripts reach nothing here
_POLICY_OF_RESULTS = "sandbox allow-scripts allow-popups allow-downloads; frame-ancestors 'self'"


class _Results(StaticFiles):
    """The files of the results, pages among them as an origin of their own."""

    def file_response(self, *args: Any, **kwargs: Any) -> Response:
        """Return a file with the rules for its scripts."""
        response = super().file_response(*args, **kwargs)
        response.headers.update({"Content-Security-Policy": _POLICY_OF_RESULTS})
        return response


def application(run: Run, *, token: str, port: int) -> ASGIApp:
    """Return the application of the study in the working directory."""
    claim = Claim()

    def page(_: Request) -> Response:
        if not (name := claim.open()):
            refusal = template("taken.html", folder=_PAGE).render(folder=Path.cwd())
            return HTMLResponse(refusal, status_code=409, headers={"Refresh": "2"})
        text = template("page.html", folder=_PAGE).render(page=name, run=COMMAND, **_study())
        return HTMLResponse(text, headers={"Content-Security-Policy": _POLICY})

    def api(function: Callable[..., Any]) -> Callable[[Request], Any]:
        async def answer(request: Request) -> Response:
            try:
                claim.check(request.query_params.get("page", ""))
                return JSONResponse(await run_in_threadpool(function, **await request.json()))
            except (RoughContactError, OSError) as error:
                return JSONResponse({"error": str(error)}, status_code=400)

        return answer

    async def drop(request: Request) -> Response:
        try:
            claim.check(request.query_params.get("page", ""))
            target = study.free_path(request.query_params.get("name", ""))
        except RoughContactError as error:
            return JSONResponse({"error": str(error)}, status_code=400)
        partial = target.with_name(f".{target.name}.partial")
        target.parent.mkdir(exist_ok=True)
        with partial.open("wb") as file:
            async for chunk in request.stream():
                file.write(chunk)
        partial.replace(target)
        return JSONResponse({"path": str(target)})

    def leave(request: Request) -> Response:
        claim.leave(request.query_params.get("page", ""))
        return Response()

    calls: tuple[Callable[..., Any], ...] = (study.check, study.write, study.add, study.inspect)
    calls += (run.start, run.cancel, run.state, look.results, look.compare, look.export)
    routes = [
        Route("/", page),
        Route("/drop", drop, methods=["PUT"]),
        Route("/leave", leave, methods=["POST"]),
        *(Route(f"/{call.__name__}", api(call), methods=["POST"]) for call in calls),
        Mount("/page", StaticFiles(directory=_PAGE)),
        Mount("/results", _Results(directory="results", check_dir=False)),
    ]
    return Guard(Starlette(routes=[Mount(f"/{token}", routes=routes)]), token=token, port=port)


def _study() -> dict[str, Any]:
    """Return what the page shows of the study when it is opened."""
    try:
        texts, rows, problem = *study.read_folder(), ""
    except RoughContactError as error:
        texts, rows, problem = {}, [], str(error)
    form, columns = fields.form(texts), fields.columns()
    return {
        "folder": Path.cwd(),
        "problem": problem,
        "texts": texts,
        "rows": rows,
        "form": form,
        "columns": columns,
    }


def serve(folder: Path, *, port: int = 0, browser: bool = True) -> int:
    """Open the page of a study folder, which is made if there is none, and serve it until interrupted."""
    folder.mkdir(parents=True, exist_ok=True)
    os.chdir(folder)
    _LOCK.parent.mkdir(exist_ok=True)
    with _LOCK.open("ab") as lock, socket.socket() as listener:
        if os.name != "nt" and lock_file(lock.fileno()) is False:
            raise SettingsError(
                f"{Path.cwd()}: its page is open already, by another `roughcontact app`: use that one, or "
                "end it first (Ctrl-C where it was started)"
            )
        listener.setsockopt(socket.SOL_SOCKET, socket.SO_REUSEADDR, 1)
        listener.bind(("127.0.0.1", port))
        listener.listen()
        token, run = secrets.token_urlsafe(24), Run()
        port = listener.getsockname()[1]
        address = f"http://127.0.0.1:{port}/{token}/"
        print(f"{Path.cwd()}: {address}\nCtrl-C ends the page, and a run that it has started.", flush=True)
        if browser:
            webbrowser.open(address)
        app = application(run, token=token, port=port)
        config = uvicorn.Config(app, log_level="warning", ws="none", timeout_graceful_shutdown=1)
        try:
            uvicorn.Server(config).run(sockets=[listener])
        finally:
            run.cancel()
            if run.process:
                run.process.wait()
    return 0
