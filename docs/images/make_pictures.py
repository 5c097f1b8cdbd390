"""Draw report.png of this folder again, from the report of a run on the samples, or check that it is of it.

    python docs/images/make_pictures.py results/report.html [PICTURE]
    python docs/images/make_pictures.py results/report.html --check

The picture holds the words that it shows. The check fails where they differ from those of the page, or a
number by more than a tenth, which is the last of two digits. To draw takes Chromium, as `chromium` or
`google-chrome` on the path.
"""

import html
import re
import shlex
import shutil
import subprocess
import sys
import tempfile
from itertools import zip_longest
from pathlib import Path

from PIL import Image, ImageChops
from PIL.PngImagePlugin import PngInfo

SURFACE = "sandblasted"
PARTS = ("Pressure and gap",)
WIDTH, MARGIN, COLOURS = 1200, 24, 240
WORDS = "Description"  # of the PNG
NUMBER = r"\d+(?:\.\d+)?"


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


def words_of(page: str) -> str:
    """Return the words of an excerpt, without markup."""
    return " ".join(html.unescape(re.sub("<[^>]*>", " ", page.partition("<body>")[2])).split())


def difference(shown: str, words: str) -> str:
    """Return where the words of a picture and of a page part, nothing where they agree."""
    for old, new in zip_longest(
        *(re.findall(rf"{NUMBER}|[^\d\s]+", text) for text in (shown, words)), fillvalue=""
    ):
        numbers = [float(text) for text in (old, new) if re.fullmatch(NUMBER, text)]
        if old != new and (len(numbers) < 2 or abs(numbers[0] - numbers[1]) > 0.1 * max(numbers)):
            return f"{old!r}, on the page {new!r}"
    return ""


def screenshot(page: Path, picture: Path, words: str) -> None:
    """Photograph a page of WIDTH pixels, cut off what is white around it, and add its words."""
    browser = shutil.which("chromium") or shutil.which("google-chrome")
    options = ["--headless", "--no-sandbox", "--disable-gpu", "--hide-scrollbars"]
    options += [f"--window-size={WIDTH},4000", f"--screenshot={picture}"]
    subprocess.run([browser, *options, page.as_uri()], check=True, capture_output=True)
    image = Image.open(picture).convert("RGB")
    white = Image.new("RGB", image.size, image.getpixel((0, image.height - 1)))
    _, top, _, bottom = ImageChops.difference(image, white).getbbox()
    image = image.crop((0, max(top - MARGIN, 0), WIDTH, bottom + MARGIN))
    said = PngInfo()
    said.add_itxt(WORDS, words, zip=True)
    image.quantize(COLOURS, dither=Image.Dither.NONE).save(picture, optimize=True, pnginfo=said)


def main(report: str, *words: str) -> None:
    """Write the picture, report.png beside this file unless another is named, or check it."""
    picture = Path(__file__).with_name("report.png")
    page_text = excerpt(Path(report).read_text(encoding="utf-8"))
    if words == ("--check",):
        found = difference(Image.open(picture).text.get(WORDS, ""), words_of(page_text))
        again = shlex.join([sys.executable, __file__, str(Path(report).resolve())])
        sys.exit(f"{picture} is of another page ({found}); draw it again: {again}" if found else 0)
    picture = Path(*words) if words else picture
    with tempfile.TemporaryDirectory() as folder:
        page = Path(folder) / "excerpt.html"
        page.write_text(page_text, encoding="utf-8")
        screenshot(page, picture, words_of(page_text))
    print(f"{picture}: {picture.stat().st_size / 1000:.0f} kB")


if __name__ == "__main__":
    main(*sys.argv[1:])
