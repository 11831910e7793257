#!/usr/bin/env python3
# A sweep's report in a browser: it stands alone, its table sorts, it can be read without scripts, nothing is cut off, and no point hides another.
# Headless Chromium: --dump-dom for what the page became, --screenshot for what is seen.
"""Usage: report_test.py PROGRAM. Exit codes: 0 passed, 1 failed, 77 skipped."""
import html
import html.parser
import json
import math
import os
import re
import shutil
import subprocess
import sys
import tempfile

SKIPPED = 77
WIDTHS, HEIGHT = (1400, 1280), 900
SWEEP = ["block", "--volume-size", "32x30x28", "--size", "120x90", "--techniques", "hold,points,splats", "--heuristics", "median,gradient", "--radii", "voxel",
         "--point-sizes", "2", "--server-sides", "60,120", "--angles", "0,10,25", "--links", "4g;delay=40,down.rate=2M", "--instants", "1", "--draws", "1", "--quiet"]

# What the page is asked after it is there: it leaves the answers as JSON in its title.
QUESTIONS = """
<script>
const column = index => [...document.querySelectorAll('#rows tbody tr')].map(row => row.cells[index].dataset.value === undefined ?
                                                                            row.cells[index].textContent : +row.cells[index].dataset.value);
const heads = [...document.querySelectorAll('#rows th')];
const flip = heads.findIndex(head => head.textContent === 'FLIP');
const before = column(flip);
heads[flip].click(); const rising = column(flip);
heads[flip].click(); const falling = column(flip);
heads[0].click(); const names = column(0);
document.title = JSON.stringify({before, rising, falling, names,
  overflow: document.documentElement.scrollWidth - window.innerWidth,
  images: [...document.images].filter(image => image.complete && image.naturalWidth > 0).length, allImages: document.images.length,
  plots: [...document.querySelectorAll('svg.plot')].map(plot => plot.getBoundingClientRect().width),
  cut: [...document.querySelectorAll('svg.plot text')].filter(text => {
    const box = text.getBoundingClientRect(), plot = text.ownerSVGElement.getBoundingClientRect();
    return box.right > plot.right || box.left < plot.left || box.top < plot.top || box.bottom > plot.bottom;
  }).map(text => text.textContent),
  scrolled: [...document.querySelectorAll('.wide')].filter(box => box.scrollWidth > box.clientWidth).map(box => box.className),
  lastColumn: Math.max(...[...document.querySelectorAll('#rows tr')].map(row => row.cells[row.cells.length - 1].getBoundingClientRect().right)),
  pageWidth: document.documentElement.clientWidth,
  marks: [...document.querySelectorAll('svg.plot')].map(plot => [...plot.querySelectorAll('g.mark')].map(mark => {
    const shapes = [...mark.querySelectorAll('circle, path')], count = mark.querySelector('.count');
    const [x, y] = shapes[0].tagName === 'circle' ? [+shapes[0].getAttribute('cx'), +shapes[0].getAttribute('cy')] :
                                                    shapes[0].getAttribute('d').match(/^M(\\S+) ([^L]+)/).slice(1).map(Number);
    return {x, y, count: count ? +count.textContent : 1, titles: mark.querySelector('title').textContent.split('\\n\\n'),
            colours: new Set(shapes.map(shape => shape.getAttribute('fill'))).size};
  })),
  fetched: performance.getEntriesByType('resource').filter(entry => !entry.name.startsWith('data:')).length});
</script>
"""


class Failure(Exception):
    pass


class Written(html.parser.HTMLParser):
    """The text of a page outside its script, and the tags that are still open."""

    EMPTY = {"meta", "img"}

    def __init__(self):
        super().__init__()
        self.text, self.open = "", []

    def handle_starttag(self, tag, attributes):
        if tag not in self.EMPTY:
            self.open.append(tag)

    def handle_startendtag(self, tag, attributes):
        pass

    def handle_endtag(self, tag):
        expect(self.open and self.open[-1] == tag, f"</{tag}> closes {self.open[-1:]} in line {self.getpos()[0]}")
        self.open.pop()

    def handle_data(self, data):
        if self.open and self.open[-1] not in ("script", "style"):
            self.text += data


def expect(condition, text):
    if not condition:
        raise Failure(text)


def browse(chromium, page, width, *options):
    result = subprocess.run(
        [chromium, "--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--hide-scrollbars", "--enable-logging=stderr",
         f"--window-size={width},{HEIGHT}", f"--user-data-dir={os.path.dirname(page)}/profile", *options, "file://" + page],
        capture_output=True, text=True, timeout=100)
    expect(result.returncode == 0, f"Chromium ended with {result.returncode}: {result.stderr[-1000:]}")
    complaints = [line for line in result.stderr.splitlines() if ":CONSOLE" in line]
    expect(not complaints, "the page complains: " + "\n".join(complaints))
    return result.stdout


def check_layout(answers, width):
    """Everything is in sight, without scrolling sideways."""
    expect(answers["overflow"] <= 0, f"the page is {answers['overflow']} pixels wider than a window of {width}")
    expect(not answers["scrolled"], f"in a window of {width} pixels these are cut off: {answers['scrolled']}")
    expect(answers["lastColumn"] <= answers["pageWidth"], f"the last column ends at {answers['lastColumn']} of {answers['pageWidth']} pixels")
    expect(not answers["cut"], f"texts that do not fit into their plots: {answers['cut']}")


def check_marks(plots, sweep):
    """No point is beneath another: a mark says how many it stands for, and what each of them is."""
    still = sum(row["link"] is None for row in sweep["rows"])
    angles = len(sweep["plan"]["angles"])
    for plot, points in ((plots[0], still / angles), (plots[2], still / angles), (plots[3], len(sweep["rows"]) - still)):
        expect(sum(mark["count"] for mark in plot) == points, f"{[mark['count'] for mark in plot]} are not {points} points")
    for plot in plots:
        for i, mark in enumerate(plot):
            expect(len(mark["titles"]) == mark["count"] and all(mark["titles"]), f"a mark does not list what it stands for: {mark}")
            expect(all(math.hypot(mark["x"] - other["x"], mark["y"] - other["y"]) >= 2 for other in plot[:i]), f"a mark hides another: {mark}")
    shared = [mark for mark in plots[2] if any(text.startswith("spheres, gradient") for text in mark["titles"])]
    for mark in shared:  # of the same bytes and, pixel for pixel, the same picture as splats
        expect(mark["colours"] == 2 and any(text.startswith("splats, gradient") for text in mark["titles"]), f"spheres without splats: {mark}")
    expect(shared, "spheres are not in the plot of bytes")


def check_words(text, sweep):
    """What is said first, and which links there were."""
    headline = re.search(r"The paper's method \(spheres.*?\n?(The method of 2012 \(points.*?)$", text, re.M)
    expect(headline, "no headline")
    best = [row["best"] for row in sweep["findings"]["equalTime"] if row["budgetMs"] == 33][0]
    expect(f"FLIP {sweep['findings']['papersMethod']['flip']:.4f}" in headline.group(0), "the headline lacks the paper's error")
    expect(re.search(r"within 33 ms a frame", headline.group(0)), "the headline lacks what is best")
    expect(f"FLIP {best['flip']:.4f}" in headline.group(0), "the headline lacks the best's error")
    expect("4g: 50 ms there and back; 5 ms of jitter; 30 Mbit/s down, 10 Mbit/s up; 0.1 % of segments lost" in text, "4g is not explained")
    expect("delay=40,down.rate=2M: 80 ms there and back; 2 Mbit/s down, no limit up" in text, "a link of keys and values is not explained")


def check(program, chromium, folder):
    subprocess.run([program, "sweep", *SWEEP, "--out", folder], check=True, timeout=200)
    with open(os.path.join(folder, "sweep.json"), encoding="utf-8") as file:
        sweep = json.load(file)
    report = os.path.join(folder, "report.html")
    with open(report, encoding="utf-8") as file:
        page = file.read()

    asked = os.path.join(folder, "asked.html")
    with open(asked, "w", encoding="utf-8") as file:
        file.write(page.replace("</body>", QUESTIONS + "</body>"))
    for width in WIDTHS:
        title = re.search(r"<title>(.*?)</title>", browse(chromium, asked, width, "--dump-dom"), re.S).group(1)
        answers = json.loads(html.unescape(title))
        check_layout(answers, width)
    check_marks(answers["marks"], sweep)
    expect(len(answers["before"]) == len(sweep["rows"]), "the table lacks rows")
    expect(answers["rising"] == sorted(answers["before"]), f"a click does not sort: {answers['rising']}")
    expect(answers["falling"] == sorted(answers["before"], reverse=True), "a second click does not turn the order round")
    expect(answers["names"] == sorted(answers["names"]) and len(set(answers["names"])) > 2, "names do not sort")
    expect(answers["images"] == answers["allImages"] > 10, f"{answers['images']} of {answers['allImages']} pictures are there")
    expect(len(answers["plots"]) == 4 and min(answers["plots"]) > 400, f"plots: {answers['plots']}")
    expect(answers["fetched"] == 0, f"the page fetches {answers['fetched']} things")

    # Without scripts everything is there as well: in the page as it is written, and in what is seen of it.
    written = Written()
    written.feed(page)
    written.close()
    expect(not written.open, f"tags that nothing closes: {written.open}")
    check_words(written.text, sweep)
    for line in sweep["findings"]["answer"].splitlines():
        expect(line in written.text, "without scripts this is missing: " + line)
    for row in sweep["rows"]:
        expect(f"{row['flip']:.4f}" in written.text, f"without scripts a row is missing: {row}")
    plain, picture = os.path.join(folder, "plain.html"), os.path.join(folder, "page.png")
    with open(plain, "w", encoding="utf-8") as file:
        file.write(re.sub(r"<script>.*?</script>", "", page, flags=re.S))
    browse(chromium, plain, WIDTHS[0], f"--screenshot={picture}")
    expect(os.path.getsize(picture) > 20000, "without scripts the page is empty")


def main():
    chromium = shutil.which("chromium") or shutil.which("google-chrome")
    if chromium is None:
        print("Skipped: no chromium.")
        return SKIPPED
    with tempfile.TemporaryDirectory(prefix="warpscope-report-") as folder:
        try:
            check(sys.argv[1], chromium, folder)
        except (Failure, subprocess.SubprocessError, OSError, ValueError) as problem:
            print(f"FAILED: {problem}")
            return 1
    print("passed")
    return 0


if __name__ == "__main__":
    sys.exit(main())
