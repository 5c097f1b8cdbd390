"""The process whose forks are the jobs of a run: `server.py FILE FOLDER`, started by the executor.

FILE is the number of the open socket through which the socket of each job comes. On that of a job come the
pickled path of the script and its `snakemake`; back goes the exit status, negative for a signal, as soon as
it has ended. FOLDER has the scripts, and `_imports.py`, which imports what they need. The server ends with
the executor, when its jobs have ended.
"""

import atexit
import contextlib
import gc
import os
import pickle
import select
import signal
import socket
import sys
from pathlib import Path
from typing import Any


def serve(connection: socket.socket) -> socket.socket:
    """Fork for each job that comes; return in the fork, with the socket of the job."""
    running: dict[int, socket.socket] = {}
    woken, waking = os.pipe()
    os.set_blocking(waking, False)
    signal.set_wakeup_fd(waking)
    signal.signal(signal.SIGCHLD, lambda *_: None)  # so that it wakes
    interrupted = signal.signal(signal.SIGINT, signal.SIG_IGN)  # the jobs are, and the executor ends this
    waiting: list[Any] = [connection, woken]
    while connection in waiting or running:
        ready, _, _ = select.select(waiting, [], [])
        if woken in ready:
            os.read(woken, 4096)
            _report_ended(running)
        if connection not in ready:
            continue
        _, files, _, _ = socket.recv_fds(connection, 1, 1)
        if not files:
            waiting.remove(connection)
            continue
        job = socket.socket(fileno=files[0])
        process = os.fork()
        if process:
            running[process] = job
            continue
        signal.set_wakeup_fd(-1)
        signal.signal(signal.SIGCHLD, signal.SIG_DFL)
        signal.signal(signal.SIGINT, interrupted)
        connection.close()
        os.close(woken)
        os.close(waking)
        job.set_inheritable(False)
        return job
    sys.exit()


def _report_ended(running: dict[int, socket.socket]) -> None:
    """Tell the executor the status of each job that has ended."""
    with contextlib.suppress(ChildProcessError):
        while running:
            process, status = os.waitpid(-1, os.WNOHANG)
            if not process:
                return
            with running.pop(process) as job, contextlib.suppress(OSError):
                job.sendall(str(os.waitstatus_to_exitcode(status)).encode())


def run(script: str) -> int:
    """Run a script as the module `__main__`, as Python does, and return its exit status."""
    code = 0
    try:
        exec(compile(Path(script).read_bytes(), script, "exec"), vars(sys.modules["__main__"]))
    except SystemExit as end:
        code = end.code if isinstance(end.code, int) else int(end.code is not None)
        if isinstance(end.code, str):
            print(end.code, file=sys.stderr)
    except BaseException as error:
        code = 128 + signal.SIGINT if isinstance(error, KeyboardInterrupt) else 1
        sys.excepthook(type(error), error, error.__traceback__)
    atexit._run_exitfuncs()
    return code


if __name__ == "__main__":
    sys.path.append(sys.argv[2])
    gc.disable()  # what is imported stays, so that no garbage is looked for among it, here or in a job
    with contextlib.suppress(Exception):  # of which every job will complain in its log
        __import__("_imports")
        import snakemake.io  # of which a job's arguments are
    gc.freeze()
    gc.enable()
    with serve(socket.socket(fileno=int(sys.argv[1]))) as _job_socket:
        __file__, snakemake = pickle.loads(b"".join(iter(lambda: _job_socket.recv(2**20), b"")))
        with contextlib.suppress(OSError):  # for `top` and `ps`
            Path("/proc/self/comm").write_text(snakemake.rule)
        # without the end of the interpreter, which frees one by one what it shares with the server
        os._exit(run(__file__))
