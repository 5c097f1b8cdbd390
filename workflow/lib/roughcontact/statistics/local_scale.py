"""The check of a form wider than its map, each place of which has the contact of the map."""

import numpy as np

from roughcontact.arguments.quantities import percent, quantity
from roughcontact.statistics.outcome import Check, noted, review
from roughcontact.statistics.selected_loads import Statistics

_ROUGHNESS_OF_FORM = 0.05  # rms height over Hertz's approach


def local_scale(statistics: Statistics) -> Check | None:
    """Check that the rms height is below 0.05 of the approach of a form (Johnson 1985, section 13.5)."""
    if "local_contact_area" not in statistics:
        return None
    last = statistics.isel(load=int(statistics["force"].values.argmax()))
    # the least approach: under the smallest force roughness is largest against the form
    ratio = float(statistics["rms_height"] / statistics["hertz_approach"].min())
    share = float(last["local_contact_area"] / (np.pi * last["hertz_radius"] ** 2))
    force, radius, gap = (
        quantity(float(last[name]), unit)
        for name, unit in (("force", "N"), ("hertz_radius", "m"), ("local_mean_gap", "m"))
    )
    text = (
        "Each place of the smooth contact (Hertz) has the contact of this map under the nominal pressure "
        f"there: at {force}, radius {radius}, {percent(share)} of the area and a mean gap of {gap}. "
        f"Roughness has to be small against the form: its rms height is {percent(ratio)} of the least "
        "approach."
    )
    lengths = [statistics[f"window_length_{axis}"] for axis in "xy"]
    # a map as large as the contact does not see a pressure that is the same all over
    if ratio <= _ROUGHNESS_OF_FORM and np.nanmax(lengths) < 2 * statistics["hertz_radius"].min():
        return noted(text)
    return review(text, advice="Solve a map that is larger than the contact, with boundary: free.")
