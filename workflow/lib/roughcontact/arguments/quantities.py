"""Numbers as people read them: SI prefixes, few digits, no long exponents."""

import math
from collections.abc import Mapping
from typing import NamedTuple

from roughcontact.errors import SettingsError

_PREFIXES = {-15: "f", -12: "p", -9: "n", -6: "µ", -3: "m", 0: "", 3: "k", 6: "M", 9: "G", 12: "T"}
_ROUNDING = 1e-12
_MAX_ASYMMETRY = 0.1  # largest relative difference of the two half-widths that are written as ±
_UNEVEN = 0.1  # the wider of two half-widths carries one digit less than the narrower at most
_END_NOTATION_FROM = 9.0  # half-width upwards over the value from which on an interval is written by its ends
_NEGLIGIBLE = 1e-9  # of a unit: a half-width about zero that is not worth writing
_FINEST = 1e-3  # of a value: half-width of which two digits are shown, of narrower ones less
_SUPERSCRIPT = str.maketrans("-0123456789", "⁻⁰¹²³⁴⁵⁶⁷⁸⁹")
# units that take a prefix; composed ones are given in powers of ten
_PREFIXED = ("m", "Pa", "N", "J", "W", "S", "l", "Ω", "K/W")


class Unit(NamedTuple):
    """A unit in which numbers are shown: the factor for values in SI, and its symbol."""

    factor: float
    symbol: str

    def text(self, value: float) -> str:
        """Return a value (SI) with this unit, three significant digits.

        Parameters
        ----------
        value : float

        Returns
        -------
        str

        Examples
        --------
        >>> Unit(1e-6, "MPa").text(1.43e10)
        '14300 MPa'
        >>> Unit(1.0, "").text(0.35)
        '0.350'
        """
        return f"{number(value * self.factor)} {self.symbol}".rstrip()

    def interval(self, value: float, lower: float, upper: float) -> str:
        """Return a value (SI) with its interval in this unit, as `with_interval` writes it.

        Parameters
        ----------
        value, lower, upper : float

        Returns
        -------
        str
        """
        return with_interval(value * self.factor, lower * self.factor, upper * self.factor)

    def ends(self, lower: float, upper: float) -> str:
        """Return an interval (SI) by its ends with this unit, a dash where neither is known.

        Parameters
        ----------
        lower, upper : float

        Returns
        -------
        str
        """
        is_finite = math.isfinite(lower) or math.isfinite(upper)
        return f"{self.interval(math.nan, lower, upper)} {self.symbol}" if is_finite else "–"


def prefix(value: float, unit: str) -> tuple[float, str]:
    """Return the SI prefix that brings a value between 1 and 1000, where there is one.

    Parameters
    ----------
    value : float
        in `unit`; zero, infinity and NaN get no prefix.
    unit : str
        m, Pa, N, J, W, S, l, Ω and K/W take a prefix; others are left as they are.

    Returns
    -------
    factor : float
        by which the value is to be multiplied.
    shown : str
        the unit with its prefix.

    Examples
    --------
    >>> prefix(2.5e7, "Pa")
    (1e-06, 'MPa')
    >>> prefix(1500.0, "m")
    (0.001, 'km')
    """
    if unit not in _PREFIXED or not math.isfinite(value) or value == 0:
        return 1.0, unit
    # 999.95 would be shown as 1000
    power = 3 * math.floor(math.log10(abs(value) * (1 + 5e-5)) / 3)
    if power < min(_PREFIXES):
        return 1.0, unit
    power = min(power, max(_PREFIXES))
    return float(f"1e{-power}"), _PREFIXES[power] + unit


def quantity(value: float, unit: str = "1", *, digits: int = 3) -> str:
    """Return a number and its unit, as in ``12.3 MPa``.

    Parameters
    ----------
    value : float
        in `unit`.
    unit : str
        "1" for a bare number.
    digits : int
        significant digits.

    Returns
    -------
    str

    Examples
    --------
    >>> quantity(1.2345e-6, "m"), quantity(1500.0, "m", digits=2), quantity(0.25)
    ('1.23 µm', '1.5 km', '0.250')
    """
    factor, symbol = prefix(value, unit)
    text = number(value * factor, digits=digits)
    return text if unit == "1" else f"{text} {symbol}"


def pressure_unit(contact_modulus: float, heaviest_load: float = 0.0) -> Unit:
    """Return the unit of all pressures between bodies of a contact modulus, up to a load.

    So loads, pressures and hardness of one contact, and of other surfaces of the same bodies, have the same
    unit and can be compared.

    Parameters
    ----------
    contact_modulus : float, Pa
        E*; NaN where it is not known.
    heaviest_load : float, Pa
        the largest mean pressure.

    Returns
    -------
    Unit
        MPa; kPa of moduli below 10 MPa (soft rubber) and loads below 1 MPa, Pa of moduli below 100 kPa (gels)
        and loads below 1 kPa.

    Examples
    --------
    >>> pressure_unit(115e9).symbol, pressure_unit(2e6).symbol, pressure_unit(1e3).symbol
    ('MPa', 'kPa', 'Pa')
    >>> pressure_unit(2e6, 2e6).symbol
    'MPa'
    """
    # one unit for all pressures of a page, whatever each would have by itself
    if contact_modulus < 1e5 and heaviest_load < 1e3:
        return Unit(1.0, "Pa")
    return Unit(1e-3, "kPa") if contact_modulus < 1e7 and heaviest_load < 1e6 else Unit(1e-6, "MPa")


def height_unit(rms_height: float) -> Unit:
    """Return the unit of all heights and gaps of a surface, whatever their size.

    Parameters
    ----------
    rms_height : float, m
        of the solved window; zero or NaN where there is none.

    Returns
    -------
    Unit
        µm, as roughness is specified; nm, mm and m far from that.

    Examples
    --------
    >>> height_unit(3e-7).symbol, height_unit(3e-8).symbol, height_unit(0.04).symbol
    ('µm', 'nm', 'mm')
    """
    if 0 < rms_height < 1e-7:
        return Unit(1e9, "nm")
    if rms_height >= 2e-3:
        # a wavy map of metres is no roughness, and its numbers are still right
        return Unit(1e3, "mm") if rms_height < 2 else Unit(1.0, "m")
    return Unit(1e6, "µm")


def number(value: float, *, digits: int = 3, decimals: int | None = None) -> str:
    """Return a number with so many significant digits, in powers of ten only where it would be long.

    Parameters
    ----------
    value : float
    digits : int
        significant digits; those before the decimal point are never rounded away.
    decimals : int or None
        decimal places at most, where fewer digits remain.

    Returns
    -------
    str
        "–" for NaN.

    Examples
    --------
    >>> number(0.04567), number(12345.6), number(3.2e-7), number(1e-4, digits=1)
    ('0.0457', '12346', '3.20×10⁻⁷', '1×10⁻⁴')
    >>> number(0.04567, decimals=2), number(45.67, decimals=2)
    ('0.05', '45.7')
    """
    if math.isnan(value):
        return "–"
    if math.isinf(value):
        return "∞" if value > 0 else "−∞"
    if value == 0:
        return "0"
    # by the format, which rounds before the power is known
    mantissa, _, exponent = f"{value:.{digits - 1}e}".partition("e")
    power = int(exponent)
    if decimals is not None and digits - 1 - power > decimals:
        return _fixed(value, decimals)  # places rather than digits
    if -3 <= power < 6:
        return f"{value:.{max(digits - 1 - power, 0)}f}".replace("-", "−")
    return f"{mantissa.replace('-', '−')}×10{str(power).translate(_SUPERSCRIPT)}"


def with_interval(value: float, lower: float, upper: float, *, finest: float = 0.0) -> str:
    """Return a value with its interval: ± where it is about symmetric, else − and +, or by its ends.

    The value has the digits that its interval carries, five at most; an end equal to the value at these
    digits is left out, since nothing is certain to ± 0. Ends stand in brackets where the interval reaches
    beyond ten times the value, a lower end would read as 0 and is not, and where nothing bounds one: "or
    more", "or less".

    Parameters
    ----------
    value, lower, upper : float
        in the same unit; an interval that is not around the value is left out, an end that is NaN or infinite
        is unbounded. NaN as value gives the ends alone, "–" where there are none.
    finest : float
        half-width of which two digits are shown at the finest.

    Returns
    -------
    str

    Examples
    --------
    >>> with_interval(0.412, 0.321, 0.502), with_interval(0.412, 0.321, 0.744), with_interval(1.2, 0.0, 2.5)
    ('0.412 ± 0.091', '0.412 −0.091 +0.33', '1.2 −1.2 +1.3')
    >>> with_interval(300.0, 240.0, 300.0 + 1e-13), with_interval(300.0, 299.9999, 300.0)
    ('300 −60', '300.00')
    >>> with_interval(1.7, 1.2, math.nan), with_interval(0.0028, 0.0, 0.33), with_interval(0.0, 0.0, 4.4e-7)
    ('1.70 (1.20 or more)', '0.0028 (0 to 0.33)', '0 (0 to 4.4×10⁻⁷)')
    >>> with_interval(7.33, 0.029, 18.6), with_interval(7.33, 0.0, 18.6)
    ('7.3 (0.029 to 19)', '7.3 −7.3 +11')
    """
    try:
        value, lower, upper, finest = map(float, (value, lower, upper, finest))
    except (TypeError, ValueError) as error:
        stated = f"value = {value!r}, lower = {lower!r}, upper = {upper!r}, finest = {finest!r}"
        raise SettingsError(f"{stated}: give numbers, NaN for what is not known ({error})") from error
    if math.isnan(value):
        half = max((upper - lower) / 2, finest)  # without a value: both ends
        return range_in_words(*(_end(bound, half, 3) for bound in (lower, upper)))
    below = 0.0 if math.isclose(lower, value, rel_tol=_ROUNDING) else value - lower
    above = 0.0 if math.isclose(upper, value, rel_tol=_ROUNDING) else upper - value
    wider, narrower = max(below, above), min(below, above)
    zero = value == below == 0.0 and above > _NEGLIGIBLE  # has no digits that an end could carry
    # about symmetric, or one half alone; what is not negative is not known to more than itself
    positive_alone = lower >= 0 and wider > value * (1 + _ROUNDING)
    even = narrower < 0 or (narrower >= (1 - _MAX_ASYMMETRY) * wider and not positive_alone)
    wider_side = max(wider if even else max(narrower or wider, _UNEVEN * wider), finest)
    if lower > 0 and below > 0 and wider < math.inf:  # would read as 0, and is not
        zero = lower < 10.0 ** -_decimal_places(max(wider_side, below))
    # a half-width of many times the value says nothing: both ends do
    if math.isfinite(lower) != math.isfinite(upper) or above > _END_NOTATION_FROM * value > 0 or zero:
        wider_side = max(below if math.isfinite(lower) else above, finest)
        digits = 2 if _is_long(value) else 3
        text = _format_half_widths(value, {}, wider_side) if 0 < wider_side < math.inf and digits > 2 else ""
        range_text = range_in_words(
            *(_end(bound, max(abs(half), finest), 2) for bound, half in ((lower, below), (upper, above)))
        )
        # the value is one of the ends
        interval = f"({range_text})" if wider_side or " to " in range_text else range_text.partition(" ")[2]
        return f"{text or number(value, digits=digits)} {interval}"
    if not math.isfinite(wider) or wider <= (0 if value else _NEGLIGIBLE):
        return number(value)
    if even:
        return _format_half_widths(value, {" ± ": wider}, wider_side)
    return _format_half_widths(value, {" −": below, " +": above}, wider_side)


def range_in_words(low: str, high: str) -> str:
    """Return an interval by the texts of its ends.

    Parameters
    ----------
    low, high : str
        empty for one that nothing bounds.

    Returns
    -------
    str
        "–" where nothing bounds either; ends that read the same are one number.

    Examples
    --------
    >>> range_in_words("1.2 MPa", "3.4 MPa"), range_in_words("1.2 MPa", "")
    ('1.2 MPa to 3.4 MPa', '1.2 MPa or more')
    >>> range_in_words("100 %", "100 %")
    '100 %'
    """
    if low and high:
        return low if low == high else f"{low} to {high}"
    return f"{low} or more" if low else f"{high} or less" if high else "–"


def _end(bound: float, half_width: float, digits: int) -> str:
    """Return an end of an interval to two digits of its half-width, and to so many of its own at least."""
    if not math.isfinite(bound):
        return ""
    if abs(bound) <= _ROUNDING * half_width < math.inf:
        return "0"
    if _is_long(bound) or not 0 < half_width < math.inf:
        return number(bound, digits=digits)
    return _fixed(
        bound,
        max(_decimal_places(max(half_width, _FINEST * abs(bound))), _decimal_places(abs(bound)) + digits - 2),
    )


def _is_long(value: float) -> bool:
    """Return whether a number would be long without a power of ten."""
    return 0 < abs(value) < 1e-4 or 1e6 <= abs(value) < math.inf


def _format_half_widths(value: float, sides: Mapping[str, float], decisive: float) -> str:
    """Return a value and its half-widths, by their signs, to the places of two digits of one `decisive`."""
    decimals = _decimal_places(max(decisive, _FINEST * abs(value)))
    if not -6 <= decimals <= 8:
        return number(value) + "".join(
            f"{sign}{number(half, digits=2)}" for sign, half in sides.items() if half > 0
        )
    return _fixed(value, decimals) + "".join(
        f"{sign}{_fixed(half, min(decimals, _decimal_places(half)))}"
        for sign, half in sides.items()
        if round(half, decimals) > 0
    )


def _decimal_places(half_width: float) -> int:
    """Return the decimal places of two digits of a positive number."""
    # rounded first: 0.0996 has the places of 0.10
    return 1 - math.floor(math.log10(float(f"{half_width:.1e}")))


def _fixed(value: float, decimals: int) -> str:
    """Return a number rounded to decimal places, which may be negative; there is no -0."""
    # + 0.0: minus zero becomes zero
    return f"{round(value, decimals) + 0.0:.{max(decimals, 0)}f}".replace("-", "−")


def percent(share: float, *, digits: int = 3) -> str:
    """Return a share in percent.

    Parameters
    ----------
    share : float
        1 is the whole.
    digits : int
        significant digits.

    Returns
    -------
    str

    Examples
    --------
    >>> percent(0.12345), percent(0.0001234)
    ('12.3 %', '0.0123 %')
    """
    return f"{number(100 * share, digits=digits)} %"


def counted_noun(count: int, noun: str) -> str:
    """Return a number of things in words that agree with it.

    Parameters
    ----------
    count : int
    noun : str
        in the singular; its plural ends in s.

    Returns
    -------
    str

    Examples
    --------
    >>> counted_noun(0, "point"), counted_noun(1, "point"), counted_noun(2, "point")
    ('0 points', '1 point', '2 points')
    """
    return f"{count} {noun}" if count == 1 else f"{count} {noun}s"
