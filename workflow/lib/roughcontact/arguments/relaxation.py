"""Relaxation of a rubber: a Prony series, stated or fitted to a table of a DMA, shifted to a temperature.

A series E(t) = E_0 + sum E_k exp(-t/tau_k) of positive moduli is causal and dissipates at every frequency.
Storage and loss modulus of one linear material obey the relations of Kramers and Kronig and are those of such
a series, so that what a fit to both leaves over tells how far a table is from such a material.
"""

import csv
import re
from collections.abc import Mapping
from dataclasses import dataclass, replace
from itertools import pairwise
from pathlib import Path
from typing import Any

import numpy as np
import pandas as pd
import scipy

from roughcontact.arguments.bodies import check_poissons_ratio
from roughcontact.arguments.checking import check_positive
from roughcontact.arguments.named_materials import compound, compound_names
from roughcontact.arguments.si import convert_quantity
from roughcontact.arguments.units import celsius, unit_factor, unknown_unit
from roughcontact.errors import SettingsError

TERMS_PER_DECADE = 10
MAX_MISFIT = 0.1  # rms, relative: beyond, E' and E'' are not those of one linear material
_MAX_WARMING = 200.0  # K over the reference: more is another scale
RUBBER_RATIO = 0.5  # Poisson's, where none is stated
# heading -> column, base unit, and what its units stand for: 1/s is Hz of f, and rad/s of omega
_HEADINGS: dict[str, tuple[str, str, dict[str, str]]] = {
    r"(?i:f|freq\.?|frequency|frequenz)": ("frequency", "s-1", {"": "Hz", "1/s": "Hz"}),
    r"(?i:omega|ω|angular frequency|kreisfrequenz)": ("frequency", "s-1", {"": "rad/s", "1/s": "rad/s"}),
    r"(?i:e['′]|storage( modulus)?|speichermodul)": ("storage_modulus", "Pa", {"": "Pa"}),
    r"(?i:e(''|″|\")|loss( modulus)?|verlustmodul)": ("loss_modulus", "Pa", {"": "Pa"}),
    r"T|(?i:temp\.?|temperatur|temperature)": ("temperature", "", {}),
}
_STEADY = 5.0  # K, within which a sweep is of one temperature
_SOFTEST = 1e3  # Pa: a lower modulus is in MPa, or a logarithm
_ALIKE = 0.01  # relative difference of two columns of one thing
_SERIES = {"long_time_modulus": "Pa", "moduli": "Pa", "times": "s"}
KEYS = {*_SERIES, "table", "wlf", "reference_temperature", "temperature"}


@dataclass(frozen=True)
class Relaxation:
    """E(t) = long_time_modulus + sum of moduli exp(-t/times), Young's moduli (Pa) and times (s)."""

    long_time_modulus: float
    moduli: np.ndarray
    times: np.ndarray
    poissons_ratio: float = RUBBER_RATIO
    misfit: float = 0.0  # rms relative difference of E' and E'' from the table
    frequencies: tuple[float, float] = (0.0, np.inf)  # 1/s, angular: the range of the table

    def contact_modulus(self, frequency: np.ndarray) -> np.ndarray:
        """Return the complex E* = E/(1 - nu^2) (Pa) at angular frequencies (1/s), of exp(i omega t)."""
        phase = 1j * np.asarray(frequency, float)[..., None] * self.times
        young: np.ndarray = self.long_time_modulus + (phase / (1 + phase)) @ self.moduli
        return young / (1 - self.poissons_ratio**2)

    def compliance(self, frequency: np.ndarray) -> np.ndarray:
        """Return the complex 1/E* (1/Pa) at angular frequencies (1/s)."""
        return np.reciprocal(self.contact_modulus(frequency))

    def creep_modulus(self, time: float) -> float:
        """Return the inverse (Pa) of the creep compliance after a time (s), with that of the table in it.

        J(t) = 1/E_0 - sum exp(-r t)/(r^2 dE/dr), r the rates at which the modulus E(s = -r) is zero: one
        below each rate of relaxation (Tschoegl 1989, The Phenomenological Theory of Linear Viscoelastic
        Behavior, chapter 3).
        """
        shortest, longest = (1 / limit if limit else np.inf for limit in self.frequencies[::-1])
        if not shortest <= time <= longest:
            raise SettingsError(
                f"relaxation: after {time:g} s the creep is not known, its table is of {shortest:.2g} to "
                f"{longest:.2g} s; choose times between, or extend the table",
                keys=["time"],
            )
        poles, index = np.unique(1 / self.times, return_inverse=True)
        moduli, plateau = np.bincount(index, self.moduli), self.long_time_modulus

        def modulus(logarithm: float) -> float:
            rate = np.exp(logarithm)
            return float(plateau + (moduli * rate / (rate - poles)).sum())

        lowest = poles[0] * plateau / (2 * (plateau + moduli.sum()))
        compliance = 1 / plateau
        for below, above in pairwise(np.log([lowest, *poles])):
            rate = np.exp(scipy.optimize.brentq(modulus, below + 1e-12, above - 1e-12))
            compliance -= np.exp(-rate * time) / (rate * (moduli * poles / (poles - rate) ** 2).sum())
        return float(1 / compliance)

    def stiffer(self, factor: float) -> "Relaxation":
        """Return it with moduli `factor` times as large."""
        return replace(self, long_time_modulus=factor * self.long_time_modulus, moduli=factor * self.moduli)

    def at_rest(self) -> float:
        """Return Young's modulus (Pa) at the lowest frequency that is known."""
        return float(self.contact_modulus(np.array(self.frequencies[0])).real * (1 - self.poissons_ratio**2))


def relaxation_of(relaxation: Any, *, poissons_ratio: float = RUBBER_RATIO) -> Relaxation:
    """Return the relaxation that a name, a table (path or DataFrame) or a mapping states.

    Examples
    --------
    >>> rubber = relaxation_of({"long_time_modulus": 3e6, "moduli": [27e6], "times": [1e-4]})
    >>> print(np.abs(rubber.contact_modulus(np.array([0.0, 1e9]))).round(-5) / 1e6)
    [ 4. 40.]
    """
    if isinstance(relaxation, Relaxation):
        return relaxation
    ratio = check_poissons_ratio("poissons_ratio", poissons_ratio)
    properties = dict(relaxation) if isinstance(relaxation, Mapping) else {"table": relaxation}
    if "table" in properties and (series_keys := [key for key in _SERIES if properties.get(key) is not None]):
        raise _refusal(f": a table and {series_keys[0]} of a Prony series given; give one of them")
    if unknown := {*properties} - KEYS:
        raise _refusal(
            f".{min(unknown)}: unknown; give long_time_modulus, moduli and times of a Prony series, or the "
            "table of a DMA; for another temperature wlf, reference_temperature, temperature"
        )
    named = compound(properties.get("table"))
    is_table = "table" in properties and not named
    series = _fitted(properties["table"], ratio) if is_table else _series(named or properties, ratio)
    factor = _shift(named | properties if "temperature" in properties else properties)
    low, high = series.frequencies
    return replace(series, times=series.times * factor, frequencies=(low / factor, high / factor))


def with_modulus_at_rest(body: Mapping[str, Any]) -> dict[str, Any]:
    """Return a body that states its relaxation with its modulus at rest, and its name, where it has none.

    Examples
    --------
    >>> series = {"long_time_modulus": 3e6, "moduli": [27e6], "times": [1e-4]}
    >>> rubber = with_modulus_at_rest({"relaxation": series})
    >>> print(rubber["youngs_modulus"], rubber["poissons_ratio"])
    3000000.0 0.5
    """
    properties = {key: value for key, value in body.items() if value is not None}
    relaxation = properties["relaxation"]
    named = compound(relaxation.get("table") if isinstance(relaxation, Mapping) else relaxation)
    name = {"name": named["name"]} if named else {}
    modulus = properties.get("youngs_modulus") or relaxation_of(relaxation).at_rest()
    return {"poissons_ratio": RUBBER_RATIO} | name | properties | {"youngs_modulus": modulus}


def read_relaxation(table: str | Path | pd.DataFrame) -> pd.DataFrame:
    """Return a table of a DMA: angular `frequency` (1/s, rising), `storage_modulus`, `loss_modulus` (Pa).

    Headings name what a column holds, with its unit in brackets, after a comma, a stroke or "in", or in the
    row below: "f (Hz)", "E' [MPa]". Without one, frequencies are in Hz and moduli in Pa. Tabs, semicolons,
    commas or wide gaps separate the columns of a file; decimals may have commas.

    Examples
    --------
    >>> table = pd.DataFrame({"f (Hz)": [1, 10, 100], "E' (MPa)": [3, 4, 5], "E'' (MPa)": [0.3, 0.5, 0.6]})
    >>> read_relaxation(table).round(2).values.tolist()[0]
    [6.28, 3000000.0, 300000.0]
    """
    name = f" = {'the table' if isinstance(table, pd.DataFrame) else table}"
    if not isinstance(table, pd.DataFrame):
        try:
            table = _table_of_text(Path(table).read_text(encoding="utf-8-sig", errors="replace"))
        except (OSError, TypeError, ValueError) as error:
            raise _refusal(
                f"{name}: not read as a table: {str(error).strip()}; give a table (path or DataFrame), a "
                f"mapping, or a name: {', '.join(compound_names())}"
            ) from None
    columns = _columns(table, name)
    if missing := [column for column, *_ in _HEADINGS.values() if column not in {*columns, "temperature"}]:
        raise _refusal(
            f"{name}: no column {missing[0]!r} among {[*map(str, table.columns)]}; name the columns "
            "frequency (Hz), storage_modulus (Pa), loss_modulus (Pa), or f, E', E'', with units"
        )
    rows = pd.DataFrame(columns).dropna(how="all").sort_values("frequency", ignore_index=True)
    temperatures = rows.pop("temperature") if "temperature" in rows else rows["frequency"][:0]
    if temperatures.max() - temperatures.min() > _STEADY:
        raise _refusal(
            f"{name}: its temperatures are {temperatures.min():g} to {temperatures.max():g}; give the rows "
            "of one, or of a master curve, whose frequencies are shifted to one, leave this column out"
        )
    if (wrong := rows[~((rows > 0) & np.isfinite(rows)).all(axis=1)]).size:
        text = ", ".join(f"{key} {value:g}" for key, value in wrong.iloc[0].items())
        raise _refusal(f"{name}: a row has {text}; complete it with numbers above 0, or leave it out")
    if (number := rows["frequency"].nunique()) < 3:
        raise _refusal(f"{name}: {number} frequencies; give a sweep over three or more")
    return rows[["frequency", "storage_modulus", "loss_modulus"]]


def _columns(table: pd.DataFrame, name: str) -> dict[str, pd.Series]:
    """Return the columns of a table by what their headings say that they hold, in base units."""
    columns: dict[str, pd.Series] = {}
    headings: dict[str, Any] = {}
    for heading in table.columns:
        plain, unit, (column, base, usual) = _role(heading)
        if not column:
            continue
        factor = unit_factor(usual.get(unit, unit), base) if base else 1.0
        if factor is None:
            raise _refusal(f"{name}, column {heading!r}: {unknown_unit(unit, base)}")
        values = pd.to_numeric(table[heading], errors="coerce")
        if (wrong := table[heading][values.isna() & table[heading].notna()]).size:
            raise _refusal(f"{name}, column {heading!r}: {wrong.iloc[0]!r} is not a number")
        numbers = values * factor
        # a gel may lose less in each cycle
        if numbers.min() < _SOFTEST and (column == "storage_modulus" or (base == "Pa" and not unit)):
            raise _refusal(
                f"{name}, column {heading!r}: {numbers.min():g} Pa is softer than any rubber: give moduli, "
                f"no logarithms, with their unit, {plain} (MPa)"
            )
        if column in columns and not np.allclose(columns[column], numbers, rtol=_ALIKE):
            raise _refusal(
                f"{name}: columns {headings[column]!r} and {heading!r} are unlike, and both are the "
                f"{column}; leave one out"
            )
        columns[column], headings[column] = numbers, heading
    return columns


def _role(heading: Any) -> tuple[str, str, tuple[str, str, dict[str, str]]]:
    """Return a heading without its unit, this, and what `_HEADINGS` has of it, if anything.

    The unit stands after a bracket, a comma, a stroke or "in".
    """
    text = str(heading).replace("_", " ").replace("’", "'").strip().lstrip('"')
    plain, *unit = re.split(r"\s*[\[(,/]\s*|\s+in\s+", text, maxsplit=1)
    roles = (role for form, role in _HEADINGS.items() if re.fullmatch(form, plain))
    return plain, "".join(unit).strip(" )]"), next(roles, ("", "", {}))


def _table_of_text(text: str) -> pd.DataFrame:
    """Return a table with headings, and units in them that stand in a row below.

    Lines above that of the headings are left out, and those that begin with #.
    """
    # a separator may end each line
    lines = [line.strip().rstrip("\t;,") for line in text.splitlines() if not line.startswith("#")]
    lines = [line for line in lines if line]

    def has_frequency(line: str) -> bool:
        roles = (_role(cell)[2] for cell in re.split(r"[\t;,]|\s{2,}", line))
        return any(column == "frequency" for column, *_ in roles)

    lines = lines[next((index for index, line in enumerate(lines) if has_frequency(line)), 0) :]
    if len(lines) < 2:
        raise ValueError("no rows of numbers below a heading")
    if not set("\t;,") & {*lines[0]}:
        lines = [re.sub(r"\s{2,}", "\t", line) for line in lines]
    separator = next((mark for mark in "\t;" if mark in lines[0]), ",")
    if separator != "," and "." not in "".join(lines[1:]):  # a comma is then a decimal one
        lines[1:] = [line.replace(",", ".") for line in lines[1:]]
    headings, *rows = csv.reader(lines, delimiter=separator, skipinitialspace=True)
    if not re.search(r"\d", "".join(rows[0])):
        pairs = zip(headings, rows.pop(0), strict=False)
        headings = [f"{heading} ({unit.strip(' []()')})" for heading, unit in pairs]
    return pd.DataFrame(rows, columns=headings).replace("", None)


def _fitted(table: str | Path | pd.DataFrame, ratio: float) -> Relaxation:
    """Return the series of positive moduli nearest to a table, in relative terms (Lawson and Hanson 1974)."""
    frequency, storage, loss = read_relaxation(table).to_numpy().T
    low, high = frequency[[0, -1]]
    decades = np.log10(high / low) + 2  # relaxation up to a decade beyond the table shows in it
    times = np.geomspace(0.1 / high, 10 / low, max(2, round(TERMS_PER_DECADE * decades)))
    phase = 1j * np.outer(frequency, times)
    share = np.column_stack([np.ones_like(frequency), phase / (1 + phase)])
    rows = np.vstack([share.real / storage[:, None], share.imag / loss[:, None]])
    (plateau, *moduli), residual = scipy.optimize.nnls(rows, np.ones(len(rows)))
    if plateau <= 0:  # no plateau within the table: the lowest modulus is all that is known of it
        plateau = 1e-3 * storage[0]
    used = np.array(moduli) > 0
    misfit = float(residual) / np.sqrt(len(rows))
    return Relaxation(float(plateau), np.array(moduli)[used], times[used], ratio, misfit, (low, high))


def _series(properties: Mapping[str, Any], ratio: float) -> Relaxation:
    """Return a Prony series that is stated, or of the table of compounds, with the range of its data."""
    numbers: dict[str, np.ndarray] = {}
    for key, unit in _SERIES.items():
        name = f"relaxation.{key}"
        if properties.get(key) is None:
            raise _refusal(f".{key}: missing from the Prony series")
        values = (convert_quantity(unit, name, number) for number in np.ravel(properties[key]).tolist())
        numbers[key] = np.array([check_positive(name, value, unit=unit) for value in values])
    plateau, moduli, times = numbers.values()
    if moduli.size != times.size:
        raise _refusal(f": {moduli.size} moduli and {times.size} times; give a time for each modulus")
    low, high = properties.get("frequencies", (0.0, np.inf))
    return Relaxation(float(plateau[0]), moduli, times, ratio, properties.get("misfit", 0.0), (low, high))


def _shift(properties: Mapping[str, Any]) -> float:
    """Return the factor of all times by the temperature, log10 a = -C1 (T - T0)/(C2 + T - T0).

    Williams, Landel and Ferry (1955), J. Am. Chem. Soc. 77, 3701.
    """
    keys = ("wlf", "reference_temperature", "temperature")
    given_keys = [key for key in keys if properties.get(key) is not None]
    if not given_keys:
        return 1.0
    if len(given_keys) < len(keys) or np.shape(properties["wlf"]) != (2,):
        raise _refusal(
            ": another temperature needs wlf = [C1, C2 (K)], reference_temperature and temperature, both in "
            f"°C or both in K; given: {', '.join(given_keys)}"
        )
    try:
        c1, c2 = (float(str(constant).removesuffix("K")) for constant in properties["wlf"])
        difference = celsius(properties["temperature"]) - celsius(properties["reference_temperature"])
    except (TypeError, ValueError) as error:
        text = ", ".join(f"{key} = {properties[key]!r}" for key in keys)
        raise _refusal(f": {text}: {error}") from None
    if not -c2 < difference <= _MAX_WARMING:
        side = "above" if difference > 0 else "below"
        raise _refusal(
            f".temperature is {abs(difference):g} K {side} its reference, and "
            f"the law of Williams, Landel and Ferry holds over about 100 K, and ends {c2:g} K below it; give "
            "both in °C or both in K, or each with its own (20 °C, 293 K); without a scale it is that of the "
            "reference, °C of a rubber by its name"
        )
    return float(10 ** (-c1 * difference / (c2 + difference)))


def _refusal(text: str) -> SettingsError:
    """Return the error of a relaxation, whose message goes on with this text."""
    return SettingsError(f"relaxation{text}", keys=["relaxation"])
