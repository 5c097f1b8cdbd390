"""The numbers of the sample maps stay what they were.

What is kept was solved to 1e-8; the test runs the shipped configuration, with its tolerance. So it finds a
changed method anywhere between the measured file and the summary, and a tolerance that is not good enough.
"""

import numpy as np
import pytest
from make_golden import read_golden, run_samples

# Relative differences that are allowed. Five digits are kept: what comes before the solver, and the theories,
# must agree to all of them.
KEPT_DIGITS = 1e-4
# At the shipped tolerance of 1e-4 up to one contact pixel in a thousand is still undecided. Areas and
# pressures follow that, the length of the contact line and the stiffness magnify it.
SOLVED = {
    "relative_contact_area": 3e-3,
    "relative_contact_area_pixels": 3e-3,
    "contact_perimeter_m": 1e-2,
    "contact_on_filled_points": 3e-3,
    "mean_contact_pressure_Pa": 3e-3,
    "max_pressure_Pa": 1e-3,
    "pressure_std_Pa": 3e-3,
    "mean_gap_m": 5e-3,
    "contact_stiffness_Pa_per_m": 1e-2,
    "elastic_energy_J_per_m2": 5e-4,
}
PROFILE = 10  # a profile has few points in contact: each one weighs as much more
PATCHES = 3  # pixels at the rim of a patch may join it to its neighbour or leave it
ADVICE = (
    "If the change is meant, make them anew with `python tests/golden/make_golden.py`, look at "
    "`git diff tests/golden`, and commit both together."
)


def differences(golden, now):
    """Return a line for each number that is not what it was."""
    if not golden.index.equals(now.index):
        return [f"rows were {list(golden.index)}, now {list(now.index)}"]
    lines = []
    for column in golden:
        old, new = golden[column].to_numpy(), now[column].to_numpy()
        profile = golden.index.get_level_values("surface") == "stylus-profile"
        relative = SOLVED[column] * np.where(profile, PROFILE, 1) if column in SOLVED else KEPT_DIGITS
        relative = np.broadcast_to(relative, old.shape)
        absolute = PATCHES if column == "contact_clusters" else 0
        for index in np.flatnonzero(~np.isclose(new, old, rtol=relative, atol=absolute, equal_nan=True)):
            row = golden.index[index]
            row = row if isinstance(row, str) else " at ".join(map(str, row))
            change = f"{new[index] / old[index] - 1:+.2%}" if old[index] else "was zero"
            allowed = absolute or f"{relative[index]:.2%}"
            lines.append(
                f"{row:20s} {column:30s} {old[index]:<11.6g} is now {new[index]:<11.6g} ({change}, allowed "
                f"{allowed})"
            )
    return lines


@pytest.fixture(scope="module")
def now(tmp_path_factory):
    """The tables of a run with the shipped configuration."""
    return run_samples(tmp_path_factory.mktemp("golden"))


@pytest.mark.parametrize("table", ["surfaces", "loads"])
def test_the_sample_maps_give_the_numbers_they_gave(now, table):
    lines = differences(read_golden()[table], now[table])
    assert not lines, "\n".join(["golden numbers differ:", *lines, ADVICE])


def test_a_changed_number_is_told_in_words():
    golden = read_golden()["loads"]
    changed = golden.copy()
    changed.iloc[3, changed.columns.get_loc("relative_contact_area")] *= 1.01
    changed.iloc[5, changed.columns.get_loc("contact_clusters")] += PATCHES
    (line,) = differences(golden, changed)
    assert line.startswith("sandblasted at 0.05")
    assert "relative_contact_area" in line
    assert "+1.00%, allowed 0.30%" in line
