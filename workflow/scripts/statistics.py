"""Count what is in the contact: contact.nc and uncertainty.nc to statistics.nc."""

from _job import save, snakemake

from roughcontact.results.storage import opened_dataset, read_dataset
from roughcontact.statistics.checks import with_verdicts
from roughcontact.statistics.contact_statistics import statistics_of, with_uncertainty
from roughcontact.statistics.first_yield import with_first_yield
from roughcontact.statistics.subsurface import with_subsurface_yield

settings = snakemake.params.settings
budget = read_dataset(snakemake.input.uncertainty)
bodies = settings["contact"]["bodies"]
with opened_dataset(snakemake.input.contact) as contact:  # which keeps what has been read
    modulus = float(contact["contact_modulus"])
    count = statistics_of(contact["height"], contact_modulus=modulus, bodies=bodies, **settings["statistics"])
# load by load, without the heights: the maps are large
with opened_dataset(snakemake.input.contact) as contact:
    counted = count(contact).load()
    height = contact["height"]
    yielding = with_first_yield(counted, height, settings["contact"], threads=snakemake.threads)
    complete = with_subsurface_yield(with_uncertainty(yielding, budget), bodies)
    statistics = with_verdicts(complete, height)
save(statistics, snakemake.output[0], settings, source=height.attrs)
