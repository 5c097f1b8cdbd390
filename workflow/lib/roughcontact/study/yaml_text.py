"""The text of a configuration file, checked before Snakemake reads it: each mistake with file and line.

A few lines can stand for billions of values (aliases, merge keys): nothing is expanded, nodes are counted.
"""

import re
from collections import Counter
from pathlib import Path
from typing import TYPE_CHECKING

from roughcontact.errors import SettingsError

if TYPE_CHECKING:
    import yaml

MAX_VALUES = 100_000  # of a configuration: a thousand times as many as in a large study
_MAX_BYTES = 500_000  # the default configuration, with its comments, has a fiftieth
_MAX_LEVELS = 50  # settings have six
_MAX_DIGITS = 300  # of a whole number: no floating-point number has more before its point
_PREFIX = "tag:yaml.org,2002:"
_OCTAL = re.compile(r"[-+]?0[0-7_]+")
_BASE_60 = re.compile(r"[-+]?[0-9_]+(?::[0-9]+)+")


def check_yaml(file: Path) -> None:
    """Raise a SettingsError for a configuration that is unreadable, ambiguous or larger than any study.

    Ambiguous are duplicate keys, of which YAML takes only the last, and numbers that are not decimal.
    """
    import yaml  # comes with Snakemake

    text = _text(file)
    try:
        root = yaml.compose(text, Loader=yaml.SafeLoader)
        if root is None:
            raise SettingsError(f"{file}: is empty; `roughcontact init` writes one to change")
        if not isinstance(root, yaml.MappingNode):
            raise SettingsError(f"{file}: has no keys at its top level, such as `contact:`")
        _Document(file, duplicates="__use_yte__" in text).check(root, "")
        yaml.constructor.SafeConstructor().construct_document(root)
    except yaml.YAMLError as error:
        mark, problem = (getattr(error, key, None) for key in ("problem_mark", "problem"))
        line = f", line {mark.line + 1}" if mark else ""
        raise SettingsError(
            f"{file}{line}: is not valid YAML ({problem or error}); check this line and those above it"
        ) from error
    except RecursionError:
        raise SettingsError(f"{file}: is nested too deeply; write fewer levels") from None


def _text(file: Path) -> str:
    """Return the text of a configuration file of reasonable size."""
    try:
        with file.open("rb") as stream:
            content = stream.read(_MAX_BYTES + 1)
        if len(content) > _MAX_BYTES:
            raise SettingsError(
                f"{file}: is larger than {_MAX_BYTES // 1000} kB, as no configuration is; name the right file"
            )
        return content.decode("utf-8")
    except (OSError, UnicodeDecodeError) as error:
        raise SettingsError(f"{file}: is not UTF-8 text ({error}); save it as such") from error


def _check_tag(node: "yaml.Node", origin: str, where: str) -> None:
    """Raise an error for a value that YAML would hand to a program, such as !!python/object."""
    import yaml

    constructors = yaml.SafeLoader.yaml_constructors
    if node.tag not in constructors and node.tag not in (f"{_PREFIX}merge", f"{_PREFIX}value"):
        tag = node.tag.replace(_PREFIX, "!!", 1)
        raise SettingsError(
            f"{origin}: {where or 'the configuration'} has the tag {tag:.80}, which is not admitted; delete "
            "the tag and write a number, text, list or group"
        )


def _check_scalar(node: "yaml.ScalarNode", origin: str, where: str) -> None:
    """Raise an error for a scalar that is not what its form or tag says, or a number that is not decimal."""
    import yaml

    text = node.value
    start = f"{origin}: {where:.80} = {text if len(text) <= 40 else text[:20] + ' ...'}"
    is_integer = node.tag == f"{_PREFIX}int"
    if is_integer and len(text) > _MAX_DIGITS:
        raise SettingsError(
            f"{start}: a whole number of {len(text)} digits; write one of at most {_MAX_DIGITS}"
        )
    if node.tag in (f"{_PREFIX}merge", f"{_PREFIX}value"):
        return
    try:
        value = yaml.constructor.SafeConstructor().construct_object(node)
    except (ValueError, LookupError, AttributeError) as error:
        tag = node.tag.removeprefix(_PREFIX)
        raise SettingsError(
            f"{start}: is no valid {tag} ({error}); correct it, or put it in quotes"
        ) from error
    if is_integer and _OCTAL.fullmatch(text) and value != int(text.replace("_", "")):
        raise SettingsError(
            f"{start}: YAML reads a number that begins with 0 as octal, here as {value}; delete the leading "
            "zeros if it is decimal, put it in quotes if it is text"
        )
    if is_integer and _BASE_60.fullmatch(text):
        raise SettingsError(
            f"{start}: YAML reads numbers with colons to the base of 60, here as {value}; write a decimal "
            "number, or put it in quotes if it is text"
        )


class _Document:
    """Checks every node of a file once: in the order of the text an alias stands for what is known."""

    def __init__(self, file: Path, *, duplicates: bool):
        self.file, self.duplicates = file, duplicates
        self.sizes: dict[int, tuple[int, int] | None] = {}  # values and levels of a node, None within it

    def check(self, node: "yaml.Node", where: str) -> tuple[int, int]:
        """Return how many values and levels a node has with all aliases; raise an error for what is wrong."""
        import yaml

        origin = f"{self.file}, line {node.start_mark.line + 1}"
        if id(node) in self.sizes:
            if size := self.sizes[id(node)]:
                return size
            raise SettingsError(
                f"{origin}: a value contains an alias (*name) of itself; write out what is meant"
            )
        self.sizes[id(node)] = None
        _check_tag(node, origin, where)
        below: list[tuple[yaml.Node, str]] = []
        if isinstance(node, yaml.ScalarNode):
            _check_scalar(node, origin, where)
        elif isinstance(node, yaml.SequenceNode):
            below = [(item, f"{where}[{number}]") for number, item in enumerate(node.value)]
        else:
            keys = Counter(key.value for key, _ in node.value if isinstance(key, yaml.ScalarNode))
            twice = [key for key, _ in node.value if isinstance(key, yaml.ScalarNode) and keys[key.value] > 1]
            if twice and not self.duplicates:
                raise SettingsError(
                    f"{self.file}, line {twice[0].start_mark.line + 1}: {twice[0].value} occurs twice in the "
                    "same group; delete one of them"
                )
            below = [
                (child, f"{where}.{key.value}".removeprefix("."))
                for key, value in node.value
                for child in (key, value)
            ]
        sizes = [self.check(child, name) for child, name in below]
        values = 1 + sum(size for size, _ in sizes)
        levels = 1 + max((depth for _, depth in sizes), default=0)
        if values > MAX_VALUES:
            raise SettingsError(
                f"{origin}: the configuration has more than {MAX_VALUES} values up to here: look for "
                "aliases (*name) that stand for one another, and write out their values"
            )
        if levels > _MAX_LEVELS:
            raise SettingsError(f"{origin}: is nested too deeply; write fewer levels")
        self.sizes[id(node)] = values, levels
        return values, levels
