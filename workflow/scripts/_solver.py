"""What the two scripts that solve have in common."""

from _job import progress, snakemake

from roughcontact.contact import plan_loads


def solver_arguments(window, contact: dict) -> dict:
    """Return the keyword arguments of `solve_contact` that the settings `contact` stand for."""
    problem = {"contact_modulus": contact["contact_modulus"]}
    loads = plan_loads(
        window,
        **problem,
        mean_pressure=contact["mean_pressure"],
        relative_pressure=contact["relative_pressure"],
    )
    accuracy = {key: contact[key] for key in ("tolerance", "zero_frequency", "on_failure")}
    return problem | accuracy | {"mean_pressure": loads, "threads": snakemake.threads, "progress": progress}
