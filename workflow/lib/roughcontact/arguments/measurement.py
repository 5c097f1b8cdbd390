"""What is recorded of a height map beside its heights: how it was measured, read, levelled and cut out.

In memory these are attributes of the map, a number or a text each, so that xarray shows them and any function
may add one. Here alone it is said which of them hold JSON, and how a file holds them: those of one concept as
one attribute, a JSON object, since a list of a hundred attributes is read by nobody.
"""

import json
import re
from collections.abc import Mapping
from dataclasses import asdict, dataclass, fields
from typing import Any

from roughcontact.arguments.rows import rows_beside

# attributes of statistics whose text is JSON, and its kind for one surface; by case it is an object
_OF_STATISTICS: dict[str, type] = {
    **dict.fromkeys(("settings", "versions", "bands", "verdicts", "temperatures"), dict),
    **dict.fromkeys(("reasons", "remarks", "left_out", "failed", "bodies"), list),
}
# those of a map as well
_STRUCTURED: dict[str, type] = _OF_STATISTICS | {
    **dict.fromkeys(("instrument", "ingest_spikes", "ingest_sources"), dict),
    **dict.fromkeys(("form_removed", "outlier_kinds", "filters_removed", "profile_spectra"), dict),
    **dict.fromkeys(("channels", "ingest_warnings", "ingest_facts", "profile_warnings"), list),
}
_INSTRUMENT = "instrument_"  # begins what the table of surfaces, or the settings, say of the instrument
# attribute of a file -> those of the map that it holds, by a pattern of their names
_CONCEPTS = {concept: re.compile(names) for concept, names in rows_beside(__file__, "concepts.tsv")}


@dataclass(frozen=True)
class Instrument:
    """What is stated of an instrument for the error budget, in SI units; None where nothing is.

    `noise` (m, rms), `resolution` (m), `numerical_aperture`, `wavelength` of the light (m), `tip_radius` (m),
    `amplification_z` and `amplification_xy` (relative, expanded), `lateral_period_limit` of the lens (m).

    Examples
    --------
    >>> Instrument.read({"instrument_noise": 1e-9, "Sq": 1e-7}).properties()
    {'noise': 1e-09}
    >>> Instrument(noise=1e-9).attributes()
    {'instrument_noise': 1e-09}
    """

    noise: float | None = None
    resolution: float | None = None
    numerical_aperture: float | None = None
    wavelength: float | None = None
    tip_radius: float | None = None
    amplification_z: float | None = None
    amplification_xy: float | None = None
    lateral_period_limit: float | None = None

    @classmethod
    def read(cls, attrs: Mapping[Any, Any]) -> "Instrument":
        """Return the record from the attributes of a map or of its statistics."""
        names = [entry.name for entry in fields(cls)]
        return cls(**{name: attrs[key] for name in names if (key := f"{_INSTRUMENT}{name}") in attrs})

    def properties(self) -> dict[str, float]:
        """Return the properties that are stated, by their names in the settings."""
        return {name: value for name, value in asdict(self).items() if value is not None}

    def attributes(self) -> dict[str, float]:
        """Return the attributes that hold the stated properties."""
        return {f"{_INSTRUMENT}{name}": value for name, value in self.properties().items()}


def json_attribute(attrs: Mapping[Any, Any], name: str) -> Any:
    """Return the content of an attribute that holds JSON, empty where a map has none.

    Examples
    --------
    >>> json_attribute({"outlier_kinds": '{"spike": 29}'}, "outlier_kinds"), json_attribute({}, "channels")
    ({'spike': 29}, [])
    >>> json_attribute({"verdicts": '[["use", []]]'}, "verdicts")  # of one surface; of several an object
    [['use', []]]
    """
    content, kind = json.loads(attrs.get(name) or "null"), _STRUCTURED[name]
    is_known = isinstance(content, dict | list if name in _OF_STATISTICS else kind)
    return content if is_known else kind()  # of another program


def json_attributes(contents: Mapping[str, Any]) -> dict[str, str]:
    """Return contents as attributes that hold JSON, which `json_attribute` reads.

    Examples
    --------
    >>> json_attributes({"outlier_kinds": {"spike": 29}})
    {'outlier_kinds': '{"spike": 29}'}
    """
    return {
        name: json.dumps(content, ensure_ascii=False, default=_plain) for name, content in contents.items()
    }


def attributes_of_record(record: Mapping[str, Any]) -> dict[str, Any]:
    """Return what is recorded of a map as its attributes, lists and mappings of it as JSON.

    Examples
    --------
    >>> attributes_of_record({"channels": ["height"], "missing_points": 3})
    {'channels': '["height"]', 'missing_points': 3}
    """
    return {**record, **json_attributes({key: record[key] for key in record if key in _STRUCTURED})}


def add_remark(attrs: Mapping[Any, Any], remark: str, *, fact: bool) -> dict[str, str]:
    """Return the attributes of a map with a further warning of its reading, which may be a plain `fact`."""
    names = ("ingest_warnings", "ingest_facts") if fact else ("ingest_warnings",)
    return json_attributes({name: [*json_attribute(attrs, name), remark] for name in names})


def file_attributes(attrs: Mapping[str, Any]) -> dict[str, Any]:
    """Return the attributes of a map as a file has them: those of one concept as one, a JSON object.

    Examples
    --------
    >>> file_attributes({"units": "m", "Sq": 1e-7, "Sa": 8e-8})
    {'units': 'm', 'roughness_parameters': '{"Sq": 1e-07, "Sa": 8e-08}'}
    >>> file_attributes({"form_removed": '{"mean": 0}'})
    {'levelling': '{"form_removed": {"mean": 0}}'}
    """
    result: dict[str, Any] = {}
    groups: dict[str, dict[str, Any]] = {}
    for name, value in attrs.items():
        concept = next((key for key, names in _CONCEPTS.items() if names.fullmatch(name)), None)
        if concept is None:
            result[name] = value
        else:
            content = json_attribute(attrs, name) if name in _STRUCTURED else value
            groups.setdefault(concept, {})[name] = content
            result[concept] = ""  # in the place of the first of them
    return result | json_attributes(groups)


def map_attributes(attrs: Mapping[str, Any]) -> dict[str, Any]:
    """Return the attributes of a map from those of its file, also of one that has each by itself.

    Examples
    --------
    >>> map_attributes({"units": "m", "levelling": '{"form_removed": {"mean": 0}, "form": "mean"}'})
    {'units': 'm', 'form_removed': '{"mean": 0}', 'form': 'mean'}
    """
    result: dict[str, Any] = {}
    for name, value in attrs.items():
        content = _parsed(value) if name in _CONCEPTS else None
        result |= {name: value} if content is None else attributes_of_record(content)
    return result


def _parsed(text: Any) -> dict[str, Any] | None:
    """Return the JSON object in a text, None where it is something else: an attribute of another program."""
    try:
        content = json.loads(text) if isinstance(text, str) else None
    except ValueError:
        return None
    return content if isinstance(content, dict) else None


def _plain(value: Any) -> Any:
    """Return a number or an array of NumPy as JSON can hold it."""
    return value.tolist()
