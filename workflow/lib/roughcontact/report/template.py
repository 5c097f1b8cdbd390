"""The pages' templates: where they lie, and how they are read."""

from pathlib import Path

import jinja2

_TEMPLATES = Path(__file__).with_name("templates")


def template(name: str, *, folder: Path | None = None) -> jinja2.Template:
    """Return one of the package's templates, with HTML escaped and no surprise where a name is missing.

    Parameters
    ----------
    name : str
        file name of the template.
    folder : Path, optional
        of the templates of another page; those of the report can be included there.

    Returns
    -------
    Template
        to be rendered; a variable that it names and does not get is an error.

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
