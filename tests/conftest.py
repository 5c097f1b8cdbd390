"""Tests that need the folder of real instrument files are skipped where it is absent."""

import os

import pytest
import shared_data


def pytest_configure():
    if os.environ.get(shared_data.VARIABLE) and not shared_data.FOUND:
        raise pytest.UsageError(f"{shared_data.VARIABLE} = {shared_data.DATA}: no CATALOG.tsv in that folder")


def pytest_collection_modifyitems(items):
    if shared_data.FOUND:
        return
    absent = pytest.mark.skip(reason=f"no folder of real instrument files; {shared_data.VARIABLE} names it")
    for item in items:
        if item.get_closest_marker("shared_data"):
            item.add_marker(absent)
