"""Kinds of instruments, and the steps, fields and heights that each of them can measure.

The ranges follow the largest scanners, stages and columns that are sold, and the finest sampling that makes
sense: a value outside them is more likely due to a wrong unit.
"""

from typing import NamedTuple


class Kind(NamedTuple):
    """One kind of instrument, with the ranges (lowest, highest; m) of step, side and span of heights."""

    name: str
    step: tuple[float, float]
    field: tuple[float, float]
    span: tuple[float, float]

    @property
    def words(self) -> str:
        """The kind with its article, for a sentence."""
        name = self.name or "roughness measurement"
        return f"{'an' if name[0] in 'aeiou' else 'a'} {name}"


# Scanners of atomic force and tunnelling microscopes reach 100 to 200 µm, along z 50 µm at most.
PROBE = Kind("scanning probe microscope", step=(1e-12, 5e-6), field=(1e-10, 5e-4), span=(1e-12, 1e-4))
# Light resolves 0.2 µm; stitched fields and Fizeau interferometers reach decimetres, columns 0.1 m.
OPTICAL = Kind("optical profiler", step=(1e-8, 1e-3), field=(1e-6, 0.7), span=(1e-11, 0.15))
# Traces of up to 0.3 m, tips of 0.1 to 10 µm radius, ranges of up to 50 mm.
STYLUS = Kind("stylus profiler", step=(1e-9, 1e-3), field=(1e-6, 0.5), span=(1e-10, 0.1))
# where the file does not name the instrument
UNKNOWN = Kind("", step=(1e-12, 1e-2), field=(1e-10, 1.0), span=(1e-12, 0.15))


def of_name(name: str | None) -> Kind:
    """Return the kind that a file's `instrument` names, `UNKNOWN` where it names none.

    Examples
    --------
    >>> of_name("optical profiler").words, of_name(None) is UNKNOWN
    ('an optical profiler', True)
    """
    return {kind.name: kind for kind in (PROBE, OPTICAL, STYLUS)}.get(name or "", UNKNOWN)
