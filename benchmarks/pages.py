"""Write the pages of the benchmarks: templates, filled from the tables in `benchmarks/results`.

    python benchmarks/pages.py

A table is a CSV file whose cells are shown as they stand: a page has the digits of its tables. Facts that are
no table (machine, versions, sizes) are in `about.json` beside them. The benchmarks write both with `publish`.
"""

import csv
import json
import re
from pathlib import Path

import jinja2
import pandas as pd

HERE = Path(__file__).resolve().parent
ROOT = HERE.parent
RESULTS = HERE / "results"
VALIDATION = ROOT / "docs/explanation/validation.csv"
PAGES = {
    "performance.md": ROOT / "docs/explanation/performance.md",
    "trust.md": ROOT / "docs/explanation/trust.md",
    "paper.md": ROOT / "paper/paper.md",
}
BLOCKS = {
    "peers": ROOT / "README.md",
    "aims": RESULTS / "speed.md",
    "window": RESULTS / "window.md",
    "bank": RESULTS / "bank.md",
    "groups": RESULTS / "groups.md",
    "readers": RESULTS / "readers.md",
}


def read(folder: Path) -> dict:
    """Return the tables of a benchmark by name, each a list of rows, and `about`."""
    tables_by_name = {
        path.stem: list(csv.DictReader(path.read_text("utf-8").splitlines())) for path in folder.glob("*.csv")
    }
    about = folder / "about.json"
    return tables_by_name | {"about": json.loads(about.read_text("utf-8")) if about.exists() else {}}


def where(rows: list[dict], **values: str) -> list[dict]:
    """Return the rows that have the wanted values, without these columns."""
    chosen = [row for row in rows if all(row[name] == value for name, value in values.items())]
    return [{name: value for name, value in row.items() if name not in values} for row in chosen]


def only(rows: list[dict], **values: str) -> dict:
    """Return the one row that has the wanted values."""
    (row,) = where(rows, **values)
    return row


def table(rows: list[dict]) -> str:
    """Return rows as a table in Markdown, without columns that are empty."""
    columns = [name for name in rows[0] if any(row[name] for row in rows)]
    cells = [columns, ["---"] * len(columns), *([row[name] or "–" for name in columns] for row in rows)]
    return "\n".join(f"| {' | '.join(line)} |" for line in cells).replace("_", "\\_").replace("E* ", "E\\* ")


def filled(name: str, results: Path = RESULTS) -> str:
    """Return a template filled from the tables, which it knows by benchmark and name."""
    environment = jinja2.Environment(
        loader=jinja2.FileSystemLoader(HERE / "templates"),
        undefined=jinja2.StrictUndefined,
        trim_blocks=True,
        keep_trailing_newline=True,
    )
    environment.filters |= {"where": where, "only": only, "table": table, "largest": largest}
    tables = {path.name: read(path) for path in results.iterdir() if path.is_dir()}
    return environment.get_template(name).render(tables | {"validation": validation()})


def validation() -> list[dict]:
    """Return the lines of the validation."""
    return list(csv.DictReader(VALIDATION.read_text("utf-8").splitlines()))


def largest(rows: list[dict], beginning: str = "") -> str:
    """Return the largest deviation of the lines whose names begin so, in two digits."""
    chosen = [float(row["deviation"]) for row in rows if row["what"].startswith(beginning)]
    return f"{max(chosen):.1e}"


def with_block(page: str, name: str, text: str) -> str:
    """Return a page with a text between the comments `<!-- NAME: ... -->` and `<!-- end of NAME -->`."""
    marks = re.compile(rf"(<!-- {name}: [^\n]*-->\n).*?(<!-- end of {name} -->)", re.DOTALL)
    if not marks.search(page):
        raise ValueError(f"the page has no lines <!-- {name}: ... --> and <!-- end of {name} -->")
    return marks.sub(lambda match: match[1] + text + match[2], page)


def rendered(results: Path = RESULTS) -> dict[Path, str]:
    """Return the text of every page that has numbers of the benchmarks."""
    pages = {path: filled(name, results) for name, path in PAGES.items()}
    for name, path in BLOCKS.items():
        pages[path] = with_block(
            pages.get(path) or path.read_text("utf-8"), name, filled(f"{name}.md", results)
        )
    return pages


def text(frame: pd.DataFrame, formats: dict[str, str] | None = None) -> pd.DataFrame:
    """Return a table with its numbers as text, three digits where `formats` has no format for the column."""

    def shown(value, form: str | None) -> str:
        if isinstance(value, str) or pd.isna(value):
            return value if isinstance(value, str) else ""
        if form is None:
            return str(value) if isinstance(value, int) else format(float(format(value, ".3g")), ".15g")
        return format(value, form)

    forms = formats or {}
    return pd.DataFrame({name: [shown(value, forms.get(name)) for value in frame[name]] for name in frame})


def show(tables: dict[str, pd.DataFrame]) -> None:
    """Print tables."""
    for name, frame in tables.items():
        print(f"{name}\n{frame.to_string(index=False)}\n")


def publish(benchmark: str, tables: dict[str, pd.DataFrame], about: dict | None = None) -> None:
    """Write the tables of a benchmark, and the pages that show them."""
    folder = RESULTS / benchmark
    folder.mkdir(parents=True, exist_ok=True)
    for name, frame in tables.items():
        frame.to_csv(folder / f"{name}.csv", index=False, lineterminator="\n")
    if about:
        facts = json.dumps(about, indent=1, ensure_ascii=False)
        (folder / "about.json").write_text(f"{facts}\n", encoding="utf-8")
    main()


def main() -> None:
    """Write all pages and the figure of the speed."""
    for path, page in rendered().items():
        path.write_text(page, encoding="utf-8")
    draw(read(RESULTS / "speed")["race"], PAGES["performance.md"].with_suffix(".png"))


def draw(race: list[dict], path: Path) -> None:
    """Draw the time of one load by points per side, on one thread."""
    import matplotlib

    matplotlib.use("Agg")
    import matplotlib.pyplot as plt

    frame = pd.DataFrame(where(race, threads="1")).set_index("map").replace("", "nan").astype(float)
    synthetic = frame.index == "synthetic"
    fig, ax = plt.subplots(figsize=(6, 4.2), layout="constrained")
    for code, colour in {"roughcontact": "#0b6e8f", "ASPHER": "#c8553d", "Tamaas": "#7a7a7a"}.items():
        sides, times = frame["points per side"], frame[f"{code} (ms)"]
        ax.plot(sides[~synthetic], times[~synthetic], ".", color=colour, alpha=0.7)
        ranges = times[synthetic].groupby(sides[synthetic]).agg(["min", "median", "max"])
        ax.fill_between(ranges.index, ranges["min"], ranges["max"], color=colour, alpha=0.2, linewidth=0)
        ax.plot(ranges["median"], color=colour, label=code)
    ax.set(xscale="log", yscale="log", xlabel="points per side", ylabel="time of one load (ms)")
    ax.set_xticks(ranges.index, [f"{side:g}" for side in ranges.index])
    ax.minorticks_off()
    ax.set_title("line and band: synthetic maps, median and range of loads; dots: measured maps", fontsize=9)
    ax.legend(frameon=False)
    fig.savefig(path, dpi=110)
    plt.close(fig)


if __name__ == "__main__":
    main()
