#!/usr/bin/env python3
# A sweep's report in a browser: it stands alone, its table sorts, it can be read without scripts, and nothing is wider than the page.
# Headless Chromium: --dump-dom for what the page became, --screenshot for what is seen.
"""Usage: report_test.py PROGRAM. Exit codes: 0 passed, 1 failed, 77 skipped."""
import html.parser
import json
import os
import re
import shutil
import subprocess
import sys
import tempfile

SKIPPED = 77
WIDTH, HEIGHT = 1300, 900
SWEEP = ["block", "--volume-size", "32x30x28", "--size", "120x90", "--techniques", "hold,points,splats", "--heuristics", "median", "--radii", "voxel",
         "--point-sizes", "2", "--server-sides", "60,120", "--angles", "0,10,25", "--links", "4g", "--instants", "1", "--draws", "1", "--quiet"]

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
  circles: document.querySelectorAll('svg.plot circle title').length,
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


def browse(chromium, page, *options):
    result = subprocess.run(
        [chromium, "--headless", "--no-sandbox", "--disable-gpu", "--disable-dev-shm-usage", "--hide-scrollbars", "--enable-logging=stderr",
         f"--window-size={WIDTH},{HEIGHT}", f"--user-data-dir={os.path.dirname(page)}/profile", *options, "file://" + page],
        capture_output=True, text=True, timeout=100)
    expect(result.returncode == 0, f"Chromium ended with {result.returncode}: {result.stderr[-1000:]}")
    complaints = [line for line in result.stderr.splitlines() if ":CONSOLE" in line]
    expect(not complaints, "the page complains: " + "\n".join(complaints))
    return result.stdout


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
    title = re.search(r"<title>(.*?)</title>", browse(chromium, asked, "--dump-dom"), re.S).group(1)
    answers = json.loads(title.replace("&lt;", "<").replace("&gt;", ">").replace("&quot;", '"').replace("&amp;", "&"))
    expect(len(answers["before"]) == len(sweep["rows"]), "the table lacks rows")
    expect(answers["rising"] == sorted(answers["before"]), f"a click does not sort: {answers['rising']}")
    expect(answers["falling"] == sorted(answers["before"], reverse=True), "a second click does not turn the order round")
    expect(answers["names"] == sorted(answers["names"]) and len(set(answers["names"])) > 2, "names do not sort")
    expect(answers["overflow"] <= 0, f"the page is {answers['overflow']} pixels wider than the window")
    expect(answers["images"] == answers["allImages"] > 10, f"{answers['images']} of {answers['allImages']} pictures are there")
    expect(len(answers["plots"]) == 4 and min(answers["plots"]) > 400, f"plots: {answers['plots']}")
    expect(not answers["cut"], f"texts that do not fit into their plots: {answers['cut']}")
    expect(answers["circles"] >= len(sweep["rows"]), f"{answers['circles']} points say what they are")
    expect(answers["fetched"] == 0, f"the page fetches {answers['fetched']} things")

    # Without scripts everything is there as well: in the page as it is written, and in what is seen of it.
    written = Written()
    written.feed(page)
    written.close()
    expect(not written.open, f"tags that nothing closes: {written.open}")
    for line in sweep["findings"]["answer"].splitlines():
        expect(line in written.text, "without scripts this is missing: " + line)
    for row in sweep["rows"]:
        expect(f"{row['flip']:.4f}" in written.text, f"without scripts a row is missing: {row}")
    plain, picture = os.path.join(folder, "plain.html"), os.path.join(folder, "page.png")
    with open(plain, "w", encoding="utf-8") as file:
        file.write(re.sub(r"<script>.*?</script>", "", page, flags=re.S))
    browse(chromium, plain, f"--screenshot={picture}")
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
