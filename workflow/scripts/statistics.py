"""Count what is in the contact: contact.nc and uncertainty.nc to statistics.nc."""

from _job import save, snakemake

from roughcontact.results.storage import read_dataset
from roughcontact.statistics.contact_statistics import contact_statistics, with_uncertainty

settings = snakemake.params.settings
contact, budget = (read_dataset(snakemake.input[name]) for name in ("contact", "uncertainty"))
bodies = settings["contact"]["bodies"]
statistics = with_uncertainty(contact_statistics(contact, bodies=bodies, **settings["statistics"]), budget)
save(statistics, snakemake.output[0], settings, source=contact["height"].attrs)
