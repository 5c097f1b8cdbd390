"""The pages' templates: where they lie, and how they are read."""

import base64
import hashlib
import re
import sys
from contextlib import suppress
from functools import cache
from importlib.util import cache_from_source
from pathlib import Path
from typing import TYPE_CHECKING, Any

from markupsafe import Markup, escape

from roughcontact.arguments import quantities
from roughcontact.arguments.quantities import number, percent, quantity
from roughcontact.errors import turns_escaped

if TYPE_CHECKING:
    import jinja2

_KEY = r"[a-z]+(?:\.[a-z_]+)+(?:: [a-z0-9]+)?"  # of a setting, and its value
_TEMPLATES = Path(__file__).with_name("templates")


def template(name: str, *, folder: Path | None = None) -> "jinja2.Template":
    """Return one of the package's templates, those in HTML escaped; a missing variable is an error."""
    return _environment(folder).get_template(name)


def script_digests() -> str:
    """Return the scripts of the pages as a Content-Security-Policy names them."""
    return _digests("".join(template(name).render() for name in ("figures.html", "sort.html")))


def read_all() -> None:
    """Compile every template, which takes longer than to fill it: for the forks of this process."""
    environment = _environment(None)
    for name in environment.list_templates():
        environment.get_template(name)


def sentence(name: str, *values: Any) -> str:
    """Return a sentence of `sentences.txt` with these values."""
    return paragraph(getattr(template("sentences.txt").module, name)(*values))


def paragraph(text: str) -> str:
    """Return a text of a template as one line."""
    return re.sub(r"[ \n]+", " ", text).strip()


@cache
def _environment(folder: Path | None) -> "jinja2.Environment":
    """Return where templates are looked for; it keeps those that were read."""
    import jinja2  # late: what prints numbers alone fills no template

    folders = [_TEMPLATES] if folder is None else [folder, _TEMPLATES]
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(folders),
        autoescape=jinja2.select_autoescape(("html", "svg")),
        undefined=jinja2.StrictUndefined,
        finalize=_shown,
        trim_blocks=True,
        lstrip_blocks=True,
        bytecode_cache=None if sys.dont_write_bytecode else _bytecode_cache(),
    )
    environment.filters |= {"digests": _digests, "raised": _raised}
    environment.filters |= {"number": number, "percent": percent, "quantity": quantity}
    return environment


def _bytecode_cache() -> "jinja2.BytecodeCache":
    """Return where compiled templates are kept: beside the modules that Python has compiled, as they are."""
    from jinja2 import FileSystemBytecodeCache
    from jinja2.bccache import Bucket

    class Cache(FileSystemBytecodeCache):
        """Compiled templates, none in a folder that cannot be used and no more on a full disk."""

        def load_bytecode(self, bucket: Bucket) -> None:
            with suppress(OSError):
                super().load_bytecode(bucket)

        def dump_bytecode(self, bucket: Bucket) -> None:
            with suppress(OSError):
                Path(self.directory).mkdir(parents=True, exist_ok=True)
                super().dump_bytecode(bucket)

    # Jinja compares the text of a template; options and filters of constants are compiled in, too
    sources = [Path(file).read_bytes() for file in (__file__, quantities.__file__)]
    digest = hashlib.sha256(b"".join(sources)).hexdigest()[:16]
    return Cache(str(Path(cache_from_source(__file__)).parent), f"template.{digest}-%s.pyc")


def _shown(value: Any) -> Any:
    """Return a value as a page shows it: a name of somebody else's turns no text that stands beside it."""
    return turns_escaped(value) if isinstance(value, str) and not isinstance(value, Markup) else value


def _raised(text: str) -> Markup:
    """Return a text as markup: exponents as in q^−3 are raised, keys of settings in brackets are small."""
    markup = re.sub(r"\^(−?[\d.]*\d)", r"<sup>\1</sup>", str(escape(turns_escaped(text))))
    return Markup(re.sub(rf" ?\((?:{_KEY}(?:, | or )?)+\)", r'<span class="key">\g<0></span>', markup))


def _digests(markup: str) -> Markup:
    """Return the content of each style and script of a page as a Content-Security-Policy names it."""
    contents = re.findall(r"<(?:style|script)>(.*?)</(?:style|script)>", markup, re.DOTALL)
    digests = (base64.b64encode(hashlib.sha256(content.encode()).digest()).decode() for content in contents)
    return Markup(" ".join(f"'sha256-{digest}'" for digest in digests))
