"""README's pictures from a report's page: pictures.py REPORT.html FILE. Writes FILE-light.webp and FILE-dark.webp.

They show the captured scenes in the first form of the page's picture: time per problem against the error. Needs Debian's package chromium.
"""

import pathlib
import sys

sys.path.insert(0, str(pathlib.Path(__file__).resolve().parents[2] / "tests/support"))
import chromium  # noqa: E402

HIDE = """
  for (const figure of document.querySelectorAll('.pictures .picture:not(.scenes)')) figure.remove();
  document.querySelector('.tip').remove();
"""
BOX = """(() => {
  const boxes = ['.pictures', '.legend'].map((each) => document.querySelector(each).getBoundingClientRect());
  return { x: boxes[0].x - 8, y: boxes[0].y + scrollY - 8, width: boxes[0].width + 16,
           height: boxes[1].bottom - boxes[0].y + 16 };
})()"""


def main(report, target):
    with chromium.Browser(width=960) as browser:
        for scheme in ("light", "dark"):
            browser.prefer(scheme)
            browser.open(pathlib.Path(report).resolve().as_uri())
            browser.wait("document.querySelector('.pictures svg')")
            browser.run(HIDE)
            clip = {**browser.run(BOX), "scale": 2}
            pathlib.Path(f"{target}-{scheme}.webp").write_bytes(browser.screenshot(clip, "webp"))


if __name__ == "__main__":
    if len(sys.argv) != 3:
        sys.exit(__doc__)
    if not chromium.find_chromium():
        sys.exit("pictures.py: Chromium is not installed (Debian's package chromium)")
    main(*sys.argv[1:])
