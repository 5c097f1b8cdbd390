"""Real runs of the workflow on small maps, in folders of their own, with a copy of the workflow to edit."""

import shutil

import pytest
from small_project import QUICK, ROOT, project_with_maps

collect_ignore = ["conda_environment.py"]  # a program that needs conda's parser: .ci/run installs it


@pytest.fixture(scope="session")
def checkout(tmp_path_factory):
    """A copy of the workflow for tests to edit; with the compiled kernels that are kept beside it."""
    folder = tmp_path_factory.mktemp("checkout")
    shutil.copy(ROOT / "Snakefile", folder)
    shutil.copytree(ROOT / "workflow", folder / "workflow", ignore=shutil.ignore_patterns("*.pyc"))
    return folder


@pytest.fixture(scope="session")
def finished(tmp_path_factory, checkout):
    """A project, in a folder whose name has spaces, in which the workflow has run once from elsewhere.

    Each job was a process of its own, as under a plain `snakemake`.
    """
    project = project_with_maps(tmp_path_factory.mktemp("first") / "a study with spaces", checkout)
    project.first = project.succeed("--executor", "local")
    return project


@pytest.fixture(scope="session")
def finished_quickly(tmp_path_factory, checkout):
    """A project in which the workflow has run once without intervals: to be copied, not changed."""
    project = project_with_maps(tmp_path_factory.mktemp("finished") / "project", checkout, QUICK)
    project.first = project.succeed("--logger", "roughcontact")
    return project


@pytest.fixture
def project(tmp_path, checkout):
    """A project with maps, table and settings in which nothing has run."""
    return project_with_maps(tmp_path / "project", checkout)
