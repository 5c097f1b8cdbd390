"""Plot run time against error of all surfaces: results/cost.html."""

import pandas as pd
from _job import snakemake

from roughcontact.cost.page import write_page

files = zip(snakemake.params.names, snakemake.input, strict=True)
write_page(snakemake.output[0], {name: pd.read_csv(path) for name, path in files})
