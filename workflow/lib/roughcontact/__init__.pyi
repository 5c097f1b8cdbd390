"""Types of the names that `__init__.py` imports on first use: what editors and type checkers read."""

from roughcontact.arguments.maps import height_map as height_map
from roughcontact.arguments.named_materials import material as material
from roughcontact.arguments.quantities import with_interval as with_interval
from roughcontact.contact.flash_temperature import flash_temperature as flash_temperature
from roughcontact.contact.partial_slip import partial_slip as partial_slip
from roughcontact.contact.solve import solve_contact as solve_contact
from roughcontact.errors import ConvergenceError as ConvergenceError
from roughcontact.errors import HeightMapError as HeightMapError
from roughcontact.errors import HeightMapWarning as HeightMapWarning
from roughcontact.errors import InputFileError as InputFileError
from roughcontact.errors import RoughContactError as RoughContactError
from roughcontact.errors import SettingsError as SettingsError
from roughcontact.evaluation.evaluate import contact_table as contact_table
from roughcontact.evaluation.evaluate import evaluate as evaluate
from roughcontact.io.inspection import inspect_file as inspect_file
from roughcontact.io.read import read_height_map as read_height_map
from roughcontact.report import plot as plot
from roughcontact.results.collect import summary as summary
from roughcontact.results.collect import table as table
from roughcontact.results.comparison import compare_statistics as compare_statistics
from roughcontact.results.selection import read_statistics as read_statistics
from roughcontact.results.storage import read_dataset as read_dataset
from roughcontact.results.storage import write_dataset as write_dataset
from roughcontact.statistics.checks import surface_checks as surface_checks
from roughcontact.statistics.contact_statistics import contact_statistics as contact_statistics
from roughcontact.statistics.contact_statistics import with_uncertainty as with_uncertainty
from roughcontact.statistics.running_in import run_in as run_in
from roughcontact.statistics.sliding import sliding_friction as sliding_friction
from roughcontact.statistics.targets import first_yield_pressure as first_yield_pressure
from roughcontact.statistics.unloading import unload as unload
from roughcontact.study.running import workflow_file as workflow_file
from roughcontact.study.samples import sample_file as sample_file
from roughcontact.surface.faces.composite import composite as composite
from roughcontact.surface.faces.positions import relative_positions as relative_positions
from roughcontact.surface.levelling.level import level as level
from roughcontact.surface.profiles.surface import surface_from_profiles as surface_from_profiles
from roughcontact.surface.roughness.profile_parameters import profile_parameters as profile_parameters
from roughcontact.surface.synthetic import self_affine_surface as self_affine_surface
from roughcontact.surface.window.areal import parameters as parameters
from roughcontact.surface.window.areal import power_spectrum as power_spectrum
from roughcontact.surface.window.periodic_window import periodic_window as periodic_window
from roughcontact.uncertainty.budget import error_budget as error_budget
from roughcontact.uncertainty.differences import compare_groups as compare_groups
from roughcontact.uncertainty.groups import group_statistics as group_statistics

__version__: str
