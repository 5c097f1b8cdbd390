"""Jobs of a run on this machine as forks of one process: `snakemake --executor roughcontact`.

Starting Python and importing the libraries takes a job longer than a small map. `server.py` does so once, and
each script that lies beside a `_imports.py` runs in a fork of it. All else is Snakemake's own local executor.
Nothing of roughcontact is imported here, since a Snakefile of another checkout brings its own.
"""

import os
import pickle
import socket
import subprocess
import sys
from concurrent.futures import Future
from contextlib import suppress
from pathlib import Path
from threading import Lock
from types import SimpleNamespace
from typing import Any

from snakemake.executors import local
from snakemake.settings.types import DeploymentMethod

common_settings = local.common_settings
_SERVER = Path(__file__).with_name("server.py")
_BLAS = ("OMP", "OPENBLAS", "MKL", "VECLIB", "NUMEXPR")  # whose threads the jobs do not use
_ELSEWHERE = {DeploymentMethod.CONDA, DeploymentMethod.APPTAINER, DeploymentMethod.ENV_MODULES}


class Executor(local.Executor):
    """Snakemake's local executor, but for scripts that run in a fork."""

    def __post_init__(self) -> None:
        """Prepare the servers, one for each folder of scripts; none is started yet."""
        super().__post_init__()
        self._servers: dict[Path, tuple[socket.socket, subprocess.Popen]] = {}
        self._lock = Lock()

    def run_single_job(self, job: Any) -> "Future[None]":
        """Run a job in a thread of the pool, which waits for the fork or for what Snakemake starts."""
        script = self._script(job)
        if script is None:
            return super().run_single_job(job)
        self.workflow.async_run(job.prepare())
        return self.pool.submit(self.cached_or_run, job, self._run_in_fork, job, script)

    def _script(self, job: Any) -> Path | None:
        """Return the script of a job if it is one that runs in a fork."""
        rule, elsewhere = job.rule, self.workflow.deployment_settings.deployment_method & _ELSEWHERE
        if not rule.script or elsewhere or job.is_shadow or job.benchmark is not None:
            return None
        path = Path(rule.basedir.get_path_or_uri(secret_free=True), rule.script)
        return path if path.with_name("_imports.py").is_file() and path.is_file() else None

    def _run_in_fork(self, job: Any, script: Path) -> None:
        """Run a script to its end, and raise CalledProcessError, as Snakemake's shell does, if it fails."""
        files = {name: getattr(job, name)._plainstrings() for name in ("input", "output", "log")}
        names = ("params", "wildcards", "threads", "resources")
        fields = {"rule": job.rule.name, **files, **{name: getattr(job, name) for name in names}}
        connection, server = self._server(script.parent)
        ours, of_job = socket.socketpair()
        status = b""  # as it stays where the server was killed
        with ours, suppress(ConnectionError):
            with of_job:
                socket.send_fds(connection, [b"j"], [of_job.fileno()])
            ours.sendall(pickle.dumps((str(script), SimpleNamespace(**fields))))
            ours.shutdown(socket.SHUT_WR)
            status = ours.recv(16)
        if code := int(status or server.wait() or 1):
            raise subprocess.CalledProcessError(code, str(script))

    def _server(self, folder: Path) -> tuple[socket.socket, subprocess.Popen]:
        """Return the process that forks for the scripts of a folder, and the connection to it."""
        with self._lock:
            if folder not in self._servers or self._servers[folder][1].poll() is not None:
                ours, of_server = socket.socketpair()
                with of_server:
                    command = [sys.executable, str(_SERVER), str(of_server.fileno()), str(folder)]
                    variables = os.environ | {f"{name}_NUM_THREADS": "1" for name in _BLAS}
                    process = subprocess.Popen(command, env=variables, pass_fds=[of_server.fileno()])
                self._servers[folder] = ours, process
            return self._servers[folder]

    def shutdown(self) -> None:
        """Wait for the jobs, and end the servers."""
        super().shutdown()
        self._end_servers()

    def cancel(self) -> None:
        """Wait for the jobs, which have been interrupted, and end the servers."""
        super().cancel()
        self._end_servers()

    def _end_servers(self) -> None:
        while self._servers:
            connection, process = self._servers.popitem()[1]
            connection.close()
            process.wait()
