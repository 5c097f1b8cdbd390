"""Build and check what a release consists of: `python3 run.py wheels [PLATFORM ...]`, into build/wheels.

The source distribution is made of the checkout, and every wheel of the source distribution, so that both hold
all that is needed. `PLATFORM` is a tag among `TARGETS` of setup.py; without one, wheels of all are built. The
library in a wheel may need nothing but its system, in the version that the tag promises: `auditwheel` says so
of glibc, `system_needed` of the others.
"""

import os
import subprocess
import sys
from pathlib import Path
from zipfile import ZipFile

import lief

ROOT = Path(__file__).resolve().parents[1]
FOLDER = ROOT / "build/wheels"
LIBRARY = "roughcontact/kernels/libkernels."
LARGEST = 1_600_000  # bytes of a wheel
# what the library may need of its system, by the system in the tag of the wheel
ALLOWED = {
    "manylinux": ("libc.so.6", "libm.so.6", "libpthread.so.0", "ld-linux-"),
    "musllinux": ("libc.so",),
    "macosx": ("/usr/lib/libSystem.B.dylib",),
    "win": ("KERNEL32.dll", "api-ms-win-crt-", "ntdll.dll"),
}
PROCESSORS = {"x86_64": "X86_64", "amd64": "AMD64", "aarch64": "AARCH64", "arm64": "ARM64"}


def main(wanted):
    """Build into an empty folder, check, and print the size of each file; return 1 if a check fails."""
    targets = platforms()
    if unknown := set(wanted) - set(targets):
        sys.exit(f"{', '.join(sorted(unknown))}: no such platform; there are {', '.join(targets)}")
    FOLDER.mkdir(parents=True, exist_ok=True)
    for old in [*FOLDER.glob("*.whl"), *FOLDER.glob("*.tar.gz")]:
        old.unlink()
    epoch = subprocess.run(["git", "log", "-1", "--format=%ct"], cwd=ROOT, capture_output=True, check=False)
    dated = os.environ | ({"SOURCE_DATE_EPOCH": epoch.stdout.decode().strip()} if epoch.stdout else {})
    python("-m", "build", "--sdist", "--no-isolation", "--outdir", FOLDER, ROOT, env=dated, stdout=-3)
    (source,) = FOLDER.glob("*.tar.gz")
    pip = ["-m", "pip", "-qq", "--disable-pip-version-check", "--no-cache-dir", "wheel", "--no-deps"]
    for platform in wanted or targets:
        print(f"{platform} ...", flush=True)
        build = [*pip, "--no-build-isolation", "--wheel-dir", FOLDER, source]
        python(*build, env=dated | {"ROUGHCONTACT_PLATFORM": platform})
    wheels = sorted(FOLDER.glob("*.whl"))
    python("-m", "twine", "check", "--strict", source, *wheels)
    # W009: the package for the screen of a run has the name by which Snakemake finds it
    python("-m", "check_wheel_contents", "--ignore", "W009", *wheels)
    mistakes = [mistake for wheel in wheels for mistake in check(wheel)]
    for file in (source, *wheels):
        print(f"{file.stat().st_size / 1e6:.2f} MB  {file.name}")
    print("\n".join(mistakes) or f"{len(wheels)} wheels and the source distribution are as they should be")
    return int(bool(mistakes))


def platforms():
    """Return the tags of the wheels, which setup.py knows."""
    text = (ROOT / "setup.py").read_text(encoding="utf-8").partition("TARGETS = {")[2].partition("}")[0]
    return [line.split('"')[1] for line in text.splitlines() if '"' in line]


def python(*arguments, **options):
    """Run a module of this environment; end with its exit status if it fails."""
    done = subprocess.run([sys.executable, *map(str, arguments)], check=False, **options)
    if done.returncode:
        sys.exit(f"failed: python {' '.join(map(str, arguments))}")


def check(wheel):
    """Return what is wrong with a wheel: its size, or the library in it."""
    platform = wheel.stem.split("-")[-1]
    if wheel.stat().st_size > LARGEST:
        yield f"{wheel.name}: larger than {LARGEST / 1e6:g} MB"
    with ZipFile(wheel) as archive:
        (name,) = (name for name in archive.namelist() if name.startswith(LIBRARY))
        processor, needed, version = system_needed(archive.read(name))
    system = next(system for system in ALLOWED if platform.startswith(system))
    wanted = next(code for tag, code in PROCESSORS.items() if platform.endswith(tag))
    if processor != wanted:
        yield f"{wheel.name}: {name} is for {processor}"
    if foreign := [other for other in needed if not other.startswith(ALLOWED[system])]:
        yield f"{wheel.name}: {name} needs {', '.join(foreign)}"
    promised = [int(part) for part in platform.split("_") if part.isdigit()][:2]
    if system in ("manylinux", "macosx") and not [0] < version <= promised:
        yield f"{wheel.name}: {name} needs version {version} of its system"
    if platform.startswith("manylinux"):
        shown = subprocess.run(
            [sys.executable, "-m", "auditwheel", "show", wheel], capture_output=True, text=True, check=False
        )
        if f'"{platform}"' not in shown.stdout:
            yield f"{wheel.name}: auditwheel says otherwise:\n{shown.stdout}{shown.stderr}"


def system_needed(content):
    """Return the processor of a library, the libraries it needs, and the oldest version of its system."""
    lief.logging.disable()  # it warns of sections of Windows that are empty
    binary = lief.parse(content)
    if isinstance(binary, lief.ELF.Binary):
        names = [
            symbol.name
            for needs in binary.symbols_version_requirement
            for symbol in needs.get_auxiliary_symbols()
        ]
        versions = [[int(part) for part in name.removeprefix("GLIBC_").split(".")] for name in names]
        return binary.header.machine_type.name, list(binary.libraries), max(versions, default=[0])[:2]
    if isinstance(binary, lief.PE.Binary):
        return binary.header.machine.name, [entry.name for entry in binary.imports], [0]
    needed = [entry.name for entry in binary.libraries if "libkernels" not in entry.name]
    return binary.header.cpu_type.name, needed, list(binary.build_version.minos)[:2]


if __name__ == "__main__":
    sys.exit(main(sys.argv[1:]))
