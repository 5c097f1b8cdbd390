"""Draw running-in.png of this folder: the ground sample before and after wear, and its contact on the way.

python docs/images/draw_running_in.py
"""

from pathlib import Path

import numpy as np

import roughcontact as rc
from roughcontact.arguments.settings.resolve import resolve
from roughcontact.evaluation.courses import Face, worn_in_a_run
from roughcontact.report.figures import new_figure

ROOT = Path(__file__).parents[2]
SETTINGS = {
    "contact": {"bodies": ["steel", "steel"]},
    "wear": {"coefficient": "1e-7 mm3/(N m)", "distance": np.geomspace(0.1, 300, 12).tolist()},
}
ANSWERS = {"relative_contact_area": ("contact area", 1.0), "mean_gap": ("mean gap (µm)", 1e6)}


def main() -> None:
    """Draw the picture."""
    window = rc.periodic_window(rc.level(rc.read_height_map(ROOT / "data_samples/ground.txt")))
    worn = worn_in_a_run(Face(window), resolve(SETTINGS)[""], mean_pressure=20e6)
    distance = worn["sliding_distance"].values[1:]
    with new_figure(9.0, 3.0) as figure:
        axes = figure.subplots(1, 4)
        heights = (worn["height"] - worn["height"].mean(("y", "x"))) * 1e6
        limits = np.percentile(heights[0], [0.1, 99.9])
        for axis, index, title in zip(axes, (0, -3), ("before", f"after {distance[-3]:.0f} m"), strict=False):
            extent = [1e6 * side for side in (0, float(worn["x"].max()), 0, float(worn["y"].max()))]
            picture = axis.imshow(
                heights[index], origin="lower", extent=extent, vmin=limits[0], vmax=limits[1]
            )
            axis.set(title=title, xlabel="x (µm)")
            axis.grid(visible=False)
        axes[0].set_ylabel("y (µm)")
        figure.colorbar(picture, ax=axes[1], label="height (µm)", shrink=0.7)
        for axis, (name, (label, factor)) in zip(axes[2:], ANSWERS.items(), strict=True):
            values, lower, upper = (
                worn[f"{name}{end}"].values[1:] * factor for end in ("", "_lower", "_upper")
            )
            axis.fill_between(distance, lower, upper, alpha=0.25)
            axis.plot(distance, values)
            axis.set(xscale="log", yscale="log", xlabel="sliding distance (m)", title=label)
        figure.savefig(ROOT / "docs/images/running-in.png", dpi=110, metadata={"Software": None})


if __name__ == "__main__":
    main()
