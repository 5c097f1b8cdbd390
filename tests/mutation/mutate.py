#!/usr/bin/env python3
"""Mutation testing: change one operator or number of a module at a time and see whether a test notices.

`python tests/mutation/mutate.py` takes a random sample of each part of parts.toml, `mutate.py units filling`
of those parts only; README.md beside this file says more. Needs `pip install --group mutation`
besides the environment of the tests.
"""

import argparse
import ast
import hashlib
import os
import random
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
import time
import tomllib
from functools import cache
from pathlib import Path

HERE = Path(__file__).resolve().parent
ROOT = HERE.parents[1]
PACKAGE = Path("workflow/lib/roughcontact")
SESSIONS = ROOT / "build" / "mutation"
COPIED = ("workflow", "tests", "benchmarks", "validation", "config", "data_samples", "docs")

# What stands for each operator. Every other replacement is left out: most of them are nonsense that any test
# kills (height << pitch), so that they would only polish the share.
KINDS = {
    *("Add_Sub", "Sub_Add", "Mul_Div", "Div_Mul", "FloorDiv_Mul", "Mod_Mul", "Pow_Mul"),
    *("BitAnd_BitOr", "BitOr_BitAnd"),
    *("Eq_NotEq", "NotEq_Eq", "Lt_LtE", "Lt_GtE", "LtE_Lt", "LtE_Gt", "Gt_GtE", "Gt_LtE", "GtE_Gt", "GtE_Lt"),
    *("Is_IsNot", "IsNot_Is", "Delete_USub", "Delete_Invert", "Delete_Not"),
}
WHOLE = {
    *("NumberReplacer", "AddNot", "ReplaceAndWithOr", "ReplaceOrWithAnd", "ReplaceTrueWithFalse"),
    *("ReplaceFalseWithTrue", "ReplaceBreakWithContinue", "ReplaceContinueWithBreak", "ZeroIterationForLoop"),
    *("ExceptionReplacer", "RemoveDecorator"),
}


def main():
    parts = tomllib.loads((HERE / "parts.toml").read_text(encoding="utf-8"))
    parser = argparse.ArgumentParser(description=__doc__.split("\n")[0])
    parser.add_argument("parts", nargs="*", metavar="PART", help=f"of {', '.join(parts)}; all without it")
    parser.add_argument(
        "--sample", default="40", help="mutants of each part, a number or `all` (%(default)s)"
    )
    parser.add_argument("--seed", type=int, default=1, help="of the sample (%(default)s)")
    parser.add_argument("--again", action="store_true", help="only what survived, or did not run, last time")
    parser.add_argument("--show", action="store_true", help="run nothing, show what the last run found")
    options = parser.parse_args()
    if unknown := set(options.parts) - set(parts):
        parser.error(f"unknown: {', '.join(sorted(unknown))}; parts are {', '.join(parts)}")
    SESSIONS.mkdir(parents=True, exist_ok=True)
    for name in options.parts or parts:
        if not options.show:
            run(name, parts[name], options)
    return max([report(name) for name in options.parts or parts])


def run(name, part, options):
    """Run the mutants of one part in a copy of the project; the session is kept below build/mutation."""
    session = SESSIONS / f"{name}.sqlite"
    with tempfile.TemporaryDirectory(prefix="mutation.") as folder:
        copy = Path(folder)
        for path in COPIED:
            shutil.copytree(ROOT / path, copy / path)
        shutil.copy2(ROOT / "pyproject.toml", copy)
        modules = [str(PACKAGE / module) for module in part["modules"]]
        command = [sys.executable, "-m", "pytest", "-x", "-q", "-p", "no:cacheprovider"]
        command += ["-m", "not slow and not browser and not shared_data", *part["tests"], *modules]
        command += [word for test in part.get("without", ()) for word in ("--deselect", test)]
        environment = os.environ | {"PYTHONPATH": str(copy / PACKAGE.parent)}
        # twice: the first run compiles what the second one finds
        for _ in range(2):
            start = time.monotonic()
            subprocess.run(command, cwd=copy, env=environment, check=True, stdout=subprocess.DEVNULL)
            seconds = time.monotonic() - start
        settings = [
            "[cosmic-ray]",
            f"module-path = {modules}",
            f"timeout = {5 * seconds + 30:.0f}",  # for a machine that does other things as well
            "excluded-modules = []",
            f"test-command = '''{shlex.join(command)}'''",
            'distributor.name = "local"',
        ]
        (copy / "mutation.toml").write_text("\n".join(settings), encoding="utf-8")
        call = [str(Path(sys.executable).with_name("cosmic-ray"))]
        digest = hashlib.sha256(b"".join((copy / module).read_bytes() for module in modules)).hexdigest()
        checksum_file = session.with_suffix(".sha256")
        if options.again:
            if checksum_file.read_text() != digest:
                sys.exit(f"{name}: its modules have changed since the last run; start anew, without --again")
            forget_survivors(session)
        else:
            session.unlink(missing_ok=True)
            checksum_file.write_text(digest)
            subprocess.run([*call, "init", "mutation.toml", session], cwd=copy, check=True)
            keep_sample(session, copy, f"{name} {options.seed}", options.sample)
        print(f"{name}: the tests take {seconds:.0f} s", flush=True)
        subprocess.run([*call, "exec", "mutation.toml", session], cwd=copy, env=environment, check=True)
        # an environment that broke on the way has killed whatever came after
        if subprocess.run(command, cwd=copy, env=environment, check=False, capture_output=True).returncode:
            session.unlink()
            sys.exit(f"{name}: the tests fail without a change as well by now: start anew")


def keep_sample(session, copy, seed, size):
    """Leave a random sample of the sensible mutants in a session."""
    from cosmic_ray.work_db import use_db

    with use_db(session) as db:
        items = sorted(db.work_items, key=lambda item: place(item.mutations[0]))
        paths = {item.mutations[0].module_path for item in items}
        sources = {path: (copy / path).read_text(encoding="utf-8") for path in paths}
        items = [item for item in items if is_sensible(item.mutations[0], sources)]
        if size != "all":
            items = random.Random(seed).sample(items, min(int(size), len(items)))
        db.clear()
        db.add_work_items(items)


def is_sensible(mutation, sources):
    """Return whether a mutant computes something else, and not nonsense."""
    kind = mutation.operator_name.removeprefix("core/")
    if kind not in WHOLE and re.sub(r"^Replace\w+Operator_", "", kind) not in KINDS:
        return False
    source, (row, column) = sources[mutation.module_path], mutation.start_pos
    text = source.splitlines()[row - 1]
    # no product, what follows has to be named; a guard against mistakes in the code itself
    if text.startswith("*,", column) or text[:column].endswith("strict="):
        return False
    return not any(start <= (row, column) < stop for start, stop in annotations(source))


def is_killed(result):
    """Return whether a test has failed; cosmic-ray also counts a run that was interrupted."""
    return result.test_outcome == "killed"


def is_completed(result):
    """Return whether the tests have run to a verdict on a mutant."""
    return is_killed(result) or result.test_outcome == "survived"


def forget_survivors(session):
    """Take back the results of the mutants that no test has noticed, or that were interrupted."""
    from cosmic_ray.work_db import use_db

    with use_db(session) as db:
        items, killed = db.work_items, [(job, result) for job, result in db.results if is_killed(result)]
        db.clear()
        db.add_work_items(items)
        for job, result in killed:
            db.set_result(job, result)


def place(mutation):
    """Return what a mutant is known by."""
    return str(mutation.module_path), mutation.start_pos, mutation.operator_name, mutation.occurrence


@cache
def annotations(source):
    """Return from where to where the annotations of a module go: `float | None` computes nothing."""
    spans = []
    for node in ast.walk(ast.parse(source)):
        parts = (getattr(node, kind, None) for kind in ("annotation", "returns"))
        spans += [
            ((part.lineno, part.col_offset), (part.end_lineno, part.end_col_offset)) for part in parts if part
        ]
    return spans


def report(name):
    """Print what became of the mutants of a part; return 1 where one survived unjudged, or did not run."""
    from cosmic_ray.work_db import use_db

    judged = tomllib.loads((HERE / "judged.toml").read_text(encoding="utf-8"))
    judged_mutants = {(entry["module"], entry["line"], entry.get("mutant")) for entry in judged.get(name, ())}
    killed, timeouts, equivalent, survivors = 0, 0, 0, []
    with use_db(SESSIONS / f"{name}.sqlite") as db:
        waiting = len(db.pending_work_items)
        for item, result in sorted(db.completed_work_items, key=lambda pair: place(pair[0].mutations[0])):
            mutation = item.mutations[0]
            if not is_completed(result):
                waiting += 1
                continue
            if is_killed(result):
                killed += 1
                timeouts += result.output == "timeout"
                continue
            module = mutation.module_path.relative_to(PACKAGE).as_posix()
            line, mutant = (
                " ".join(
                    text[1:].strip()
                    for text in result.diff.splitlines()
                    if re.match(rf"\{sign}(?!\{sign})", text)
                )
                for sign in "-+"
            )
            if {(module, line, mutant), (module, line, None)} & judged_mutants:
                equivalent += 1
            else:
                survivors.append((module, mutation.start_pos[0], line, mutant))
    counted = killed + len(survivors)
    share = 100 * killed / max(counted, 1)
    text = f"{name}: {share:.0f} % of {counted} mutants killed, {timeouts} of them by the clock"
    text += f"; {len(survivors)} survived, {equivalent} others judged to change nothing"
    print(text + (f"; {waiting} did not run" if waiting else ""))
    for module, number, line, mutant in survivors:
        print(f"  {module}:{number}\n    - {line}\n    + {mutant}")
    return int(bool(survivors or waiting))


if __name__ == "__main__":
    sys.exit(main())
