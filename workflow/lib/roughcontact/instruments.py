"""What is known of an instrument, in words that people read; `io.metadata` says where it comes from."""

from roughcontact.quantities import number

# word -> what people call it, in the order in which they are shown
LABELS = {
    "kind": "kind",
    "vendor": "vendor",
    "name": "instrument",
    "serial": "serial number",
    "scanner_serial": "serial number of scanner",
    "lens": "lens",
    "magnification": "magnification",
    "numerical_aperture": "numerical aperture",
    "probe": "probe",
    "acquisition_time": "date",
    "calibration_time": "calibrated",
    "software": "software",
    "sample": "sample",
    "comment": "comment",
}


def labelled(instrument: dict) -> list[tuple[str, str]]:
    """Return (label, text) of what is known of the instrument, for people."""
    return [
        (LABELS.get(word, word.replace("_", " ")), number(value) if isinstance(value, float) else str(value))
        for word, value in instrument.items()
    ]
