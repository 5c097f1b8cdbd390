"""Tables that lie beside their modules: cells between tabs, comments after a hash."""

from pathlib import Path


def rows_beside(module: str, table: str) -> list[list[str]]:
    """Return the cells of each row of a table in the folder of a module, by its `__file__`.

    Examples
    --------
    >>> rows_beside(__file__, "units.tsv")[1][:4]
    ['m', '1', 'm', 'metre']
    """
    lines = Path(module).with_name(table).read_text(encoding="utf-8").splitlines()
    return [line.split("\t") for line in lines if not line.startswith("#")]
