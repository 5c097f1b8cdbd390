"""The threads of the kernels under ThreadSanitizer, which finds what two threads touch without order."""

import shutil
import subprocess
from pathlib import Path

import pytest

HERE = Path(__file__).parent
SOURCES = HERE.parents[1] / "workflow/lib/roughcontact/kernels/c"


def compiled(folder, *options):
    """Return the program of race.c with the sanitizer in it; skip where this compiler has none."""
    program = folder / "race"
    flags = ["-std=gnu11", "-g", "-O1", "-fsanitize=thread", *options, f"-I{SOURCES}"]
    files = [str(HERE / "race.c"), str(SOURCES / "threads.c")]
    command = ["gcc", *flags, *files, "-o", str(program), "-lpthread", "-lm"]
    if shutil.which("gcc") is None:
        pytest.skip("no gcc")
    process = subprocess.run(command, capture_output=True, text=True, check=False)
    if "libtsan" in process.stderr:
        pytest.skip("this gcc has no ThreadSanitizer")
    assert process.returncode == 0, process.stderr
    return program


@pytest.mark.slow
def test_threads_share_passes_without_a_race(tmp_path):
    for _ in range(5):
        process = subprocess.run(
            [compiled(tmp_path)], capture_output=True, text=True, check=False, timeout=300
        )
        assert process.returncode == 0, process.stdout + process.stderr
        assert process.stdout == "1200 passes, 0 wrong\n"


@pytest.mark.slow
def test_a_race_would_be_found(tmp_path):
    program = compiled(tmp_path, "-DSEEDED")
    process = subprocess.run([program], capture_output=True, text=True, check=False, timeout=300)
    assert process.returncode == 66
    assert "WARNING: ThreadSanitizer: data race" in process.stderr
