"""Composite height map of two measured faces in a given relative position."""

import math
from collections import Counter
from collections.abc import Sequence

import numpy as np
import xarray as xr

from roughcontact.arguments.measurement import Instrument, json_attribute, json_attributes
from roughcontact.arguments.si import as_si
from roughcontact.errors import HeightMapError
from roughcontact.surface.faces.face import Face
from roughcontact.surface.faces.overlap import Pair
from roughcontact.surface.levelling.polynomial import fit_polynomial
from roughcontact.surface.levelling.rejected import restore_rejected
from roughcontact.surface.roughness.heights import height_parameters, record_summit
from roughcontact.surface.window.band import reliable_wavelength
from roughcontact.surface.window.instrument import OF_ONE_FACE, instrument_of_sum

# attributes taken from the face with the larger row jitter
_ROW_ATTRIBUTES = ("row_jitter", "row_jitter_evidence", "line_alignment", "line_alignment_by")


@as_si
def composite(
    face: xr.DataArray,
    counter_face: xr.DataArray,
    *,
    shift: tuple[float, float] = (0.0, 0.0),
    rotation: float = 0.0,
) -> xr.DataArray:
    """Return the composite height map of two faces, whose contact with a flat is equivalent to theirs.

    Both heights are positive outwards, so that the gap of the rigid faces is (approach) - h1 - h2, and the
    composite height is the sum h1 + h2 [1]_, [2]_. The counter-face points the opposite way: it is turned
    over about y before it is placed on the face, which mirrors it along x:

        h(x, y) = h1(x, y) + h2(x2, y2) - mean plane,
        x2 = -(u cos t + v sin t),  y2 = v cos t - u sin t,  (u, v) = (x, y) - shift,

    with positions relative to the middle of each map and the rotation t. With the composite contact modulus,
    the contact of the two elastic faces is that of h with a flat.

    The result covers the overlap of both maps, and a plane is subtracted: the mean planes of the faces
    coincide there. A periodic map continues beyond its edges; two periodic maps of the same period at right
    angles give a periodic map, from which only the mean is subtracted. The grid is that of `face`, refined
    along an axis where the counter-face has the smaller step. A map whose points do not coincide with the
    grid is interpolated by a cubic spline.

    Parameters
    ----------
    face, counter_face : DataArray (y, x), m
        from `level`; NaN where missing. Two maps, or two profiles.
    shift : (y, x), m
        position of the middle of the counter-face relative to the middle of the face.
    rotation : float, degree
        of the counter-face about its middle, from x towards y, as placed on the face. Profiles: 0.

    Returns
    -------
    DataArray (y, x), m
        NaN where one of the two is missing; the coordinate `filled` is 1 where one of the two was filled,
        and `rejected_height` (m) exists if points of a face were rejected, as in the result of `level`.
        Attributes of `face`, with those of levelling for the sum (form, filled and rejected points of both,
        height parameters), `source_file` and `source_sha256` of both, `instrument` of the one with the lower
        resolution, and `counter_face` (file), `shift_y`, `shift_x` (m), `rotation` (degree), `covered_share`
        (of the face), `covered_share_of_larger` (of the larger face), `face_pitches` (m; of face and
        counter-face, the coarser of x and y).

    Raises
    ------
    HeightMapError
        for maps that overlap by fewer than two points, or a map and a profile.
    SettingsError
        for an invalid shift or rotation.

    References
    ----------
    .. [1] Greenwood, J. A., Tripp, J. H. (1970), Proc. Inst. Mech. Eng. 185, 625.
    .. [2] Johnson, K. L. (1985), Contact Mechanics, section 13.4.

    Examples
    --------
    >>> import numpy as np
    >>> import roughcontact as rc
    >>> from roughcontact.arguments.maps import height_map
    >>> profile = np.array([[0.0, 3.0, 1.0, 0.0, 0.0, 1.0, 2.0, 1.0]])
    >>> face, mirrored = height_map(profile, 1.0), height_map(-profile[:, ::-1], 1.0)
    >>> bool(np.allclose(rc.composite(face, mirrored), 0))  # a face conforms to its own negative
    True
    """
    pair = Pair(Face(face), Face(counter_face), rotation, shift)
    lower, upper, (cosine, sine) = pair.lower, pair.upper, pair.turn
    positions = pair.grid()
    v, u = np.meshgrid(*(p - s for p, s in zip(positions, shift, strict=True)), indexing="ij")
    # the counter-face is seen from its back: x is mirrored
    face_positions = np.meshgrid(*positions, indexing="ij"), (v * cosine - u * sine, -(u * cosine + v * sine))
    values, on_filled = _sum_at((lower, upper), face_positions)
    is_measured = np.isfinite(values)
    if np.count_nonzero(is_measured) < 2:
        raise HeightMapError(
            f"{pair.name}: the faces have fewer than two measured points in common: choose a smaller shift"
        )
    coordinates = [p + c for p, c in zip(positions, lower.middle, strict=True)]
    # a plane would break the period that both have
    order, form_name = (0, "mean") if pair.is_periodic() else (1, "plane")
    form, form_record = fit_polynomial(values, coordinates, order=order)
    values = values - form
    on_filled &= is_measured
    attrs = _attributes(lower, upper, on_filled)
    coverage = float(is_measured.mean() * pair.covered_share(positions))
    # of profiles their length counts, not their width
    sizes = [math.prod(side.lengths) if min(side.shape) > 1 else max(side.lengths) for side in (lower, upper)]
    attrs |= {
        "source_file": pair.name,
        "form": form_name,
        **json_attributes({"form_removed": form_record}),
        "shift_y": float(shift[0]),
        "shift_x": float(shift[1]),
        "rotation": float(rotation),
        "covered_share": coverage,
        "covered_share_of_larger": coverage * sizes[0] / max(sizes),
        "face_pitches": [max(lower.step), max(upper.step)],
    }
    coords = {
        "y": ("y", coordinates[0], {"units": "m"}),
        "x": ("x", coordinates[1], {"units": "m"}),
        "filled": (("y", "x"), on_filled.astype(np.int8)),
    }
    if any("rejected_height" in side.height.coords for side in (lower, upper)):
        # with what levelling has rejected on either face: a check asks what it would carry
        restored_faces = [Face(restore_rejected(side.height)) for side in (lower, upper)]
        with_rejected, is_rejected = _sum_at(restored_faces, face_positions)
        heights = np.where(is_rejected & is_measured, with_rejected - form, np.nan)
        coords["rejected_height"] = (("y", "x"), heights, {"units": "m"})
    result = xr.DataArray(values, dims=("y", "x"), coords=coords, name="height", attrs=attrs)
    return record_summit(result.assign_attrs(height_parameters(result)))


def _sum_at(
    faces: Sequence[Face], positions: Sequence[Sequence[np.ndarray]]
) -> tuple[np.ndarray, np.ndarray]:
    """Return the sum of the heights of both faces at positions on each, and which depend on marked points."""
    lower, upper = (face.at(*position) for face, position in zip(faces, positions, strict=True))
    return lower[0] + upper[0], lower[1] | upper[1]


def _attributes(lower: Face, upper: Face, on_filled: np.ndarray) -> dict:
    """Return the attributes of the face, combined with those of the counter-face where applicable."""
    kinds: Counter[str] = Counter()
    warnings, facts, spikes = list[str](), list[str](), dict[str, str]()
    for face in (lower, upper):
        attrs, name = face.height.attrs, face.name
        kinds.update(json_attribute(attrs, "outlier_kinds"))
        warnings += [f"{name}: {warning}" for warning in json_attribute(attrs, "ingest_warnings")]
        if attrs.get("first_row_assumed"):  # the face may be mirrored
            where = f"the {attrs['first_row']} of the picture"
            warnings.append(f"{name}: the first row is taken as {where}; if it is not, give first_row")
        facts += [f"{name}: {fact}" for fact in json_attribute(attrs, "ingest_facts")]
        spike_counts = json_attribute(attrs, "ingest_spikes")
        spikes |= {f"{name}: {spike}": f"{name}: {text}" for spike, text in spike_counts.items()}
    attrs_of_faces = lower.height.attrs, upper.height.attrs
    # the sum has the rows of the worse face
    with_jitter = max(attrs_of_faces, key=lambda attrs: attrs.get("row_jitter", 0.0))
    steps = [attrs["quantisation_step"] for attrs in attrs_of_faces if "quantisation_step" in attrs]
    instruments = [*map(Instrument.read, attrs_of_faces)]
    one, other = ({*each.properties()} for each in instruments)
    # the sum resolves what the coarser face does
    coarser = max((lower, upper), key=lambda face: reliable_wavelength(face.height)[0])
    of_lower = instruments[0].attributes()
    return {key: value for key, value in lower.height.attrs.items() if key not in of_lower} | {
        "units": "m",
        "counter_face": upper.name,
        "source_sha256": " + ".join(attrs.get("source_sha256", "") for attrs in attrs_of_faces),
        "instrument": coarser.height.attrs.get("instrument", "{}"),
        **json_attributes({"ingest_warnings": warnings, "ingest_facts": facts, "ingest_spikes": spikes}),
        "missing_share": max(attrs.get("missing_share", 0.0) for attrs in attrs_of_faces),
        "outliers_rejected": sum(attrs.get("outliers_rejected", 0) for attrs in attrs_of_faces),
        **json_attributes({"outlier_kinds": kinds}),
        **{name: with_jitter[name] for name in _ROW_ATTRIBUTES if name in with_jitter},
        "filled_points": int(on_filled.sum()),
        "filled_share": float(on_filled.mean()),
        "largest_hole": max(attrs.get("largest_hole", 0) for attrs in attrs_of_faces),
        # each face lies within half of its step
        **({"quantisation_step": sum(steps)} if steps else {}),
        **instrument_of_sum(instruments).attributes(),
        **({OF_ONE_FACE: " ".join(sorted(one ^ other))} if one ^ other else {}),
    }
