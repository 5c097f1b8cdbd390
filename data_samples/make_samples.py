"""Make the sample maps of this folder: `python data_samples/make_samples.py [folder]`.

The heights come from the formulas here and in `roughcontact.surface.synthetic`, with fixed seeds, dates and
quantisation, so that every run writes the same files.
"""

import io
import sys
from datetime import UTC, datetime
from pathlib import Path

import numpy as np
import xarray as xr
from scipy import ndimage

from roughcontact.arguments.maps import height_map, pitches
from roughcontact.surface.synthetic import (
    rough_reference_surface,
    self_affine_surface,
    with_deep_valleys,
)

_DATE = datetime(2024, 1, 1, tzinfo=UTC)
_QUANTUM = 1e-10  # m; every instrument has one, and it hides the rounding of the Fourier transform


def quantised(values):
    """Return heights in whole steps of 0.1 nm."""
    return np.rint(values / _QUANTUM) * _QUANTUM


def sandblasted():
    """Return heights (256, 256) of an isotropic rough surface as an optical profiler delivers it.

    Tilted, slightly domed, blind on steep flanks and in one pit, with spikes. Pitch 1 µm.
    """
    surface = self_affine_surface(
        (256, 256), 1e-6, hurst=0.8, shortest=6e-6, longest=120e-6, rms_height=0.8e-6, seed=1
    )
    values = surface.values.copy()
    generator = np.random.default_rng(2)
    steep = np.hypot(*np.gradient(values, 1e-6))
    # one in four of the steepest points is lost, and a pit as a whole
    lost = (steep > np.quantile(steep, 0.93)) & (generator.random(values.shape) < 0.25)
    row, column = np.indices(values.shape)
    lost |= ((row - 170) / 9) ** 2 + ((column - 80) / 14) ** 2 < 1
    spikes = tuple(generator.integers(4, 252, size=(2, 30)))
    values[spikes] += generator.choice([-1, 1], 30) * generator.uniform(8e-6, 25e-6, 30)
    x, y = (np.arange(256) - 127.5) * 1e-6, (np.arange(256) - 127.5)[:, None] * 1e-6
    values += 0.012 * x - 0.007 * y - (x**2 + y**2) / (2 * 40e-3)
    return np.where(lost, np.nan, quantised(values))


def turned_surface(
    shape,
    spacing,
    *,
    feed,
    nose_radius,
    groove_scatter=0.0,
    arc_radius=np.inf,
    rms_roughness=0.0,
    hurst=0.8,
    seed=0,
):
    """Return a face-turned surface: parabolic grooves of the tool nose, one per feed, lay along y.

    h = s^2 / (2 R) + depth of the groove + fine roughness, s = distance from the middle of the groove; the
    ideal profile is that of Shaw (2005), Metal Cutting Principles.

    Parameters
    ----------
    shape : (ny, nx)
    spacing : float or (dy, dx), m
    feed : float, m
        distance between grooves.
    nose_radius : float, m
        radius R of the tool nose; the ridges stand feed^2 / (8 R) above the grooves.
    groove_scatter : float, m
        standard deviation of the depth from groove to groove.
    arc_radius : float, m
        distance of the map from the axis of turning; infinite for straight grooves.
    rms_roughness : float, m
        rms height of the self-affine fine roughness on top, waves from two pixels to one feed.
    hurst : float, 0 to 1
        its Hurst exponent.
    seed : int
        of `numpy.random.default_rng`.

    Returns
    -------
    DataArray (y, x), m

    Examples
    --------
    >>> height = turned_surface((1, 800), 1e-6, feed=100e-6, nose_radius=400e-6)
    >>> f"{np.ptp(height.values):.1e} m"  # feed^2 / (8 R)
    '3.1e-06 m'
    """
    dy, dx = pitches(spacing)
    ny, nx = shape
    y = (np.arange(ny)[:, None] + 0.5 - ny / 2) * dy
    x = (np.arange(nx)[None, :] + 0.5) * dx
    # distance from the axis of turning, less that of the left edge; y^2 / (hypot + R) avoids cancellation
    across = x + (0 if np.isinf(arc_radius) else y**2 / (np.hypot(x + arc_radius, y) + x + arc_radius))
    across = np.broadcast_to(across, (ny, nx))
    groove = np.floor(across / feed).astype(int)
    from_middle = across - (groove + 0.5) * feed
    generator = np.random.default_rng(seed)
    # each pass of the tool is a little deeper or less deep
    depth = groove_scatter * generator.standard_normal(groove.max() + 1)
    # neighbouring passes cut into each other: the lower of the two parabolas is what stays
    heights = from_middle**2 / (2 * nose_radius) + depth[groove]
    for side in (-1, 1):
        neighbour = np.clip(groove + side, 0, depth.size - 1)
        cut = (from_middle - side * feed) ** 2 / (2 * nose_radius) + depth[neighbour]
        heights = np.where(neighbour == groove, heights, np.minimum(heights, cut))
    if rms_roughness:
        heights = heights + self_affine_surface(
            shape,
            (dy, dx),
            hurst=hurst,
            shortest=2 * max(dx, dy if ny > 1 else dx),
            longest=feed,
            rms_height=rms_roughness,
            seed=int(generator.integers(2**32)),
        )
    return height_map(heights, (dy, dx), unit="m", instrument={"generator": "turned", "seed": int(seed)})


def turned():
    """Return heights (240, 320) of a face-turned surface, feed 80 µm, lay along y. Pitch 2 µm."""
    surface = turned_surface(
        (240, 320),
        2e-6,
        feed=80e-6,
        nose_radius=0.8e-3,
        groove_scatter=0.15e-6,
        arc_radius=12e-3,
        rms_roughness=0.08e-6,
        seed=3,
    )
    return quantised(surface.values - surface.values.mean())


def ground():
    """Return heights (160, 256) of a ground surface, waves eight times longer along y. Pitch 2 and 1 µm."""
    band = {"shortest": 5e-6, "longest": 60e-6}
    heights = self_affine_surface(
        (320, 512), (2e-6, 1e-6), hurst=0.75, **band, rms_height=0.4e-6, stretch=8.0, seed=4
    ).values
    heights = with_deep_valleys(heights, power=1.4, rms_height=0.4e-6)
    # a part of a larger periodic surface: its edges do not meet
    return quantised(heights[60:220, 100:356])


def stylus_profile():
    """Return heights (1, 2400) along a line across turning marks. Pitch 0.5 µm.

    The range of the gauge ends 1.5 µm above the mean: the tips of the highest marks are missing, which
    carry light loads.
    """
    surface = turned_surface(
        (1, 2400),
        0.5e-6,
        feed=100e-6,
        nose_radius=0.6e-3,
        groove_scatter=0.2e-6,
        rms_roughness=0.05e-6,
        seed=5,
    )
    values = quantised(surface.values - surface.values.mean())
    return np.where(values > 1.5e-6, np.nan, values)


def periodic():
    """Return heights (128, 128) of the rough reference case, 100 µm wide, rms height 0.25 µm."""
    surface = rough_reference_surface(128).values
    return quantised(surface * (0.25e-6 / surface.std()))


def blasted_surface():
    """Return heights (512, 512) of an isotropic surface, a DataArray (m), of which the profiles are rows."""
    return self_affine_surface(
        (512, 512), 1e-6, hurst=0.8, shortest=6e-6, longest=60e-6, rms_height=0.4e-6, seed=11
    )


def blasted_profiles():
    """Return heights (5, 512) of five profiles of `blasted_surface`, 0.1 mm apart. Pitch 1 µm."""
    return quantised(blasted_surface().values[50:500:100])


def lapped_surface():
    """Return heights (480, 480) of an isotropic surface with waves as long as 0.3 mm, a DataArray (m)."""
    return self_affine_surface(
        (480, 480), 1e-6, hurst=0.8, shortest=6e-6, longest=300e-6, rms_height=0.5e-6, seed=21
    )


def lapped_fine():
    """Return heights (128, 128) of a place of `lapped_surface` by a 50x objective. Pitch 1 µm."""
    return quantised(lapped_surface().values[176:304, 144:272])


def lapped_overview():
    """Return heights (96, 96) of a field around this place by a 10x objective. Pitch 4 µm.

    The lens smooths, the camera has noise of 1 %, the heights are 2 % too large and the field is tilted.
    """
    values = ndimage.gaussian_filter(lapped_surface().values, 2.4, mode="wrap")[32:416, 32:416]
    values = 1.02 * values.reshape(96, 4, 96, 4).mean(axis=(1, 3))
    values += np.random.default_rng(22).normal(0, 5e-9, values.shape)
    x = (np.arange(96) - 47.5) * 4e-6
    return quantised(values + 0.004 * x)


def x3p_bytes(values, pitch):
    import x3pio

    buffer = io.BytesIO()
    x3pio.write(
        buffer,
        values,
        x_scale=pitch,
        y_scale=pitch,
        z_type=x3pio.DataType.FLOAT32,
        metadata=x3pio.Metadata.for_software("roughcontact", "sample", date=_DATE),
    )
    return buffer.getvalue()


def sdf_bytes(values, pitch):
    import sdfio

    buffer = io.BytesIO()
    metadata = sdfio.Metadata(
        revision=sdfio.Revision.ISO_1_0,
        manufacturer_id="roughcont",
        create_date=_DATE,
        mod_date=_DATE,
        z_resolution=_QUANTUM,
        data_type=sdfio.DataType.INT32,
    )
    sdfio.write(buffer, values, x_scale=pitch, y_scale=pitch, z_scale=_QUANTUM, metadata=metadata)
    return buffer.getvalue()


def matrix_bytes(values, pitches):
    (ny, nx), (dy, dx) = values.shape, pitches
    header = [
        "# Channel: Topography",
        f"# Width: {nx * dx * 1e6:.1f} µm",
        f"# Height: {ny * dy * 1e6:.1f} µm",
        "# Value units: nm",
    ]
    rows = ["\t".join(f"{value * 1e9:.1f}" for value in row) for row in values + 0.0]
    return ("\n".join(header + rows) + "\n").encode()


def profile_bytes(values, pitch):
    numbers = range(1, len(values) + 1) if len(values) > 1 else [""]
    header = ",".join(["x (µm)", *(f"z{number} (nm)" for number in numbers)])
    heights = [",".join(f"{value * 1e9:.1f}" for value in column) for column in (values + 0.0).T]
    rows = [f"{(i + 0.5) * pitch * 1e6:.2f},{column}" for i, column in enumerate(heights)]
    return ("\n".join([header, *rows]) + "\n").encode()


def netcdf_bytes(values, length):
    ny, nx = values.shape
    dataset = xr.Dataset(
        {"height": (("y", "x"), values, {"units": "m", "long_name": "surface height"})},
        coords={
            "y": ("y", (np.arange(ny) + 0.5) * length / ny, {"units": "m"}),
            "x": ("x", (np.arange(nx) + 0.5) * length / nx, {"units": "m"}),
        },
        attrs={"title": "periodic self-affine surface"},
    )
    return bytes(dataset.to_netcdf(engine="scipy", format="NETCDF3_CLASSIC"))


def make_samples() -> dict[str, bytes]:
    """Return the content of each sample file, by name."""
    return {
        "sandblasted.x3p": x3p_bytes(sandblasted(), 1e-6),
        "turned.sdf": sdf_bytes(turned(), 2e-6),
        "ground.txt": matrix_bytes(ground(), (2e-6, 1e-6)),
        "stylus-profile.csv": profile_bytes(stylus_profile(), 0.5e-6),
        "blasted-profiles.csv": profile_bytes(blasted_profiles(), 1e-6),
        "lapped-50x.txt": matrix_bytes(lapped_fine(), (1e-6, 1e-6)),
        "lapped-10x.txt": matrix_bytes(lapped_overview(), (4e-6, 4e-6)),
        "periodic.nc": netcdf_bytes(periodic(), 100e-6),
    }


if __name__ == "__main__":
    folder = Path(sys.argv[1]) if len(sys.argv) > 1 else Path(__file__).parent
    for name, content in make_samples().items():
        (folder / name).write_bytes(content)
        print(folder / name, len(content), "bytes")
