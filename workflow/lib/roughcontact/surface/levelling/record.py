"""Textual summary of what levelling changed, for reports and the command line."""

from collections.abc import Mapping
from typing import Any

from roughcontact.arguments.measurement import json_attribute
from roughcontact.arguments.quantities import counted_noun


def removed_and_filled(attrs: Mapping[str, Any]) -> str:
    """Return a summary of filled points, rejected points and row alignment, from a levelled map's attributes.

    Examples
    --------
    >>> removed_and_filled({"filled_points": 9, "largest_hole": 4, "outlier_kinds": '{"dead_line": 3}'})
    '9 points filled in (largest hole 4), 0 outliers rejected (3 in dead lines)'
    """
    filled_points, outlier_count = attrs.get("filled_points", 0), attrs.get("outliers_rejected", 0)
    hole = f" (largest hole {attrs['largest_hole']})" if filled_points else ""
    kinds = rejected_by_kind(attrs)
    rejections = f"{counted_noun(outlier_count, 'outlier')} rejected" + (f" ({kinds})" if kinds else "")
    alignment = attrs.get("line_alignment", "none")
    rows = f", rows aligned ({alignment})" if alignment != "none" else ""
    return f"{counted_noun(filled_points, 'point')} filled in{hole}, {rejections}{rows}"


def rejected_by_kind(attrs: Mapping[str, Any]) -> str:
    """Return as text how many points of each kind were rejected, empty for none, from a map's attributes.

    Examples
    --------
    >>> rejected_by_kind({"outlier_kinds": '{"spike": 29, "dead_line": 128}'})
    '29 in spikes, 128 in dead lines'
    """
    outlier_kinds = json_attribute(attrs, "outlier_kinds")
    counts = ((count, outlier_kind.replace("_", " ")) for outlier_kind, count in outlier_kinds.items())
    return ", ".join(
        f"1 {outlier_kind}" if count == 1 else f"{count} in {outlier_kind}s" for count, outlier_kind in counts
    )


def s_index(attrs: Mapping[str, Any]) -> float:
    """Return the nesting index (m) of the S-filter that a map has gone through, 0 without one.

    Examples
    --------
    >>> s_index({}), s_index({"filters_removed": '{"s_filter": {"nesting_index": {"value": 2e-6}}}'})
    (0.0, 2e-06)
    """
    filters = json_attribute(attrs, "filters_removed")
    return float(filters["s_filter"]["nesting_index"]["value"]) if "s_filter" in filters else 0.0
