"""Draw report.png of this folder again, from the report of a run on the samples.

    python docs/images/make_pictures.py results/report.html

Needs Chromium, as `chromium` or `google-chrome` on the path.
"""

import re
import shutil
import subprocess
import sys
import tempfile
from pathlib import Path

from PIL import Image, ImageChops

SURFACE = "sandblasted"
PARTS = ("Pressure and gap",)
WIDTH, MARGIN, COLOURS = 1200, 24, 240


def excerpt(report: str) -> str:
    """Return the page with nothing but its first table and some parts of one surface on it."""
    head, _, _ = report.partition("<body")
    section = re.search(rf'<section class="surface" id="surface-{SURFACE}">.*?</section>', report, re.DOTALL)
    title, *parts = section.group().split("<h3>")
    kept = [part for part in parts if part.startswith(PARTS)]
    if len(kept) != len(PARTS):
        sys.exit(f"the report has no longer all of the parts {PARTS}: choose others")
    glance = re.search(r'<section id="glance">.*?</section>', report, re.DOTALL).group()
    text = "<h3>".join(["", *kept])
    heading = re.search(r"<h2>.*?</h2>", title, re.DOTALL).group()
    return f"{head}<body><main>{glance}{heading}{text}</main></body></html>"


def screenshot(page: Path, picture: Path) -> None:
    """Photograph a page of WIDTH pixels and cut off what is white around it."""
    browser = shutil.which("chromium") or shutil.which("google-chrome")
    options = ["--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars"]
    options += [f"--window-size={WIDTH},3000", f"--screenshot={picture}"]
    subprocess.run([browser, *options, page.as_uri()], check=True, capture_output=True)
    image = Image.open(picture).convert("RGB")
    white = Image.new("RGB", image.size, image.getpixel((0, image.height - 1)))
    _, top, _, bottom = ImageChops.difference(image, white).getbbox()
    image = image.crop((0, max(top - MARGIN, 0), WIDTH, bottom + MARGIN))
    image.quantize(COLOURS, dither=Image.Dither.NONE).save(picture, optimize=True)


def main(report: str) -> None:
    """Write report.png beside this file."""
    picture = Path(__file__).with_name("report.png")
    with tempfile.TemporaryDirectory() as folder:
        page = Path(folder) / "excerpt.html"
        page.write_text(excerpt(Path(report).read_text(encoding="utf-8")), encoding="utf-8")
        screenshot(page, picture)
    print(f"{picture}: {picture.stat().st_size / 1000:.0f} kB")


if __name__ == "__main__":
    main(*sys.argv[1:])
