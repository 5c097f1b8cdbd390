"""Build the library of compiled passes (roughcontact/kernels/c) and put the workflow into wheels.

pyproject.toml has all else.

The library is plain C and knows nothing of Python: one wheel of a platform serves every version. It is built
by the compiler of the system where there is one that works, else by that of the package ziglang, which pip
then fetches for the build. ROUGHCONTACT_PLATFORM=win_amd64, say, builds the wheel of another platform (one of
`TARGETS`) with ziglang. Where nothing can build the library, the package is installed without: it works, but
slowly.
"""

import os
import shlex
import shutil
import subprocess
import sys
import tempfile
from functools import cache
from importlib.util import find_spec
from pathlib import Path

from setuptools import Extension, setup
from setuptools.command.bdist_wheel import bdist_wheel
from setuptools.command.build_ext import build_ext
from setuptools.command.build_py import build_py
from setuptools.command.sdist import sdist
from setuptools.errors import CompileError, SetupError

SOURCES = Path("workflow/lib/roughcontact/kernels/c")
# what a wheel needs to run the workflow, and two of the samples; in a checkout they lie where they are
WORKFLOW = ["workflow/Snakefile", "data_samples/sandblasted.x3p", "data_samples/stylus-profile.csv"]
WORKFLOW += [f"workflow/{folder}/*" for folder in ("envs", "profiles/*", "report", "rules", "scripts")]
# where the commit is noted in a wheel, and in a source distribution below MODULES
COMMIT = "roughcontact/_commit.txt"
MODULES = "workflow/lib"
# Sums named in the source may be reordered; all else is computed as written, infinities and NaN included.
FLAGS = [
    *("-std=c11", "-O3", "-shared", "-fPIC", "-fvisibility=hidden", "-pthread"),
    *("-fopenmp-simd", "-fno-math-errno", "-fno-trapping-math", "-ffp-contract=fast"),
    *("-fno-unwind-tables", "-fno-asynchronous-unwind-tables"),  # nothing in C is thrown through it
    *(["-s"] if sys.platform != "darwin" else []),
]
# by the tag of the wheel
TARGETS = {
    "manylinux_2_17_x86_64": "x86_64-linux-gnu.2.17",
    "manylinux_2_17_aarch64": "aarch64-linux-gnu.2.17",
    "musllinux_1_2_x86_64": "x86_64-linux-musl",
    "musllinux_1_2_aarch64": "aarch64-linux-musl",
    "macosx_11_0_x86_64": "x86_64-macos.11.0",
    "macosx_11_0_arm64": "aarch64-macos.11.0",
    "win_amd64": "x86_64-windows-gnu",
    "win_arm64": "aarch64-windows-gnu",
}
PLATFORM = os.environ.get("ROUGHCONTACT_PLATFORM", "")


def compilers():
    """Yield the commands that may compile here, the preferred one first."""
    if not PLATFORM:
        names = [os.environ.get("CC", ""), "cc", "gcc", "clang"] if os.name != "nt" else []
        yield from (shlex.split(name) for name in names if name and shutil.which(shlex.split(name)[0]))
    if find_spec("ziglang"):
        target = ["-target", TARGETS[PLATFORM]] if PLATFORM else []
        yield [sys.executable, "-m", "ziglang", "cc", *target]


def compile_library(compiler, sources, library):
    """Compile the `library`, and leave nothing else; return what went wrong, if anything."""
    with tempfile.TemporaryDirectory() as folder:
        made = Path(folder) / Path(library).name
        command = [*compiler, *FLAGS, "-o", str(made), *map(str, sources), "-lm"]
        done = subprocess.run(command, capture_output=True, text=True, check=False)
        if done.returncode:
            return f"{shlex.join(command)}\n{done.stderr}"
        Path(library).parent.mkdir(parents=True, exist_ok=True)
        shutil.copyfile(made, library)
    return ""


@cache
def find_compiler():
    """Return the first command that compiles a part of the library; None if there is none."""
    with tempfile.TemporaryDirectory() as folder:
        sample = [SOURCES / "threads.c"]
        works = (c for c in compilers() if not compile_library(c, sample, Path(folder) / "sample"))
        return next(works, None)


class BuildLibrary(build_ext):
    """Build a plain shared library in place of a module."""

    def get_ext_filename(self, name):
        """Return the name of the library, which tells nothing of Python."""
        system = PLATFORM or sys.platform
        suffix = (
            ".dll" if system.startswith("win") else ".dylib" if system.startswith(("mac", "dar")) else ".so"
        )
        return str(Path(*name.split("."))) + suffix

    def build_extension(self, ext):
        """Compile the library by whatever compiler works here."""
        compiler = find_compiler()
        problem = (
            compile_library(compiler, ext.sources, self.get_ext_fullpath(ext.name))
            if compiler
            else "no C compiler was found: install one, or the package ziglang, and install again"
        )
        if problem:
            raise CompileError(problem)


@cache
def current_commit():
    """Return the commit that is built; nothing where it is not known."""
    noted = Path(MODULES, COMMIT)
    if noted.exists():
        return noted.read_text(encoding="ascii")
    command = ["git", "describe", "--always", "--dirty", "--abbrev=40", "--exclude=*"]
    try:
        done = subprocess.run(command, capture_output=True, text=True, check=False)
    except OSError:
        return ""
    return done.stdout.strip() if Path(".git").exists() else ""


class BuildWithWorkflow(build_py):
    """The modules, and among them the workflow and the commit, which goes into every result."""

    def run(self):
        """Copy the modules and, but for an editable installation, the workflow."""
        super().run()
        for source, copy in self.workflow_files().items():
            self.mkpath(str(copy.parent))
            self.copy_file(str(source), str(copy))
        if (commit := current_commit()) and not self.editable_mode:
            Path(self.build_lib, COMMIT).write_text(commit, encoding="ascii")

    def get_outputs(self, include_bytecode=1):
        """Return what this command writes."""
        copies = [str(copy) for copy in self.workflow_files().values()]
        noted = [str(Path(self.build_lib, COMMIT))] if current_commit() and not self.editable_mode else []
        return super().get_outputs(include_bytecode) + copies + noted

    def workflow_files(self):
        """Return where each file of the workflow is copied to."""
        if self.editable_mode:
            return {}
        target = Path(self.build_lib) / "roughcontact/_workflow"
        found = {
            pattern: [path for path in sorted(Path().glob(pattern)) if path.is_file()] for pattern in WORKFLOW
        }
        if missing := [pattern for pattern, files in found.items() if not files]:
            raise SetupError(f"nothing to put into the wheel: {', '.join(missing)}; take a whole checkout")
        return {path: target / path for files in found.values() for path in files}


class SourceWithCommit(sdist):
    """The sources, and the commit, which nothing else tells where there is no repository."""

    def make_release_tree(self, base_dir, files):
        """Copy the files and note the commit."""
        super().make_release_tree(base_dir, files)
        if commit := current_commit():
            Path(base_dir, MODULES, COMMIT).write_text(commit, encoding="ascii")


class PlatformWheel(bdist_wheel):
    """A wheel for one platform and every Python."""

    def get_tag(self):
        """Return the tag: any Python 3, no ABI of it, this platform."""
        return "py3", "none", PLATFORM or super().get_tag()[2]


setup(
    ext_modules=[
        Extension(
            "roughcontact.kernels.libkernels",
            sources=[str(SOURCES / name) for name in ("kernels.c", "threads.c")],
            depends=[str(path) for path in sorted(SOURCES.glob("*.h"))],
            optional=not PLATFORM,
        )
    ],
    cmdclass={
        "build_ext": BuildLibrary,
        "build_py": BuildWithWorkflow,
        "bdist_wheel": PlatformWheel,
        "sdist": SourceWithCommit,
    },
    setup_requires=[] if find_compiler() else ["ziglang>=0.13"],
)
