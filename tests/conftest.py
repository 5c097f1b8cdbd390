"""Which tests run, and in which order: those of real files only where these are, the longest first."""

import os

import pytest
import shared_data


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
