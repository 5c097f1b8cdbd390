"""Count what is in the contact: contact.nc and uncertainty.nc to statistics.nc."""

from _job import save, snakemake

from roughcontact.results.storage import read_dataset
from roughcontact.statistics.checks import with_verdicts
from roughcontact.statistics.contact_statistics import contact_statistics, with_uncertainty
from roughcontact.statistics.first_yield import with_first_yield
from roughcontact.statistics.subsurface import with_subsurface_yield

settings = snakemake.params.settings
contact, budget = (read_dataset(snakemake.input[name]) for name in ("contact", "uncertainty"))
bodies = settings["contact"]["bodies"]
counted = contact_statistics(contact, bodies=bodies, **settings["statistics"])
yielding = with_first_yield(counted, contact["height"], settings["contact"], threads=snakemake.threads)
complete = with_subsurface_yield(with_uncertainty(yielding, budget), bodies)
statistics = with_verdicts(complete, contact["height"])
save(statistics, snakemake.output[0], settings, source=contact["height"].attrs)
