"""True contact area and contact pressures of measured rough surfaces.

The public verbs take labelled arrays (`xarray`) in the `units` that they state, SI where they state none, and
numbers that may be text with a unit ("115 GPa"). They return SI units, and follow one another::

    height   = read_height_map(path)
    levelled = level(height, form="plane")
    window   = periodic_window(levelled)
    contact  = solve_contact(window, contact_modulus=1e9, mean_pressure=[1e6, 5e6])
    stats    = contact_statistics(contact)

`evaluate(path, contact_modulus=1e9)` goes all this way, to the numbers with their intervals;
`plot` draws them, `group_statistics` makes one answer of several maps, and `compare_groups` tells whether two
finishes differ.

Names are imported on first use, so that a job pays only for what it needs.
"""

from importlib import import_module

_HOME = {
    "read_height_map": "roughcontact.io.read",
    "height_map": "roughcontact.arguments.maps",
    "inspect_file": "roughcontact.io.inspection",
    "sample_file": "roughcontact.study.samples",
    "level": "roughcontact.surface.levelling.level",
    "composite": "roughcontact.surface.faces.composite",
    "relative_positions": "roughcontact.surface.faces.positions",
    "periodic_window": "roughcontact.surface.window.periodic_window",
    "parameters": "roughcontact.surface.window.areal",
    "power_spectrum": "roughcontact.surface.window.areal",
    "profile_parameters": "roughcontact.surface.roughness.profile_parameters",
    "surface_from_profiles": "roughcontact.surface.profiles.surface",
    "solve_contact": "roughcontact.contact.solve",
    "partial_slip": "roughcontact.contact.partial_slip",
    "flash_temperature": "roughcontact.contact.flash_temperature",
    "unload": "roughcontact.statistics.unloading",
    "run_in": "roughcontact.statistics.running_in",
    "sliding_friction": "roughcontact.statistics.sliding",
    "contact_statistics": "roughcontact.statistics.contact_statistics",
    "first_yield_pressure": "roughcontact.statistics.targets",
    "error_budget": "roughcontact.uncertainty.budget",
    "evaluate": "roughcontact.evaluation.evaluate",
    "contact_table": "roughcontact.evaluation.evaluate",
    "material": "roughcontact.arguments.named_materials",
    "group_statistics": "roughcontact.uncertainty.groups",
    "compare_groups": "roughcontact.uncertainty.differences",
    "surface_checks": "roughcontact.statistics.checks",
    "with_uncertainty": "roughcontact.statistics.contact_statistics",
    "with_interval": "roughcontact.arguments.quantities",
    "self_affine_surface": "roughcontact.surface.synthetic",
    "workflow_file": "roughcontact.study.running",
    "table": "roughcontact.results.collect",
    "summary": "roughcontact.results.collect",
    "compare_statistics": "roughcontact.results.comparison",
    "read_dataset": "roughcontact.results.storage",
    "read_statistics": "roughcontact.results.selection",
    "write_dataset": "roughcontact.results.storage",
    "RoughContactError": "roughcontact.errors",
    "InputFileError": "roughcontact.errors",
    "SettingsError": "roughcontact.errors",
    "HeightMapError": "roughcontact.errors",
    "HeightMapWarning": "roughcontact.errors",
    "ConvergenceError": "roughcontact.errors",
}

_MODULES = {"plot": "roughcontact.report.plot"}

__all__ = ["__version__", *_HOME]  # noqa: PLE0604 - the keys are strings


def __getattr__(name):
    if name == "__version__":
        from importlib.metadata import PackageNotFoundError, version  # half of the imports of a command

        try:
            return version("roughcontact")
        except PackageNotFoundError:  # used from a checkout that was not installed
            return "0+unknown"
    if name in _HOME:
        return getattr(import_module(_HOME[name]), name)
    if name in _MODULES:
        return import_module(_MODULES[name])
    raise AttributeError(f"module {__name__!r} has no attribute {name!r}")


def __dir__():
    return sorted([*__all__, *_MODULES])
