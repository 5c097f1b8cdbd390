"""Captions and alternative texts of the charts: their main numbers in words.

They are taken from the statistics of one surface, with its loads rising.
"""

import xarray as xr

from roughcontact.arguments.answers import TITLES, UNITS
from roughcontact.report.units import is_unbounded, number_text, stated_loads, unit_of


def answers_caption(numbers: xr.Dataset, *names: str) -> str:
    """Return quantities at the lowest and at the highest load, with the digits of the tables.

    Examples
    --------
    >>> gaps = {"mean_gap": ("load", [2e-6, 1e-6]), "rms_height": 1e-6, "contact_modulus": 1e11}
    >>> answers_caption(xr.Dataset(gaps | {"mean_pressure": ("load", [1e6, 5e6])}), "mean_gap")
    'Mean gap 2.00 µm at 1.00 MPa, 1.00 µm at 5.00 MPa.'
    """
    loads, texts = stated_loads(numbers).texts, []
    for name in names:
        if name in numbers:
            unit, values = unit_of(numbers, UNITS[name]), []
            for index in dict.fromkeys([0, len(loads) - 1]):
                value = f"{number_text(numbers, name, unit, index)} {unit.symbol}".strip()
                values.append(f"{value} at {loads[index]}")
            texts.append(f"{TITLES[name]} {', '.join(values)}")
    text = "; ".join(texts)
    return f"{text[:1].upper()}{text[1:]}." if text else ""


def bars_in_words(numbers: xr.Dataset, *names: str) -> str:
    """Return how the bars of these quantities in a figure are to be read, where there are any."""
    available = [name for name in names if f"{name}_lower" in numbers]
    arrow = any(is_unbounded(numbers, name) for name in available)
    return f"Bars: the ±{'; an arrow: nothing bounds it upwards' * arrow}." if available else ""
