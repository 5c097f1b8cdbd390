"""The check of a map that is smaller than the contact, each place of which is under a pressure of Hertz."""

import numpy as np

from roughcontact.statistics.outcome import Check, judge
from roughcontact.statistics.selected_loads import Statistics

_ROUGHNESS_OF_FORM = 0.05  # rms height over Hertz's approach


def local_scale(statistics: Statistics) -> Check | None:
    """Check that the rms height is below 0.05 of the approach of a form (Johnson 1985, section 13.5)."""
    if "local_contact_area" not in statistics:
        return None
    largest = int(statistics["force"].values.argmax())
    names = "force", "local_contact_area", "local_mean_gap", "hertz_radius"
    last = {name: statistics[name].values[largest] for name in names}
    # the least approach: under the smallest force roughness is largest against the form
    ratio = float(statistics["rms_height"] / statistics["hertz_approach"].min())
    lengths = [statistics[f"window_length_{axis}"] for axis in "xy"]
    # a map as large as the contact does not see a pressure that is the same all over
    is_small = np.nanmax(lengths) < 2 * statistics["hertz_radius"].min()
    share = last["local_contact_area"] / (np.pi * last["hertz_radius"] ** 2)
    cases = {"holds": ratio <= _ROUGHNESS_OF_FORM and is_small}
    return judge("Local scale", cases, ratio=ratio, share=share, last=last)
