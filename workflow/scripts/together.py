"""Take one surface through several stages in one process; each leaves the files that it leaves alone."""

import os
import runpy
from pathlib import Path
from types import SimpleNamespace

import _job

from roughcontact.configuration.stages import STEPS

job = _job.snakemake
for name in job.params.links:
    here = Path(job.output[name])
    here.symlink_to(os.path.relpath(job.input[name], here.parent))
files = dict(job.input.items()) | dict(job.output.items())
named = type(job.input)  # a list whose entries have names
for name in job.params.steps:
    step = STEPS[name]
    settings = SimpleNamespace(settings=job.params.settings[name], file=job.params.get("file"))
    of_step = {
        "rule": name,
        "input": named(fromdict={key: files[key] for key in step.inputs if files.get(key)}),
        "output": named(fromdict={key: files[key] for key in step.outputs}),
        "log": [job.log[name]],
        "params": settings,
    }
    _job.begin(SimpleNamespace(**of_step, wildcards=job.wildcards, threads=job.threads))
    runpy.run_path(str(Path(_job.__file__).with_name(f"{name}.py")))
