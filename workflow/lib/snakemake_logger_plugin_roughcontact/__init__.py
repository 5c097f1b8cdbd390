"""The short screen of a run as a logger plugin of Snakemake: `snakemake --logger roughcontact`.

Snakemake finds such plugins by the name of their package, which therefore lies beside roughcontact. It
imports them at every start: nothing of roughcontact may be imported here, since a Snakefile of another
checkout brings its own.
"""

import logging
import os
import sys
from pathlib import Path

from snakemake_interface_logger_plugins.base import LogHandlerBase

from .screen import BAR, VARIABLE, Screen


class LogHandler(LogHandlerBase):
    """Shows the events of a run on a `Screen`."""

    writes_to_stream = True
    writes_to_file = False
    has_filter = False  # Snakemake's own, which knows --quiet
    has_formatter = False
    needs_rulegraph = False

    def __post_init__(self) -> None:
        """Choose the stream, and tell the jobs that this shows what their logs say."""
        logging.Handler.__init__(self)  # which the first versions of the interface leave out
        stream = sys.stdout if self.common_settings.stdout else sys.stderr
        bar = stream.isatty() or BAR in os.environ
        self.stream = stream
        self.screen = Screen(stream, bar=bar, planned=self.common_settings.dryrun)
        os.environ[VARIABLE] = "1"

    def emit(self, record: logging.LogRecord) -> None:
        """Show what is worth a line."""
        try:
            self.screen.show(record, self.format(record))
        except BrokenPipeError:  # who reads has seen enough, as `head` does: the run goes on without a screen
            with Path(os.devnull).open("w") as nowhere:
                os.dup2(nowhere.fileno(), self.stream.fileno())
        except Exception:
            self.handleError(record)

    def close(self) -> None:
        """Leave the terminal without the bar."""
        self.screen.clear()
        super().close()
