"""Textual summary of what levelling changed, for reports and the command line."""

import json
from collections.abc import Mapping
from typing import Any

from roughcontact.quantities import counted_noun


def removed_and_filled(levelled: Mapping[str, Any]) -> str:
    """Return a summary of filled points, rejected points and row alignment, from a levelled map's attributes.

    Examples
    --------
    >>> removed_and_filled({"filled_points": 9, "largest_hole": 4, "outlier_kinds": '{"dead_line": 3}'})
    '9 points filled in (largest hole 4), 0 outliers rejected (3 in dead lines)'
    """
    filled, rejected = levelled.get("filled_points", 0), levelled.get("outliers_rejected", 0)
    hole = f" (largest hole {levelled['largest_hole']})" if filled else ""
    named = rejected_by_kind(levelled)
    rejections = f"{counted_noun(rejected, 'outlier')} rejected" + (f" ({named})" if named else "")
    aligned = levelled.get("line_alignment", "none")
    rows = f", rows aligned ({aligned})" if aligned != "none" else ""
    return f"{counted_noun(filled, 'point')} filled in{hole}, {rejections}{rows}"


def rejected_by_kind(levelled: Mapping[str, Any]) -> str:
    """Return as text how many points of each kind were rejected, empty for none, from a map's attributes.

    Examples
    --------
    >>> rejected_by_kind({"outlier_kinds": '{"spike": 29, "dead_line": 128}'})
    '29 in spikes, 128 in dead lines'
    """
    outlier_kinds = json.loads(levelled.get("outlier_kinds", "{}"))
    counts = ((count, outlier_kind.replace("_", " ")) for outlier_kind, count in outlier_kinds.items())
    return ", ".join(
        f"1 {outlier_kind}" if count == 1 else f"{count} in {outlier_kind}s" for count, outlier_kind in counts
    )


def s_filter_of(attrs: Mapping[str, Any]) -> float:
    """Return the nesting index (m) of the S-filter that a map has gone through, 0 without one.

    Examples
    --------
    >>> s_filter_of({}), s_filter_of({"filters_removed": '{"s_filter": {"nesting_index": {"value": 2e-6}}}'})
    (0.0, 2e-06)
    """
    filters = json.loads(attrs.get("filters_removed", "{}"))
    return float(filters["s_filter"]["nesting_index"]["value"]) if "s_filter" in filters else 0.0
