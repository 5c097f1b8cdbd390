# Where this workflow comes from: a checkout, an installed package, or a host from which another workflow imports it.
import inspect
import sys
from pathlib import Path

from snakemake.exceptions import WorkflowError


def installed():
    """Fetch this workflow, and return the folder of the installed package that stands for its checkout.

    Snakemake fetches file by file, which a package cannot be: that which is installed must be of the same commit.
    """
    command = "pip install 'roughcontact[workflow]' of the same version"
    try:
        from roughcontact import __version__
        from roughcontact.study.running import workflow_file
    except ImportError:
        sys.exit(f"The workflow needs the package, which is not installed: {command}")
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
                f"The workflow is another version than roughcontact {__version__}, which is installed "
                f"({path.name} differs): {command}"
            )
    return folder.parent


# The file that this stands in: of a checkout, or an address on a host. `source_path` fetches single files alone.
ROOT = Path(inspect.getfile(installed)).parents[2]
if (ROOT / "workflow/lib/roughcontact").is_dir():
    sys.path.insert(0, str(ROOT / "workflow/lib"))
else:
    ROOT = installed()
