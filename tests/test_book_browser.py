"""Every page of the book in a real browser, at a desk's width and at a phone's: no script error, no
request to anywhere, nothing wider than the page, and a search that finds.
"""

import browser as chromium
import pytest

from conftest import ROOT
from imu_lib.book import build, chapters, contents

WIDTHS = (1440, 390)
WORDS = {  # what a reader may look for -> a page that must be among the first results
    "Allan": "allan_variance",
    "whiteness": "autoregressive",
    "turntable": "calibration",
    "quantization": "noise_processes",
    "outage": "gps_outages",
    "Ljung": "autoregressive",
    "gravity": "calibration",
    "wavelet": "wavelet_denoising",
    "Schuler": "strapdown_and_filter",
    "aliasing": "noise_processes",
}
# what is wider than the page without a scroll bar of its own
WIDE = """(() => {
  const page = document.documentElement.clientWidth;
  if (document.documentElement.scrollWidth <= page) return [];
  const scrolls = (e) => { for (let p = e; p && p !== document.body; p = p.parentElement)
      if (['auto', 'scroll', 'hidden'].includes(getComputedStyle(p).overflowX)) return true; return false; };
  return [...document.querySelectorAll('main *')].filter((e) => {
      const box = e.getBoundingClientRect();
      return box.width && box.right > page + 1 && !scrolls(e); })
    .slice(0, 3).map((e) => e.tagName + '.' + e.className + ' ' + e.textContent.slice(0, 40));
})()"""
SEARCHED = """new Promise((done) => { const look = (left) => {
    const links = [...document.querySelectorAll('#search-results ul.search li a')].map((a) => a.getAttribute('href'));
    const summary = document.querySelector('#search-results p.search-summary');
    if ((summary && /found|did not match/.test(summary.textContent)) || !left) done(links);
    else setTimeout(() => look(left - 1), 50); }; look(100); })"""


@pytest.fixture(scope="module")
def pages(tmp_path_factory):
    """The book's pages, built from the stored outputs."""
    if chromium.found() is None:
        pytest.skip("neither Chromium nor Chrome is installed")
    out = tmp_path_factory.mktemp("book") / "html"
    build.default(out, execute_first=False)
    return out


@pytest.fixture(scope="module")
def window(pages, tmp_path_factory):
    opened = chromium.Browser(chromium.found(), tmp_path_factory.mktemp("profile"))
    yield opened
    opened.close()


def test_every_page_is_quiet_and_fits(pages, window):
    every = sorted(
        path
        for path in pages.rglob("*.html")
        if "_static" not in path.parts and path.name not in ("index.html", "search.html")
    )
    assert len(every) > len(contents.entries(ROOT))
    wrong = {}
    for path in every:
        window.open(path.as_uri(), WIDTHS[0])
        for width in WIDTHS:
            window.size(width)
            wide = window.evaluate(WIDE)
            if wide:
                wrong[f"{path.name} at {width} px"] = wide
        if window.problems:
            wrong[path.name] = window.problems
    assert not wrong


def test_search_finds(pages, window):
    for word, slug in WORDS.items():
        window.open(f"{(pages / 'search.html').as_uri()}?q={word}", WIDTHS[0])
        links = window.evaluate(SEARCHED)
        assert any(slug in (link or "") for link in links), (word, links)
    assert not window.problems


def test_a_computed_table_sorts(pages, window):
    chapter = next(c for c in chapters.chapters(ROOT) if c.slug == "errata")
    window.open((pages / f"nbs/{chapter.slug}.html").as_uri(), WIDTHS[0])
    values = """(() => { const table = document.querySelectorAll('table.computed')[1];
        table.tHead.rows[0].cells[2].click();
        return [...table.tBodies[0].rows].map((row) => parseFloat(row.cells[2].innerText)); })()"""
    found = window.evaluate(values)
    assert len(found) == 3 and found == sorted(found)
