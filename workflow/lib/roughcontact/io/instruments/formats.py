"""The instrument formats that SurfaceTopography reads, from `formats.tsv`: their marks and vendors."""

from typing import NamedTuple

from roughcontact.io import instrument_kinds
from roughcontact.io.instruments.rules import RULES, Rules
from roughcontact.io.text.lines import looks_like_text
from roughcontact.io.vocabulary import marks, rows_of


class Format(NamedTuple):
    """One row of the table."""

    name: str  # in the library
    marks: tuple[bytes, ...]
    offset: int
    kind: instrument_kinds.Kind  # of the instrument that writes it
    text: str  # `no`, `text`, `binary`
    vendor: str

    @property
    def rules(self) -> Rules:
        """What the library does not know of the format."""
        return RULES.get(self.name, Rules())

    def has_mark(self, head: bytes) -> bool:
        """Return whether a file that begins with `head` has the mark of this format."""
        return head.startswith(self.marks, self.offset) and (self.text != "no" or not looks_like_text(head))


FORMATS = [
    Format(name, marks(listed), int(offset), getattr(instrument_kinds, kind), text, vendor)
    for name, listed, offset, kind, text, vendor in rows_of("formats.tsv")
]


def marked(head: bytes) -> list[Format]:
    """Return the formats whose mark a file has, in the order in which they are tried.

    Examples
    --------
    >>> [each.name for each in marked(b"II*" + bytes(100))]
    ['ps', 'jpk', 'lext']
    >>> marked(b"KPK0 is how this text begins")
    []
    """
    return [format_ for format_ in FORMATS if format_.has_mark(head)]
