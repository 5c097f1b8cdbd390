"""Count what is in the contact: contact.nc and uncertainty.nc to statistics.nc."""

from _job import save, snakemake

from roughcontact.results.storage import opened_dataset, read_dataset
from roughcontact.statistics.checks import with_verdicts
from roughcontact.statistics.contact_statistics import contact_statistics, with_uncertainty
from roughcontact.statistics.first_yield import with_first_yield
from roughcontact.statistics.subsurface import with_subsurface_yield

settings = snakemake.params.settings
budget = read_dataset(snakemake.input.uncertainty)
bodies = settings["contact"]["bodies"]
with opened_dataset(snakemake.input.contact) as contact:  # load by load: the maps of all are large
    counted = contact_statistics(contact, bodies=bodies, **settings["statistics"]).load()
    height = contact["height"].load()
yielding = with_first_yield(counted, height, settings["contact"], threads=snakemake.threads)
complete = with_subsurface_yield(with_uncertainty(yielding, budget), bodies)
statistics = with_verdicts(complete, height)
save(statistics, snakemake.output[0], settings, source=height.attrs)
