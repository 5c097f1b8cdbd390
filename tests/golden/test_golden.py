"""The numbers of the sample maps stay what they were.

What is kept was solved to 1e-8, and so does the test: it finds a changed method anywhere between the measured
file and the summary. The shipped configuration, with its tolerance, must be good enough for the same numbers.
"""

import numpy as np
import pytest
from make_golden import CONVERGED, read_golden, run_samples

# Relative difference that is allowed of a converged number, and of all that comes before the solver; counts
# must be equal. With another library of Fourier transforms the numbers differ by 2e-8, and the same points
# are in contact.
KEPT = 1e-4
COUNTS = ("contact_clusters",)
# At the shipped tolerance of 1e-4 up to one contact pixel in a thousand is still undecided. Areas and
# pressures follow that, the length of the contact line and the stiffness magnify it.
SHIPPED = {
    "relative_contact_area": 3e-3,
    "relative_contact_area_pixels": 3e-3,
    "contact_perimeter_m": 1e-2,
    "contact_on_filled_points": 1e-2,  # of 170 points: one that changes sides is 6e-3
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


def allowed(golden, column, case):
    """Return the differences that are allowed of a column: (relative (row), absolute)."""
    relative = np.full(len(golden), 0.0 if column in COUNTS else KEPT)
    if case == "converged":
        return relative, 0
    if column in SHIPPED:
        profile = golden.index.get_level_values("surface") == "stylus-profile"
        relative = SHIPPED[column] * np.where(profile, PROFILE, 1)
    return relative, PATCHES if column in COUNTS else 0


def differences(golden, now, case):
    """Return a line for each number that is not what it was."""
    if not golden.index.equals(now.index):
        return [f"rows were {list(golden.index)}, now {list(now.index)}"]
    lines = []
    for column in golden:
        old, new = golden[column].to_numpy(), now[column].to_numpy()
        relative, absolute = allowed(golden, column, case)
        for index in np.flatnonzero(~np.isclose(new, old, rtol=relative, atol=absolute, equal_nan=True)):
            row = golden.index[index]
            row = row if isinstance(row, str) else " at ".join(map(str, row))
            change = f"{new[index] / old[index] - 1:+.2%}" if old[index] else "was zero"
            limit = absolute if column in COUNTS else f"{relative[index]:.2%}"
            lines.append(
                f"{row:20s} {column:30s} {old[index]:<11.6g} is now {new[index]:<11.6g} ({change}, allowed "
                f"{limit})"
            )
    return lines


@pytest.fixture(scope="module")
def now(tmp_path_factory):
    """The tables of a run to 1e-8, and of one to the tolerance of the shipped configuration."""
    return run_samples(tmp_path_factory.mktemp("golden"), converged=CONVERGED, shipped={})


@pytest.mark.slow
@pytest.mark.parametrize("case", ["converged", "shipped"])
@pytest.mark.parametrize("table", ["surfaces", "loads"])
def test_the_sample_maps_give_the_numbers_they_gave(now, table, case):
    lines = differences(read_golden()[table], now[case][table], case)
    assert not lines, "\n".join(["golden numbers differ:", *lines, ADVICE])


def test_a_changed_number_is_told_in_words():
    golden = read_golden()["loads"]
    changed = golden.copy()
    changed.iloc[3, changed.columns.get_loc("relative_contact_area")] *= 1.01
    changed.iloc[5, changed.columns.get_loc("contact_clusters")] += PATCHES
    (line,) = differences(golden, changed, "shipped")
    assert line.startswith("sandblasted at 0.05")
    assert "relative_contact_area" in line
    assert "+1.00%, allowed 0.30%" in line
    area, clusters = differences(golden, changed, "converged")
    assert "+1.00%, allowed 0.01%" in area
    assert clusters.startswith("sandblasted at 0.2")
    assert "allowed 0)" in clusters


@pytest.mark.parametrize("column", ["relative_contact_area", "contact_stiffness_Pa_per_m", "mean_gap_m"])
def test_a_converged_profile_is_held_to_four_digits(column):
    golden = read_golden()["loads"]
    changed = golden.copy()
    changed.loc[("stylus-profile", 0.05), column] *= 1 + 2e-4
    (line,) = differences(golden, changed, "converged")
    assert line.startswith("stylus-profile at 0.05")
