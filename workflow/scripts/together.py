"""Take one surface through several stages in one process; each leaves the files that it leaves alone."""

import os
import runpy
from pathlib import Path

import _job

from roughcontact.configuration.stages import STEPS

job = _job.snakemake
for name in job.params.links:
    here = Path(job.output[name])
    here.symlink_to(os.path.relpath(job.input[name], here.parent))
for name in job.params.steps:
    _job.begin(_job.of_step(job, name, STEPS[name]))
    runpy.run_path(str(Path(_job.__file__).with_name(f"{name}.py")))
