"""Read the conda environment by conda's own parser, and hold its limits against what is installed.

    python -m venv conda && conda/bin/pip install py-rattler packaging PyYAML
    conda/bin/python tests/workflow/conda_environment.py .venv/bin/python

Fails where a line is not understood, or where a package that the tests run with is not admitted.
"""

import json
import subprocess
import sys
from pathlib import Path

import yaml
from packaging.requirements import Requirement
from rattler import MatchSpec, Version, VersionSpec

ROOT = Path(__file__).parents[2]
NAMES = {"matplotlib-base": "matplotlib"}


def installed(python: str) -> dict[str, str]:
    """Return the versions of all packages beside a Python, and its own."""
    listed = subprocess.check_output([python, "-m", "pip", "list", "--format=json"])
    version = subprocess.check_output([python, "-c", "import platform; print(platform.python_version())"])
    packages = {package["name"].lower(): package["version"] for package in json.loads(listed)}
    return packages | {"python": version.decode().strip()}


def main(python: str) -> int:
    """Print every line that does not admit what is installed; return how many there are."""
    environment = yaml.safe_load((ROOT / "workflow/envs/roughcontact.yaml").read_text(encoding="utf-8"))
    versions = installed(python)
    refused = []
    for line in environment["dependencies"]:
        if isinstance(line, dict):  # what pip installs
            requirements = map(Requirement, line["pip"])
            refused += [str(r) for r in requirements if versions[r.name.lower()] not in r.specifier]
            continue
        spec = MatchSpec(line, strict=True)
        name = spec.name.normalized
        version = versions[NAMES.get(name, name)]
        if spec.version and not VersionSpec(spec.version).matches(Version(version)):
            refused.append(f"{line}: {version} is installed")
    print("\n".join(refused) or f"{len(environment['dependencies'])} lines admit what is installed")
    return len(refused)


if __name__ == "__main__":
    sys.exit(main(sys.argv[1]))
