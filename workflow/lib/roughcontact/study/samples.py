"""The sample files, all of which come with a checkout, and two with an installed package."""

from pathlib import Path

from roughcontact.errors import InputFileError
from roughcontact.study.dependencies import PACKAGE

# of a wheel, and of a checkout
_FOLDERS = (PACKAGE / "_workflow/data_samples", PACKAGE.parents[2] / "data_samples")
_NO_SAMPLES = {".md", ".py"}  # what tells of the files, and the program that makes them


def sample_file(name: str = "sandblasted.x3p") -> Path:
    """Return the path of a sample file, a synthetic surface in the format of an instrument.

    Parameters
    ----------
    name : str
        Name of the file: ``"sandblasted.x3p"`` or ``"stylus-profile.csv"``; in a checkout also the others of
        its folder data_samples.

    Returns
    -------
    Path

    Raises
    ------
    InputFileError
        There is no sample of this name; those that there are are listed.

    Examples
    --------
    >>> sample_file().name
    'sandblasted.x3p'
    """
    folder = next((folder for folder in _FOLDERS if folder.is_dir()), _FOLDERS[-1])
    names = sorted(path.name for path in folder.glob("*") if path.suffix not in _NO_SAMPLES)
    if name not in names:
        raise InputFileError(f"{name}: not a sample; the samples are {', '.join(names)}")
    return folder / name
