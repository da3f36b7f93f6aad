"""Every page of the book in a real browser, at a desk's width and at a phone's: no script error, no
request to anywhere, nothing wider than the page, and a search that finds.
"""

import json
import math
import re

import browser as chromium
import nbformat
import pytest

from conftest import ROOT
from imu_lib.book import build, chapters

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
# printed lines that end beyond the page, but for those that stand in columns
CUT = """[...document.querySelectorAll('.cell_output pre')].filter((pre) => {
  const lines = pre.textContent.split('\\n').filter((line) => line.trim());
  const columns = lines.filter((line) => line.trim().split('  ').length > 1).length;
  return 2 * columns <= lines.length && pre.scrollWidth > pre.clientWidth + 1; }).map((pre) => pre.textContent)"""
# what ends beyond the sheet when the page is printed, as it is for the PDF
BEYOND = """[...document.querySelectorAll('article table, article img, article pre')].filter((e) =>
  e.getBoundingClientRect().right > document.documentElement.clientWidth + 1).map((e) => e.textContent.slice(0, 60))"""
SHEET = 720
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


#: Every page, by the name that the table of contents has for it, and the two that Sphinx adds.
PAGES = [
    "book/intro",
    *(entry["file"] for _, entry in chapters.entries(chapters.table_of_contents(ROOT))),
    "genindex",
    "py-modindex",
]


@pytest.fixture(scope="module", params=PAGES)
def opened(request, pages, window):
    """A page, opened once for all that is asked of it."""
    window.open((pages / f"{request.param}.html").as_uri(), WIDTHS[0])
    return request.param


def test_no_page_is_left_out(pages):
    found = {path.relative_to(pages).with_suffix("").as_posix() for path in pages.rglob("*.html")}
    assert {n for n in found if not n.startswith("_static/")} == {*PAGES, "index", "search"}


def test_a_page_is_quiet_and_fits(opened, window):
    for width in WIDTHS:
        window.size(width)
        assert not window.evaluate(WIDE), width
        assert not window.evaluate(CUT), width
    assert not window.problems


def test_nothing_is_cut_on_paper(opened, window):
    window.size(SHEET)
    window.send("Emulation.setEmulatedMedia", media="print")
    cut = window.evaluate(BEYOND)
    window.send("Emulation.setEmulatedMedia", media="")
    assert not cut


# opens a page's figures to zoom, one after the other, and says where a point of each lies in the window
OPENED = """(async (number) => {
  const bar = document.querySelectorAll('.explore-bar')[number], stage = bar.nextElementSibling;
  bar.querySelector('button').click();
  for (let left = 400; left && !stage.dataset.ready; left--) await new Promise((done) => setTimeout(done, 25));
  stage.scrollIntoView({ block: 'center', behavior: 'instant' });
  const inside = (axis, v) => v !== null && !isNaN(v) && axis.d2p(v) > 5 && axis.d2p(v) < axis._length - 5;
  const box = stage.getBoundingClientRect(), layout = stage._fullLayout;
  for (const trace of [...stage._fullData].reverse()) {
    if (trace.hoverinfo === 'skip' || trace.visible !== true) continue;
    const [x, y] = ['x', 'y'].map((d) => layout[d + 'axis' + trace[d + 'axis'].slice(1)]);
    const shown = [...trace.x.keys()].filter((k) => inside(x, trace.x[k]) && inside(y, trace.y[k]));
    if (!shown.length) continue;
    const k = shown[Math.floor(shown.length / 2)];
    return [box.left + x._offset + x.d2p(trace.x[k]), box.top + y._offset + y.d2p(trace.y[k])];
  }
  return null; })(%d)"""
TOLD = """(async () => { for (let left = 60; left; left--) {
    const label = document.querySelector('.explored .hoverlayer .hovertext');
    if (label) return [...label.querySelectorAll('text')].map((t) => t.textContent.trim()
        ? [...t.querySelectorAll('tspan.line')].map((l) => l.textContent).join('\\n') || t.textContent : '');
    await new Promise((done) => setTimeout(done, 25)); }
  return null; })()"""


def figures_of(slug):
    """What the cells of a chapter stored for zooming, in order."""
    notebook = nbformat.read(ROOT / f"nbs/{slug}.ipynb", 4)
    outputs = [o.data for c in notebook.cells for o in c.get("outputs", []) if "data" in o]
    stored = [data["text/html"] for data in outputs if "explorable" in data.get("text/html", "")]
    return [json.loads(text[text.index(">") + 1 : text.rindex("</script>")]) for text in stored]


def points(figure):
    """(name, unit, value) of each axis that has numbers, for every point that has a label."""
    for trace in figure["data"]:
        if trace.get("hoverinfo") == "skip":
            continue
        axes = [figure["layout"][f"{d}axis{trace[f'{d}axis'][1:]}"] for d in "xy"]
        words = [parted(axis["title"]["text"]) for axis in axes]
        for place in zip(trace["x"], trace["y"]):
            if None not in place:
                yield [(*w, v) for w, v, axis in zip(words, place, axes) if "tickvals" not in axis]


def parted(label):
    """Name and unit of an axis label, a panel's title taken off."""
    name, comma, unit = label.rpartition(", ")
    whole = not comma or unit.count("(") != unit.count(")")
    name = re.sub(r"^[^:]*: (?=\S)", "", label if whole else name)
    return name, "" if whole else unit


def read(line, name, unit):
    """The number of a line of a label."""
    text = line.removeprefix(name).removesuffix(unit).strip().replace("−", "-")
    return float(text) if re.fullmatch(r"-?[\d.]+(e[-+]?\d+)?", text) else math.nan


#: Chapter -> its figures that zoom, of those that have any.
ZOOMING = {f"nbs/{c.slug}": found for c in chapters.chapters(ROOT) if (found := figures_of(c.slug))}


@pytest.mark.parametrize("opened", ZOOMING, indirect=True)
def test_a_figure_tells_the_value_under_the_pointer(opened, window):
    figures, slug = ZOOMING[opened], opened.rpartition("/")[2]
    window.size(WIDTHS[0])
    for number, figure in enumerate(figures):
        x, y = window.evaluate(OPENED % number)
        window.send("Input.dispatchMouseEvent", type="mouseMoved", x=x - 1, y=y - 1)
        window.send("Input.dispatchMouseEvent", type="mouseMoved", x=x, y=y)
        told = window.evaluate(TOLD)
        assert told, (slug, number)
        assert any(
            all(
                # a label has four digits
                f"{name} " in line
                and line.endswith(unit)
                and math.isclose(read(line, name, unit), value, rel_tol=6e-4, abs_tol=1e-9)
                for line, (name, unit, value) in zip(told[-1].splitlines(), point, strict=True)
            )
            for point in points(figure)
            if len(point) == len(told[-1].splitlines())
        ), (slug, number, told)
        window.send("Input.dispatchMouseEvent", type="mouseMoved", x=1, y=1)
        bar = f"document.querySelectorAll('.explore-bar')[{number}]"
        window.evaluate(f"{bar}.querySelector('button').click()")
    assert not window.problems


def test_search_finds(pages, window):
    """The first word by the address, as the search field sends it; the others on the same page."""
    first = next(iter(WORDS))
    window.open(f"{(pages / 'search.html').as_uri()}?q={first}", WIDTHS[0])
    for word, slug in WORDS.items():
        if word != first:
            window.evaluate("document.querySelector('#search-results').replaceChildren()")
            window.evaluate(f"Search.performSearch('{word}')")
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


def test_a_chapter_shows_itself_as_slides(pages, window):
    window.open((pages / "nbs/spectrum.html").as_uri() + "#slides", WIDTHS[0])
    count = "document.querySelector('.deck-count').textContent"
    seen = "[...document.querySelectorAll('.deck-block')].filter((b) => b.offsetParent).length"
    first, of = window.evaluate(count).split(" / ")
    assert first == "1" and int(of) > 15
    press = "document.body.dispatchEvent(new KeyboardEvent('keydown', {key: '%s', bubbles: true}))"
    shown = []
    for _ in range(int(of) - 1):
        window.evaluate(press.replace("%s", "ArrowRight"))
        shown.append(window.evaluate(seen))
        assert not window.evaluate(WIDE)
    assert window.evaluate(count) == f"{of} / {of}" and 1 <= min(shown) and max(shown) <= 6
    window.evaluate(press.replace("%s", "Escape"))
    assert window.evaluate(seen) > max(shown) and not window.problems


def test_a_word_of_the_glossary_explains_itself(pages, window):
    from imu_lib.book import glossary

    window.open((pages / "nbs/allan_variance.html").as_uri(), WIDTHS[1])
    marks = window.evaluate("[...document.querySelectorAll('.term')].map((t) => t.textContent)")
    assert len(marks) > 8 and len({m.lower() for m in marks}) == len(marks)
    window.evaluate("""(() => {
        window.mark = [...document.querySelectorAll('.term')].find((t) => /^Gauss-Markov process$/i.test(t.textContent));
        mark.scrollIntoView({ block: 'center', behavior: 'instant' }); })()""")
    x, y = window.evaluate(
        "new Promise((done) => setTimeout(() => { const b = mark.getBoundingClientRect(); "
        "done([b.left + 9, (b.top + b.bottom) / 2]); }, 200))"
    )
    window.send("Input.dispatchMouseEvent", type="mouseMoved", x=x, y=y)
    visible, text, left, right, address = window.evaluate("""(() => {
        const note = document.querySelector('.term-note'), box = note.getBoundingClientRect();
        return [getComputedStyle(note).visibility, note.textContent, box.left, box.right, mark.getAttribute('href')]; })()""")
    assert visible == "visible" and text == glossary.terms(ROOT)["Gauss-Markov process"]
    assert left >= 0 and right <= WIDTHS[1]
    page, _, name = address.partition("#")
    target = (pages / "nbs" / page).resolve()
    explained = target.read_text(encoding="utf-8")
    assert f'id="{name}"' in explained
    assert all(f'id="term-{word.replace(" ", "-")}"' in explained for word in glossary.terms(ROOT))
    assert not window.problems


def test_a_function_in_the_text_leads_to_its_reference(pages, window):
    window.open((pages / "nbs/allan_variance.html").as_uri(), WIDTHS[0])
    found = window.evaluate(
        "[...document.querySelectorAll('a.to-reference')].map((a) => a.getAttribute('href'))"
    )
    assert len(found) > 5 and any(a.endswith("#imu_lib.allan.fit") for a in found)
    reference = (pages / "book/api.html").read_text(encoding="utf-8")
    assert all(f'id="{address.partition("#")[2]}"' in reference for address in found)


def test_goals_are_ticked_off_and_counted(pages, window):
    window.open((pages / "nbs/errata.html").as_uri(), WIDTHS[0])
    ticks = "document.querySelectorAll('.can-now input')"
    goals = window.evaluate(f"{ticks}.length")
    assert goals == 3
    window.evaluate(f"{ticks}[1].click()")
    window.open((pages / "nbs/errata.html").as_uri(), WIDTHS[0])
    assert window.evaluate(f"[...{ticks}].map((t) => t.checked)") == [False, True, False]
    window.open((pages / "book/intro.html").as_uri(), WIDTHS[0])
    told = "[...document.querySelectorAll('.chapter-done')].map((t) => t.textContent)"
    assert window.evaluate(told) == ["1 of 3 goals"] and not window.problems


def test_the_slides_button_stands_in_the_bar(pages, window):
    """Whole, within the bar, beside the others and not over them."""
    window.open((pages / "nbs/spectrum.html").as_uri(), WIDTHS[0])
    boxes = """(() => { const box = (e) => { const b = e.getBoundingClientRect(); return [b.top, b.bottom, b.left, b.right]; };
        const one = document.querySelector('.deck-start'), bar = document.querySelector('.bd-header-article, .header-article__inner');
        return [box(one), box(bar), [...one.parentElement.querySelectorAll('.btn')].filter((b) => b !== one && b.offsetParent).map(box)]; })()"""
    own, bar, others = window.evaluate(boxes)
    assert own[0] >= bar[0] >= 0 and own[1] <= bar[1]
    assert others and all(own[3] <= left or right <= own[2] for _, _, left, right in others)
