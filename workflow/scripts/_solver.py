"""What the two scripts that solve have in common."""

import _job
import xarray as xr

from roughcontact.contact.solve import SOLVER_SETTINGS
from roughcontact.errors import HeightMapError
from roughcontact.statistics.targets import wanted_loads


def solver_arguments(window: xr.DataArray, contact: dict) -> dict:
    """Return the keyword arguments of `solve_contact` that the settings stand for.

    Parameters
    ----------
    window : DataArray (y, x), m
        the map to be solved, for loads relative to its rms gradient.
    contact : dict
        the section `contact` of the settings.

    Returns
    -------
    dict
        elasticity, loads in Pa, accuracy, threads, and who is told how far the sweep has come.

    Raises
    ------
    HeightMapError
        for relative loads and targets on a flat map.
    """
    problem = {"contact_modulus": contact["contact_modulus"]}
    try:
        loads = wanted_loads(window, contact, threads=_job.snakemake.threads)
    except HeightMapError as error:
        raise HeightMapError(f"{window.attrs['source_file']}: {error} (section contact)") from error
    chosen = {key: contact[key] for key in SOLVER_SETTINGS}
    return (
        problem
        | chosen
        | {"mean_pressure": loads, "threads": _job.snakemake.threads, "progress": _job.progress}
    )
