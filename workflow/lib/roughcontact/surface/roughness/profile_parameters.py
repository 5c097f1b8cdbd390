"""Parameters of levelled profiles: ISO 21920-2."""

import math

import numpy as np
import xarray as xr

from roughcontact.arguments.checking import check_map
from roughcontact.arguments.maps import spacing
from roughcontact.arguments.measurement import json_attribute
from roughcontact.arguments.si import as_si
from roughcontact.errors import HeightMapError
from roughcontact.surface.roughness.bearing import bearing_parameters

_DISCRIMINATION = 0.1  # of Rz: lower hills and shallower dales belong to their neighbours (ISO 4287, 3.2.7)
_CORE = {"k": "Sk", "pk": "Spk", "vk": "Svk", "mr1": "Smr1", "mr2": "Smr2"}


@as_si
def profile_parameters(profiles: xr.DataArray) -> dict[str, float]:
    """Return the parameters of ISO 21920-2 [1]_ of one profile, or their means over several.

    Of profiles with an L-filter (`level(..., l_filter=...)`) they are those of the roughness profile (`Ra`),
    with sections as long as the nesting index. Without one they are those of the primary profile (`Pa`), with
    one section. With z the height above the mean line, for R:

    * `Ra` = mean |z|, `Rq` = sqrt(mean z^2), `Rt` = max z - min z, m
    * `Rsk` = mean z^3 / Rq^3, `Rku` = mean z^4 / Rq^4; NaN for a flat profile
    * `Rp`, `Rv`, `Rz`: highest hill, deepest dale and their sum in a section, mean over the whole sections
      from the start on, m; the rest counts in `Rt`
    * `Rsm`: mean width of the profile elements, from one crossing upwards to the next, m; hills and dales
      that stay within 10 % of Rz of the mean line do not count. NaN for fewer than two crossings
    * `Rdq` = sqrt(mean (dz/dx)^2), from differences of neighbouring points
    * `Rk`, `Rpk`, `Rvk` (m), `Rmr1`, `Rmr2`: see `bearing.bearing_parameters`

    Parameters
    ----------
    profiles : DataArray (y, x), m
        one levelled profile, or several as rows; points that are missing (NaN) or filled do not count.

    Returns
    -------
    dict of float
        in m, or without unit, as above.

    Raises
    ------
    HeightMapError
        for a profile that is shorter than a section, or anything else than profiles.

    References
    ----------
    .. [1] ISO 21920-2:2021; crossings and their discrimination as in ISO 4287:1997, 3.2.7 and 4.3.1.

    Examples
    --------
    >>> import numpy as np
    >>> from roughcontact.arguments.maps import height_map
    >>> x = np.arange(4000) * 1e-6
    >>> result = profile_parameters(height_map(1e-6 * np.sin(2 * np.pi * x / 200e-6), 1e-6))
    >>> print(f"Pq {result['Pq']:.3g} m, Psm {result['Psm']:.3g} m")
    Pq 7.07e-07 m, Psm 0.0002 m
    """
    values = check_map(profiles)
    if "filled" in profiles.coords:
        values[profiles["filled"].values.astype(bool)] = np.nan  # filled points are no measurement
    rows = values if values.shape[1] > 1 else values.T
    l_filter = json_attribute(profiles.attrs, "filters_removed").get("l_filter")
    section = l_filter and l_filter["nesting_index"]["value"]
    parameters = [_parameters(row, min(spacing(profiles)), section) for row in rows]
    prefix = "R" if l_filter else "P"  # ISO 21920-2: R of a profile without waviness, P of a primary one
    return {prefix + name: float(np.mean([row[name] for row in parameters])) for name in parameters[0]}


def _parameters(profile: np.ndarray, pitch: float, section: float | None) -> dict[str, float]:
    """Return the parameters of heights (m; NaN where missing), without the letter of the profile."""
    indices = np.flatnonzero(~np.isnan(profile))
    # missing points at the ends shorten the profile, those within are left out of sums
    if indices.size < 2:
        raise HeightMapError("a profile has fewer than two measured points: leave its row out")
    z = np.ma.masked_invalid(profile[indices[0] : indices[-1] + 1])
    z = z - z.mean()
    count = round(section / pitch) if section else z.size
    if not 0 < count <= z.size:
        raise HeightMapError(
            f"l_filter = {section:g} m: the profile of {z.size * pitch:g} m is shorter than one section; "
            "filter with a smaller nesting index, or measure a longer profile"
        )
    # a last section that is not complete is left out
    sections = z[: z.size // count * count].reshape(-1, count)
    p, v = float(sections.max(axis=1).mean()), float(-sections.min(axis=1).mean())
    q = math.sqrt(np.mean(z**2))
    bearing = bearing_parameters(z.compressed())
    # crossings are counted on a profile without gaps
    bridged_profile = np.interp(np.arange(z.size), indices - indices[0], z.compressed())
    return {
        "a": float(np.mean(np.abs(z))),
        "q": q,
        "p": p,
        "v": v,
        "z": p + v,
        "t": float(np.ma.ptp(z)),
        "sk": float(np.mean((z / q) ** 3)) if q > 0 else math.nan,
        "ku": float(np.mean((z / q) ** 4)) if q > 0 else math.nan,
        "sm": pitch * _element_width(bridged_profile, _DISCRIMINATION * (p + v)),
        "dq": math.sqrt(np.mean(np.ma.diff(z) ** 2)) / pitch,
    } | {name: bearing[areal] for name, areal in _CORE.items()}


def _element_width(z: np.ndarray, threshold: float) -> float:
    """Return the mean width, in points, of the profile elements between crossings upwards."""
    peaks = np.flatnonzero(np.abs(z) > threshold)
    below, above = peaks[:-1], peaks[1:]
    upwards = (z[below] < 0) & (z[above] > 0)
    if np.count_nonzero(upwards) < 2:
        return math.nan
    start, last = (
        _crossing(z[start : stop + 1], start)
        for start, stop in zip(below[upwards][[0, -1]], above[upwards][[0, -1]], strict=True)
    )
    return (last - start) / (np.count_nonzero(upwards) - 1)


def _crossing(rise: np.ndarray, start: int) -> float:
    """Return where a rise that begins at an index crosses zero for the last time, in points."""
    last = int(np.flatnonzero(rise <= 0)[-1])
    return start + last - rise[last] / (rise[last + 1] - rise[last])
