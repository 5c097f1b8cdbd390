"""The program `roughcontact`: its commands and exit codes.

Exit codes: 0 done, 1 a load missed the tolerance or two runs differ, 2 bad input (one sentence on standard
error), 130 interrupted, 143 terminated, 141 the reader of the output has closed it.
"""

import argparse
import errno
import os
import re
import shlex
import signal
import sys
import warnings
from collections.abc import Callable, Iterator, Mapping
from contextlib import contextmanager
from difflib import get_close_matches
from pathlib import Path
from typing import TYPE_CHECKING, Any, NoReturn

import roughcontact
from roughcontact.arguments.rows import rows_beside
from roughcontact.errors import (
    ConvergenceError,
    HeightMapWarning,
    InputFileError,
    RoughContactError,
    SettingsError,
    turns_escaped,
)
from roughcontact.interface.command_line.words import with_units
from roughcontact.study.garbage import collect_rarely

if TYPE_CHECKING:
    import xarray as xr

_BROKEN_PIPE = 141  # exit status that a shell reports for a program ended by SIGPIPE
_DESCRIPTION = (
    "True contact area and contact pressures of measured surfaces: of one map, or of a whole study."
)

# command -> what a person types, at the end of its help, and what it does
_COMMANDS = {name: words for name, *words in rows_beside(__file__, "commands.tsv")}
_ARGUMENTS = rows_beside(__file__, "arguments.tsv")
_Run = Callable[[argparse.Namespace], int]
_Extension = Callable[[argparse.ArgumentParser], None]
_TYPES: dict[str, Callable[[str], Any]] = {"path": Path, "integer": int, "number": float}

# options of `init` for other settings
_INITIAL = ("contact.mean_pressure", "contact.force", "contact.area", "form.radius", "level.form")
_GROUP = (
    "name of a finish or a workpiece, and its maps, whose numbers then stand together; again for the next, "
    "with which it is compared. Without files: of all maps"
)

_RESULT = "a result: its folder, results/SURFACE, or its file of numbers, statistics.nc or that of solve"

_RUN = """Run the workflow in the working directory, on all cores. Options are passed to Snakemake: -n lists
the jobs without running them, --cores 1 uses a single core, --configfile FILE takes other settings than
config/config.yaml, --directory FOLDER works there."""


class _Escaping:
    """A stream that shows the marks that turn the direction of a text, as of a file's name, as escapes."""

    def __init__(self, stream: Any) -> None:
        self._stream = stream

    def __getattr__(self, name: str) -> Any:
        return getattr(self._stream, name)

    def write(self, text: str) -> int:
        """Write a text."""
        return int(self._stream.write(turns_escaped(text)))


def _is_of_study(stray: str) -> bool:
    """Return whether an argument is named as what the table or the settings of a study have."""
    from roughcontact.arguments.settings.fields import fields_at
    from roughcontact.study.table.columns import COLUMNS

    name = stray.removeprefix("--").replace("-", "_")
    return name in (*COLUMNS, *fields_at(["contact"])) or name.partition("_")[0] in fields_at([])


class _Parser(argparse.ArgumentParser):
    """A parser that reports errors in single sentences."""

    def parse_known_args(self, args: Any = None, namespace: Any = None) -> Any:
        """Parse, and refuse what is no option, with the nearest one."""
        namespace, strays = super().parse_known_args(args, namespace)
        if strays:
            stray, options = strays[0].partition("=")[0], re.findall(r"--[\w-]+", self.format_usage())
            close = get_close_matches(stray, options, n=1, cutoff=0.7)
            hint = f"; the nearest option is {close[0]}" if close else ""
            if _is_of_study(stray):
                hint = "; it is of a study, a column of its table or a key of its settings: roughcontact init"
            if stray[:1].isalpha():
                hint = "; write a number and its unit as one word: 5GPa"
            self.error(f"unrecognized arguments: {' '.join(strays)}{hint}")
        return namespace, strays

    def error(self, message: str) -> NoReturn:
        """Exit with one sentence instead of the whole usage."""
        self.exit(2, f"{self.prog}: {message}; see {self.prog} --help\n")


def main(arguments: list[str] | None = None) -> int:
    """Run the program and return its exit code, one of those at the head of this module."""
    if arguments is None:  # the process is this program's own
        collect_rarely()
        sys.stdout, sys.stderr = map(_Escaping, (sys.stdout, sys.stderr))
        arguments = sys.argv[1:]
    try:
        if arguments[:1] == ["run"] and not {"-h", "--help"} & set(arguments):
            options = argparse.Namespace(run=_run, arguments=arguments[1:])  # all for Snakemake
        else:
            arguments = [*arguments[:1], *with_units(arguments[1:])]
            options = _parser(verb="".join(arguments[:1])).parse_args(arguments)
        code = options.run(options)
        sys.stdout.flush()
        return code
    except ConvergenceError as error:
        return _failed(error, 1)
    except RoughContactError as error:
        return _failed(error, 2)
    except BrokenPipeError:  # the reader has closed the output, as `head` does
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())  # for the final flush
        return _BROKEN_PIPE
    except OSError as error:
        if error.errno != errno.ENAMETOOLONG:
            raise
        return _failed(f"{str(error.filename)[:60]}...: longer than the path of any file; check the path", 2)
    except KeyboardInterrupt:
        return _failed("interrupted", 130)


def _failed(error: RoughContactError | str, code: int) -> int:
    """Print an error on standard error, and return the exit code."""
    print(f"roughcontact: {error}", file=sys.stderr)
    return code


def _parser(*, verb: str) -> argparse.ArgumentParser:
    """Return the parser; only `verb` has options that come from the settings, whose import takes a moment."""
    from roughcontact.interface.command_line.saving import CONTENT_BY_ENDING, EXPORTED_BY_ENDING, EXPORTS

    parser = _Parser(prog="roughcontact", description=_DESCRIPTION)
    parser.add_argument("--version", action="version", version=f"roughcontact {roughcontact.__version__}")
    verbs = parser.add_subparsers(required=True, metavar=" | ".join(_COMMANDS))
    words = {
        "result": _RESULT,
        "content": _endings(CONTENT_BY_ENDING),
        "exported": _endings(EXPORTED_BY_ENDING),
        "json": "print for machines: SI units, names as in the files",
    }
    for name, (example, text) in _COMMANDS.items():
        run, add_further = _VERBS[name]
        holds, _ = EXPORTS.get(name, ("", ""))
        subparser = verbs.add_parser(name, help=text.format(holds), epilog=f"Example: {example}")
        subparser.set_defaults(run=run)
        for command, names, metavar, kind, count, meaning in _ARGUMENTS:
            if command == name:
                form: dict[str, Any] = {"metavar": metavar, "type": _TYPES.get(kind)}
                form |= {"required": True} if count == "required" else {"nargs": count or None}
                form = {"action": "store_true"} if kind == "flag" else form
                subparser.add_argument(*names.split(), help=meaning.format_map(words), **form)
        if name == verb and add_further:
            add_further(subparser)
    return parser


def _endings(content: Mapping[str, str]) -> str:
    """Return what files with each ending hold, in a sentence."""
    return (
        f"its ending says what it holds. {'; '.join(f'{ending}: {text}' for ending, text in content.items())}"
    )


def _add_initial_settings(parser: argparse.ArgumentParser) -> None:
    """Add the options of `init` for materials, loads, form, columns of the table and what is derived."""
    from roughcontact.interface.command_line.options import COURSES, add_body, add_derived, add_setting
    from roughcontact.study.table.columns import OF_ALL_FILES, column_meaning

    add_body(parser)
    for name in _INITIAL:
        add_setting(parser, name)
    text = "solve also the removal of the heaviest load: the shape that is left"
    parser.add_argument("--unload", dest="contact.unload", action="store_const", const=True, help=text)
    metavar = ("NAME", "FILE")
    parser.add_argument("--group", nargs="+", action="append", default=[], metavar=metavar, help=_GROUP)
    for column in OF_ALL_FILES:
        option = f"--{column.replace('_', '-')}"
        parser.add_argument(option, metavar="TEXT", help=column_meaning(column))
    add_derived(parser, COURSES)


def _add_file_options(parser: argparse.ArgumentParser) -> None:
    """Add options for information that is missing in a file."""
    from roughcontact.io.request import FILE_OPTIONS

    group = parser.add_argument_group("information missing in the file")
    for name, text in FILE_OPTIONS.items():
        metavar = "LENGTH" if name in ("dx", "dy") else "TEXT"
        group.add_argument(f"--{name}", help=text, metavar=metavar)


def _add_settings(parser: argparse.ArgumentParser) -> None:
    """Add the options of `solve`: for the file, and for each setting."""
    from roughcontact.interface.command_line.options import add_settings

    _add_file_options(parser)
    add_settings(parser)


def _add_usage(parser: argparse.ArgumentParser) -> None:
    """Say of `run` that all its options are those of Snakemake."""
    parser.usage, parser.description = "roughcontact run [OPTION ...]", _RUN


def _read_arguments(options: argparse.Namespace) -> dict[str, Any]:
    """Return the keyword arguments of `read_height_map` that were given."""
    from roughcontact.io.request import FILE_OPTIONS

    names = (name.replace("-", "_") for name in FILE_OPTIONS)
    return {name_: value for name_ in names if (value := getattr(options, name_)) is not None}


def _inspect(options: argparse.Namespace) -> int:
    """Print the contents of each file, of those in a folder a line; what cannot be read is reported."""
    from roughcontact.interface.command_line.describe import as_json, inspection, overview
    from roughcontact.interface.command_line.folders import contents_of, list_measurements

    contents_of_files: list[dict[str, Any]] = []
    code, arguments = 0, _read_arguments(options)
    for file in options.files:
        if os.path.isdir(file):  # noqa: PTH112 - false also of a path that is too long
            folder_contents = [contents_of(path, **arguments) for path in list_measurements(Path(file))[0]]
            contents_of_files += folder_contents
            if not options.json:
                print(overview(folder_contents, file))
            continue
        contents = contents_of(file, **arguments)
        if contents["format"] is None:
            code = _failed(contents["problem"], 2)
            continue
        contents_of_files.append(contents)
        if not options.json:
            print(inspection(contents, file), end="\n\n" if len(options.files) > 1 else "\n")
    if options.json:
        print(as_json(contents_of_files))
    return code


def _solve(options: argparse.Namespace) -> int:
    """Print the contact of one map, or of several together."""
    from roughcontact.interface.command_line import saving
    from roughcontact.interface.command_line.answers import group, solution
    from roughcontact.interface.command_line.describe import as_json
    from roughcontact.interface.command_line.options import chosen_settings, message_with_options
    from roughcontact.interface.command_line.solving import solve_file, solve_files

    try:
        settings = chosen_settings(options)
        arguments, threads = (_read_arguments(options), settings), options.threads
        numbers: Any  # none of maps that are no group
        together, output = len(options.files) > 1, options.output
        if together and options.overview:
            raise SettingsError(
                f"--overview {options.overview[0]}: is of one map; give one file, or a table with this column"
            )
        if output:
            saving.check_output(output, options.files)
        with _warnings_in_words():
            if together:
                result, numbers = solve_files(options.files, *arguments, threads=threads)
            else:
                result, numbers = solve_file(
                    options.files[0],
                    *arguments,
                    threads=threads,
                    output=output,
                    overviews=options.overview or (),
                    overview_position=options.overview_position or "",
                )
    except SettingsError as error:
        raise SettingsError(message_with_options(error)) from error
    if options.json:
        print(as_json(result))
    else:
        print((group if together else solution)(result, numbers))
    maps = result["maps"] if together else [result]
    return 0 if all(load["converged"] for solved_map in maps for load in solved_map["loads"]) else 1


@contextmanager
def _warnings_in_words() -> Iterator[None]:
    """Print each warning once on standard error, as errors are, without the place in the source."""
    with warnings.catch_warnings():
        warnings.simplefilter("once", HeightMapWarning)
        warnings.showwarning = lambda message, *_: print(f"roughcontact: warning: {message}", file=sys.stderr)
        yield


def _init(options: argparse.Namespace) -> int:
    """Write settings and table, and print the next steps."""
    from roughcontact.interface.command_line.options import initial_settings, message_with_options
    from roughcontact.interface.command_line.project import collect_files, problems, write_project
    from roughcontact.study.table.columns import OF_ALL_FILES, PAIR

    files, omissions = collect_files(options.files)
    groups: dict[str, str] = {}  # file -> name
    for name, *paths in options.group:
        of_group, others_in_folder = collect_files(paths) if paths else (files, [])
        if duplicates := sorted(groups.keys() & {*of_group}):
            raise SettingsError(f"--group {name}: {duplicates[0]} is in {groups[duplicates[0]]} already")
        groups |= dict.fromkeys(of_group, name)
        omissions += others_in_folder
    columns = {name: value for name in OF_ALL_FILES if (value := getattr(options, name))}
    if options.before and PAIR in columns:
        raise SettingsError("--before, --counter-face: only single maps are compared; leave one of them out")
    earlier_files, _ = collect_files([options.before] if options.before else [])
    files = list(dict.fromkeys([*earlier_files, *files, *groups]))
    sections = initial_settings(options)
    try:
        config, table = write_project(
            files, sections=sections, columns=columns, groups=groups, earlier_file="".join(earlier_files)
        )
    except SettingsError as error:
        raise SettingsError(message_with_options(error)) from error
    if not options.body:
        print(f"{config}: state your materials and loads under `contact` (or here, with --body twice)")
    print(f"{table}: {len(files) or 'no'} surface{'s' * (len(files) != 1)}, a row each")
    if omissions:
        print(f"left out, as no measurements: {', '.join(omissions)}")
    for path, problem in problems(files):
        print(f"to be given in {table}: {path}: {problem}")
    print("then: roughcontact run")
    return 0


def _run(options: argparse.Namespace) -> int:
    """Run the workflow."""
    from roughcontact.study.running import run_workflow

    return run_workflow(options.arguments)


def _app(options: argparse.Namespace) -> int:
    """Serve the page of a study until it is interrupted."""
    from importlib.metadata import requires
    from importlib.util import find_spec

    if missing := [name for name in ("snakemake", "starlette", "uvicorn") if find_spec(name) is None]:
        extras = ("extra == 'workflow'", "extra == 'app'")
        lines = [line.replace('"', "'").partition("; ") for line in requires("roughcontact") or ()]
        further = shlex.join(name for name, _, extra in lines if extra in extras)
        raise SettingsError(f"{missing[0]} is not installed: pip install {further}")
    # there is nothing to end before it serves; an exception amid imports may be printed, and be lost
    signal.signal(signal.SIGINT, lambda *_: os._exit(_failed("interrupted", 130)))
    from roughcontact.interface.app.server import serve

    folder = options.folder or Path()
    try:
        return serve(folder, port=options.port or 0, browser=not options.no_browser)
    except (OSError, OverflowError) as error:
        raise SettingsError(
            f"{folder}: its page cannot be served ({error}); name a folder that you may write in, "
            "and a free --port"
        ) from error


def _compare(options: argparse.Namespace) -> int:
    """Print which numbers of two runs differ; return 1 where any does."""
    from roughcontact.interface.command_line.describe import as_json, comparison
    from roughcontact.results.comparison import compare_statistics

    if options.share is not None and not 0 <= options.share < 1:
        raise SettingsError(f"--share {options.share:g}: a share is between 0 and 1; 0.01 is 1 %")
    files = _read_run_statistics(options.before), _read_run_statistics(options.after)
    table = compare_statistics(*files, share=options.share)
    rows: list[dict[str, Any]] = [dict(row) for _, row in table.iterrows()]
    print(as_json(rows) if options.json else comparison(rows, share=options.share))
    return int(any(row["differs"] for row in rows))


def _methods(options: argparse.Namespace) -> int:
    """Print the paragraph of methods of each result."""
    from roughcontact.report.methods import methods_paragraph

    files: list[Path] = []
    for path in map(Path, options.files or ["results"]):
        files += sorted(path.glob("**/*/statistics.nc")) or [_file_of_result(path)]
    for path in files:
        statistics = _read_run_statistics(str(path), single=True)
        print(*([f"# {path.parent.name}"] if len(files) > 1 else []), methods_paragraph(statistics), sep="\n")
    return 0


def _table(options: argparse.Namespace) -> int:
    """Print or write the table of a result over the mean gap."""
    from roughcontact.evaluation.evaluate import tabulate_by_gap
    from roughcontact.interface.command_line import saving
    from roughcontact.results.collect import column_name
    from roughcontact.results.exchange import write_contact_law
    from roughcontact.results.storage import table_text, write_dataset, write_table

    if options.output is not None:
        saving.check_ending(options.output, (".csv", ".nc", ".inp"))
    try:
        table = tabulate_by_gap(_read_run_statistics(options.file, single=True))
    except SettingsError as error:
        raise InputFileError(f"{options.file}: {error}") from error
    writers = {".nc": write_dataset, ".inp": write_contact_law}
    if options.output is not None and (write := writers.get(options.output.suffix.lower())):
        write(table, options.output)
        return 0
    headings = {str(name): column_name(str(name), table[name].attrs["units"]) for name in table.variables}
    frame = table.to_dataframe().reset_index().rename(columns=headings)
    frame["rms_height_m"] = table.attrs["rms_height"]  # of the shear flow
    if options.output is None:
        print(table_text(frame), end="")
    else:
        write_table(frame, options.output)
    return 0


def _file_of_result(path: str | Path) -> Path:
    """Return the file of numbers of a result that is named by its folder, or by that file."""
    inside = Path(path) / "statistics.nc"
    return inside if inside.is_file() else Path(path)


def _read_run_statistics(path: str, *, single: bool = False) -> "xr.Dataset":
    """Return the statistics of a run, or of a `single` surface; raise an error for any other file."""
    from roughcontact.results.storage import read_dataset

    of_which = "in the folder of one surface" if single else "of a run, of all surfaces or of one"
    advice = f"name the statistics.nc {of_which}"
    path = str(_file_of_result(path))
    if not Path(path).is_file():
        reason = "is a folder" if Path(path).is_dir() else "no such file"
        raise InputFileError(f"{path}: {reason}; {advice}")
    try:
        statistics = read_dataset(path)
    except InputFileError as error:
        raise InputFileError(f"{path}: is damaged, or no file of a run; {advice}") from error
    if "mean_pressure" not in statistics or {"y", "group"} & set(statistics.dims):
        raise InputFileError(f"{path}: holds no statistics of contacts; {advice}")
    if single and "surface" in statistics.dims:
        raise InputFileError(f"{path}: is of all surfaces; {advice}")
    return statistics


def _export(options: argparse.Namespace) -> int:
    """Write a result of a finished run as another kind of file."""
    from roughcontact.interface.command_line import saving

    saving.check_ending(options.output, saving.EXPORTED_BY_ENDING)
    is_numbers = options.folder.name == "statistics.nc"
    file = options.folder if is_numbers else options.folder / "statistics.nc"
    _read_run_statistics(str(file), single=True)
    saving.write(options.output, file.parent, surface=file.parent.name, title=file.parent.name)
    return 0


def _crate(options: argparse.Namespace) -> int:
    """Write the description of a run, and print its path."""
    from roughcontact.study.crate import write_crate

    names = {"configuration": "configfile", "terms": "license", "author": "author", "publisher": "publisher"}
    entries = {name: text for name, option in names.items() if (text := getattr(options, option))}
    print(write_crate(options.folder, **entries))
    return 0


# command -> what carries it out, and what adds options that are not in `arguments.tsv`
_VERBS: dict[str, tuple[_Run, _Extension | None]] = {
    "inspect": (_inspect, _add_file_options),
    "solve": (_solve, _add_settings),
    "init": (_init, _add_initial_settings),
    "run": (_run, _add_usage),
    "app": (_app, None),
    "methods": (_methods, None),
    "table": (_table, None),
    "compare": (_compare, None),
    "export": (_export, None),
    "crate": (_crate, None),
}
