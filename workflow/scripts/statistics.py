"""Count what is in the contact: contact.nc to statistics.nc."""

from _job import save, snakemake

from roughcontact.statistics import contact_statistics
from roughcontact.storage import read_dataset

settings = snakemake.params.settings
contact = read_dataset(snakemake.input[0])
statistics = contact_statistics(contact, **settings["statistics"])
save(statistics, snakemake.output[0], settings, source=contact["height"].attrs)
