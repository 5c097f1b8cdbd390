# Where this workflow comes from: a checkout, an installed package, or a host from which another workflow imports it.
import sys
from pathlib import Path

from snakemake.exceptions import WorkflowError
from snakemake.sourcecache import LocalSourceFile

# The folder of this file, also where another workflow imports this one: workflow/rules of a checkout, or on a host.
# `current_basedir` here, and `configfiles` in common.smk, are the two attributes of `workflow` beside `source_path`
# and `basedir` that are used (Snakemake 9.22 to 9.27): nothing in its manual says the same.
HERE = workflow.current_basedir


def installed():
    """Fetch this workflow, and return the folder of the installed package that stands for its checkout.

    Snakemake fetches file by file, which a package cannot be: that which is installed must be of the same commit.
    """
    host = getattr(HERE, "host", None)
    source = f" @ git+https://{host}/{HERE.repo}@{HERE.ref}" if host else ""
    command = f"pip install 'roughcontact[workflow]{source}'"
    try:
        from roughcontact import __version__
        from roughcontact.command_line.running import workflow_file
    except ImportError:
        sys.exit(f"{HERE}: needs the package, which is not installed: {command}")
    folder = workflow_file().parent
    for path in sorted([*folder.glob("rules/*.smk"), *folder.glob("scripts/*.py")]):
        # a script finds the others that it imports where all of them were fetched to
        try:
            fetched = workflow.source_path(f"../{path.relative_to(folder).as_posix()}")
            text = Path(fetched).read_text("utf-8")
        except WorkflowError:
            text = ""
        if text.strip() != path.read_text("utf-8").strip():
            sys.exit(
                f"{HERE}: is another version than roughcontact {__version__}, which is installed "
                f"({path.name} differs): {command}"
            )
    return folder.parent


if isinstance(HERE, LocalSourceFile):
    ROOT = Path(HERE).parents[1]
    sys.path.insert(0, str(ROOT / "workflow/lib"))
else:
    ROOT = installed()
