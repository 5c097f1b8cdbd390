"""Which tests run, and in which order: those of real files only where these are, the longest first."""

import os
import subprocess

import pytest
import shared_data
from case_tables import cases_of


def pytest_configure():
    if os.environ.get(shared_data.VARIABLE) and not shared_data.FOUND:
        raise pytest.UsageError(f"{shared_data.VARIABLE} = {shared_data.DATA}: no CATALOG.tsv in that folder")


def pytest_collection_modifyitems(items):
    # of workers side by side none is left alone with a run of the workflow at the end
    items.sort(key=lambda item: item.path.parent.name not in ("workflow", "golden"))
    if shared_data.FOUND:
        return
    absent = pytest.mark.skip(reason=f"no folder of real instrument files; {shared_data.VARIABLE} names it")
    for item in items:
        if item.get_closest_marker("shared_data"):
            item.add_marker(absent)


def pytest_generate_tests(metafunc):
    if metafunc.definition.get_closest_marker("cases"):
        metafunc.parametrize(*cases_of(metafunc.module.__name__, metafunc.function.__name__))


def pytest_make_parametrize_id(val, argname):
    # bytes of a file hold the second in which it was made, and workers side by side must name a test alike
    return argname if isinstance(val, bytes) else None


@pytest.fixture
def read(tmp_path):
    """A function that reads the content of a file."""

    from measured_files import read_height_map, saved  # which other tests need not wait for

    def _read(content, *, name="map.dat", encoding="utf-8", **arguments):
        return read_height_map(saved(tmp_path, content, name, encoding), **arguments)

    return _read


@pytest.fixture
def refusal(tmp_path):
    """A function that asserts that the content of a file is refused in such words."""

    from measured_files import refuses, saved

    def _refusal(content, words, *, name="map.dat", encoding="utf-8", **arguments):
        return refuses(words, saved(tmp_path, content, name, encoding), **arguments)

    return _refusal


@pytest.fixture
def disk(tmp_path):
    """A function that mounts a disk of a size at a new folder; as `remount` it changes the options of one."""
    mounted = []

    def mount(options, folder=None):
        mount_point = folder or tmp_path / f"disk-{len(mounted)}"
        mount_point.mkdir(exist_ok=True)
        words = ["mount", "-t", "tmpfs", "-o", f"remount,{options}" if folder else options]
        if os.name != "posix" or os.geteuid():
            pytest.skip("only root may mount a small disk")
        if subprocess.run([*words, "tmpfs", str(mount_point)], check=False, capture_output=True).returncode:
            pytest.skip("no disk may be mounted here")
        mounted.append(mount_point)
        return mount_point

    yield mount
    for mounted_folder in set(
        mounted
    ):  # lazily: a netCDF file whose writing failed is closed when it is collected
        subprocess.run(["umount", "--lazy", str(mounted_folder)], check=True)
