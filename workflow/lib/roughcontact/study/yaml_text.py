"""The text of a configuration file, checked before Snakemake reads it: each mistake with file and line."""

import re
from collections import Counter
from collections.abc import Mapping
from pathlib import Path
from typing import TYPE_CHECKING, Any

from roughcontact.errors import SettingsError

if TYPE_CHECKING:
    import yaml

_MAX_VALUES = 100_000  # of a configuration: a thousand times as many as in a large study
# whole numbers that YAML reads to the base of 8, or with colons to that of 60
_NOT_DECIMAL = re.compile(r"[-+]?(0[0-7_]+|[0-9_]+(:[0-9]+)+)")
_PREFIX = "tag:yaml.org,2002:"
_NO_VALUES = (f"{_PREFIX}merge", f"{_PREFIX}value")  # the tags of << and =


def check_yaml(file: Path) -> dict[str, Any]:
    """Return a configuration; raise a SettingsError for one unreadable, ambiguous or larger than any study.

    Ambiguous are duplicate keys, of which YAML takes only the last, and numbers that are not decimal.
    """
    import yaml  # comes with Snakemake

    try:
        config = _loader(file)(file.read_text("utf-8")).get_single_data()
    except (OSError, UnicodeDecodeError) as error:
        raise SettingsError(f"{file}: is not UTF-8 text ({error}); save it as such") from error
    except yaml.YAMLError as error:
        mark, problem = (getattr(error, key, None) for key in ("problem_mark", "problem"))
        line = f", line {mark.line + 1}" if mark else ""
        raise SettingsError(
            f"{file}{line}: is not valid YAML ({problem or error}); check this line and those above it"
        ) from error
    except RecursionError:
        raise SettingsError(f"{file}: is nested too deeply; write fewer levels") from None
    if config is None:
        raise SettingsError(f"{file}: is empty; `roughcontact init` writes one to change")
    if not isinstance(config, Mapping):
        raise SettingsError(f"{file}: has no keys at its top level, such as `contact:`")
    check_size(config, str(file))
    return dict(config)


def check_size(config: Mapping[str, Any], origin: str = "the configuration") -> None:
    """Reject more values than any study has: a few lines of aliases can stand for a billion."""
    waiting: list[Any] = [config]
    for _ in range(_MAX_VALUES):
        if not waiting:
            return
        value = waiting.pop()
        if isinstance(value, Mapping):
            waiting += value.values()
        elif isinstance(value, list):
            waiting += value
    raise SettingsError(
        f"{origin}: has more than {_MAX_VALUES} values: look for aliases (*name) that stand for one another, "
        "and write out their values"
    )


def _loader(file: Path) -> "type[yaml.SafeLoader]":
    """Return the loader of YAML that refuses what is ambiguous in a file."""
    import yaml

    def refuse(node: yaml.Node, mistake: str) -> None:
        raise SettingsError(f"{file}, line {node.start_mark.line + 1}: {mistake}")

    class Loader(yaml.SafeLoader):
        """Refuses duplicate keys, and values that are not what they look like."""

        def compose_mapping_node(self, anchor: Any) -> Any:
            node = super().compose_mapping_node(anchor)
            keys = [key for key, _ in node.value if isinstance(key, yaml.ScalarNode)]
            counts = Counter(key.value for key in keys)
            for key in keys:
                if counts[key.value] > 1:
                    refuse(key, f"{key.value} occurs twice in the same group; delete one of them")
            return node

        def flatten_mapping(self, node: Any) -> Any:
            super().flatten_mapping(node)
            if len(node.value) > _MAX_VALUES:  # before 6.0.4 PyYAML keeps what is merged twice
                refuse(node, f"has more than {_MAX_VALUES} values by merge keys (<<); write out its values")

        def compose_scalar_node(self, anchor: Any) -> Any:
            node = super().compose_scalar_node(anchor)
            if node.tag in _NO_VALUES:
                return node
            text, kind = f"{node.value:.20}", node.tag.removeprefix(_PREFIX)
            try:
                value = str(yaml.constructor.SafeConstructor().construct_object(node))
            except (ValueError, LookupError, AttributeError) as error:
                refuse(node, f"{text} is no valid {kind} ({error}); correct it, or put it in quotes")
            if (
                kind == "int"
                and _NOT_DECIMAL.fullmatch(node.value)
                and (":" in text or value != str(int(text)))
            ):
                refuse(
                    node,
                    f"YAML reads {text} to the base of {60 if ':' in text else 8}, here as {value}; write a "
                    "decimal number without leading zeros, or put it in quotes if it is text",
                )
            return node

    return Loader
