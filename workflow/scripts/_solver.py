"""What the two scripts that solve have in common."""

from _job import progress, snakemake

from roughcontact.contact.loads import plan_loads
from roughcontact.contact.solve import SOLVER_SETTINGS
from roughcontact.errors import HeightMapError


def solver_arguments(window, contact: dict) -> dict:
    """Return the keyword arguments of `solve_contact` that the settings `contact` stand for."""
    problem = {"contact_modulus": contact["contact_modulus"]}
    given = {key: contact[key] for key in ("mean_pressure", "relative_pressure")}
    try:
        loads = plan_loads(window, **problem, **given)
    except HeightMapError as error:
        raise HeightMapError(f"{window.attrs['source_file']}: {error} (section contact)") from error
    chosen = {key: contact[key] for key in SOLVER_SETTINGS}
    return problem | chosen | {"mean_pressure": loads, "threads": snakemake.threads, "progress": progress}
