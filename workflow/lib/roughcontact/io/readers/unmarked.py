"""Instrument files without a mark, recognised only by trying to read them; the last reader asked."""

from roughcontact.io.instruments.library import instrument_reader
from roughcontact.io.interface import RecognisedBy

READER = instrument_reader(RecognisedBy.NOTHING, lambda path, head: True)
