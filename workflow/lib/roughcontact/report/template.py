"""The pages' templates: where they lie, and how they are read."""

from pathlib import Path

import jinja2

_TEMPLATES = Path(__file__).with_name("templates")


def template(name: str, *, folder: Path | None = None) -> jinja2.Template:
    """Return one of the package's templates, HTML escaped; a missing variable is an error.

    `folder` has the templates of other pages, which can include those of the report.

    Examples
    --------
    >>> ":root" in template("report.css").render()
    True
    """
    folders = [_TEMPLATES] if folder is None else [folder, _TEMPLATES]
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(folders),
        autoescape=True,
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        lstrip_blocks=True,
    )
    return environment.get_template(name)
