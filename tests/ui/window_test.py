#!/usr/bin/env python3
# The real window on a display without a monitor: it shows both panels, follows pointer and keys, and closes whenever it is told to.
# Xvfb, xdotool and ImageMagick's import; the close button: x_client.py.
"""Usage: window_test.py PROGRAM [1x | 2x | closing]... Exit codes: 0 passed, 1 failed, 77 skipped."""
import json
import os
import random
import shutil
import signal
import subprocess
import sys
import tempfile
import time

import x_client

SKIPPED = 77
PATIENCE_S = 30.0       # for a picture to appear; far more than it takes
CLOSING_LIMIT_S = 2.0   # for a loaded machine; the program's own limit is 1 s
SCENE = ["block", "--volume-size", "48x40x40"]
# At scale 1, as app/ui lays the window out.
MARGIN, CONTROLS, HEADER, FOOTER = 8, 268, 88, 370  # the footer from the heat map's legend down, whose parts change
PLOT_BOTTOM, PLOT_HEIGHT = 44, 150  # the plot, from the window's lower edge up
PLOT_LIST, PLOT_LEAST_FOR_LIST = 340, 640  # the list at its right, where there is room
HOLD, SPHERES = bytes((0xb0, 0x89, 0x2f)), bytes((0x2b, 0x7d, 0xe0))  # their points, see app/picture/technique_color.h


class Failure(Exception):
    pass


class Display:
    """An X server of its own on a free display."""

    def __init__(self, width, height, dpi=None):
        read_end, write_end = os.pipe()
        self.server = subprocess.Popen(
            ["Xvfb", "-displayfd", str(write_end), "-screen", "0", f"{width}x{height}x24", "-nolisten", "tcp", "-noreset"],
            pass_fds=[write_end], stdout=subprocess.DEVNULL, stderr=subprocess.DEVNULL)
        os.close(write_end)
        with os.fdopen(read_end) as answer:
            number = answer.readline().strip()
        if not number:
            raise Failure("Xvfb did not start")
        self.name = f":{number}"
        self.environment = dict(os.environ, DISPLAY=self.name)
        self.environment.pop("WAYLAND_DISPLAY", None)
        self.state = tempfile.TemporaryDirectory()  # what windows remember: not the user's, and nothing at first
        self.environment["XDG_STATE_HOME"] = self.state.name
        if dpi is not None:
            subprocess.run(["xrdb", "-nocpp", "-merge"], input=f"Xft.dpi: {dpi}\n", text=True, check=True, env=self.environment)

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.server.terminate()
        self.server.wait()
        self.state.cleanup()

    def run(self, *command):
        return subprocess.run(command, env=self.environment, capture_output=True, check=False)


class Picture:
    """A photograph: rows of RGB bytes, of a PPM file's bytes."""

    def __init__(self, ppm):
        fields = ppm.split(maxsplit=4)[:4]
        if len(fields) < 4 or fields[0] != b"P6":
            raise Failure("the window could not be photographed")
        self.width, self.height = int(fields[1]), int(fields[2])
        self.pixels = ppm[-3 * self.width * self.height:]

    @staticmethod
    def of_window(display, window):
        return Picture(display.run("import", "-silent", "-window", window, "-depth", "8", "ppm:-").stdout)

    @staticmethod
    def of_file(path):
        return Picture(subprocess.run(["convert", path, "-depth", "8", "ppm:-"], capture_output=True, check=True).stdout)

    def region(self, box):
        x0, y0, x1, y1 = box
        return b"".join(self.pixels[3 * (y * self.width + x0):3 * (y * self.width + x1)] for y in range(y0, y1))


def plot_box(picture, scale=1.0):
    """Where points of the plot are."""
    bottom = int(picture.height - scale * PLOT_BOTTOM)
    room = picture.width / scale - CONTROLS - 5 * MARGIN
    right = 2 * MARGIN + room - (PLOT_LIST if room >= PLOT_LEAST_FOR_LIST else 0)
    return int(scale * 2 * MARGIN), int(bottom - scale * PLOT_HEIGHT), int(scale * right), bottom


def shows_a_ring(picture, colour):
    """True if the plot has a thin, smoothed line of that colour: whole pixels of it depend on where it falls, tinted ones do not."""
    region = picture.region(plot_box(picture))
    grey = min(colour)
    tint = [channel - grey for channel in colour]
    size = sum(channel * channel for channel in tint)

    def is_tinted(pixel):
        own = [channel - min(pixel) for channel in pixel]
        along = sum(a * b for a, b in zip(own, tint)) / size
        return along > 0.25 and sum((a - along * b) ** 2 for a, b in zip(own, tint)) < 0.05 * along * along * size
    return sum(is_tinted(region[i:i + 3]) for i in range(0, len(region), 3)) >= 12


def centre_of(picture, box, colour):
    """Of the pixels in the box that have exactly this colour, of those beside the leftmost one: others are the legend's. None if they are fewer than a point has."""
    x0, y0, x1, y1 = box
    row_size = 3 * (x1 - x0)
    region = picture.region(box)
    places = [(x0 + i % row_size // 3, y0 + i // row_size) for i in range(0, len(region), 3) if region[i:i + 3] == colour]
    reach = 24  # px, of a point at scale 2
    left = min(places, default=None)
    places = [place for place in places if place[0] - left[0] < reach and abs(place[1] - left[1]) < reach]
    if len(places) < 12:
        return None
    return sum(x for x, _ in places) // len(places), sum(y for _, y in places) // len(places)


def shows_something(region):
    """True if more than 2 % of the pixels differ from the most frequent one."""
    pixels = [region[i:i + 3] for i in range(0, len(region), 3 * 7)]  # every seventh says enough
    counts = {}
    for pixel in pixels:
        counts[pixel] = counts.get(pixel, 0) + 1
    return max(counts.values()) < 0.98 * len(pixels)


class Program:
    """The window under test."""

    def __init__(self, display, arguments, scale=1.0):
        self.display, self.scale = display, scale
        self.process = subprocess.Popen(arguments, env=display.environment, stdout=subprocess.PIPE, stderr=subprocess.STDOUT)
        self.window = None

    def output(self):
        return self.process.stdout.read().decode(errors="replace")

    def wait_until(self, what, condition):
        deadline = time.monotonic() + PATIENCE_S
        while time.monotonic() < deadline:
            if self.process.poll() is not None:
                raise Failure(f"the program ended with {self.process.returncode} before {what}: {self.output()}")
            if condition():
                return
            time.sleep(0.05)
        self.keep_photograph(what)
        raise Failure(f"after {PATIENCE_S:.0f} s: not {what}")

    def keep_photograph(self, what):
        folder = os.environ.get("WARPSCOPE_TEST_ARTIFACTS")
        if folder and self.window:
            name = "window-" + "".join(c if c.isalnum() else "-" for c in what) + ".png"
            self.display.run("import", "-silent", "-window", self.window, os.path.join(folder, name))

    def find_window(self):
        def found():
            answer = self.display.run("xdotool", "search", "--onlyvisible", "--class", "warpscope").stdout.split()
            self.window = answer[0].decode() if answer else None
            return self.window is not None
        self.wait_until("a window", found)

    def panels(self, picture):
        """Where the pictures of both panels are."""
        s = self.scale
        room = picture.width - s * (CONTROLS + 3 * MARGIN)
        panel = (room - s * MARGIN) / 2
        boxes = []
        for i in range(2):
            left = s * MARGIN + i * (panel + s * MARGIN)
            boxes.append((int(left + s * 12), int(s * (MARGIN + HEADER)), int(left + panel - s * 12), int(picture.height - s * FOOTER)))
        return boxes

    def point_of(self, colour):
        """Where the plot has points of that colour, or None."""
        picture = Picture.of_window(self.display, self.window)
        return centre_of(picture, plot_box(picture, self.scale), colour)

    def regions(self):
        picture = Picture.of_window(self.display, self.window)
        return [picture.region(box) for box in self.panels(picture)]

    def column(self):
        """The column of knobs."""
        picture = Picture.of_window(self.display, self.window)
        s = self.scale
        return picture.region((int(picture.width - s * CONTROLS), int(s * MARGIN), int(picture.width - s * MARGIN), int(picture.height - s * PLOT_BOTTOM)))

    def middle_of_panel(self, index):
        x0, y0, x1, y1 = self.panels(Picture.of_window(self.display, self.window))[index]
        return (x0 + x1) // 2, (y0 + y1) // 2

    def wait_for_panels(self, what):
        self.wait_until(what, lambda: all(shows_something(region) for region in self.regions()))

    def settled(self):
        """The panels' pictures once they no longer change."""
        before = self.regions()
        deadline = time.monotonic() + PATIENCE_S
        while time.monotonic() < deadline:
            time.sleep(0.3)
            now = self.regions()
            if now == before:
                return now
            before = now
        raise Failure("the panels do not come to rest")

    def changed(self, before, what):
        """The panels' pictures once both differ from what they were, and have come to rest."""
        self.wait_until(what, lambda: all(now != then for now, then in zip(self.regions(), before)))
        return self.settled()

    def point(self, position):
        self.display.run("xdotool", "mousemove", "--window", self.window, str(position[0]), str(position[1]))
        time.sleep(0.1)

    def drag(self, start, button, steps):
        self.point(start)
        self.display.run("xdotool", "mousedown", str(button))
        for step in steps:
            time.sleep(0.04)
            self.display.run("xdotool", "mousemove_relative", "--", str(step[0]), str(step[1]))
        time.sleep(0.04)
        self.display.run("xdotool", "mouseup", str(button))

    def key(self, name):
        self.display.run("xdotool", "key", name)

    def ends(self, how, limit=CLOSING_LIMIT_S, expected=""):
        start = time.monotonic()
        try:
            code = self.process.wait(timeout=PATIENCE_S)
        except subprocess.TimeoutExpired:
            self.process.kill()
            raise Failure(f"{how}: the program does not end") from None
        seconds = time.monotonic() - start
        text = self.output()
        if code != 0:
            raise Failure(f"{how}: exit code {code}: {text}")
        if expected not in text:
            raise Failure(f"{how}: the program did not say '{expected}': {text}")
        if "Sanitizer" in text:
            raise Failure(f"{how}: {text}")
        if seconds > limit:
            raise Failure(f"{how}: took {seconds:.2f} s")
        return seconds


def look_at_errors(program, home):
    """Heat maps, and the plot's points, of which one is clicked on. The panels are hold and spheres, and are so again."""
    program.wait_until("points of both techniques in the plot", lambda: program.point_of(HOLD) and program.point_of(SPHERES))
    program.point(program.middle_of_panel(0))
    program.key("h")
    program.wait_until("a heat map in the left panel", lambda: program.regions()[0] != home[0])
    heat, other = program.settled()
    if other != home[1]:
        raise Failure("the right panel changed with the left one's heat map")
    if sum(heat) >= sum(home[0]):
        raise Failure("the frame's own view should differ from the truth by little, which is dark")
    program.key("h")
    program.wait_until("the picture again", lambda: program.regions() == home)

    program.point(program.middle_of_panel(1))
    program.display.run("xdotool", "click", "1")
    program.point(program.point_of(HOLD))
    program.display.run("xdotool", "click", "1")
    program.wait_until("the technique that was clicked on in the panel that was used last", lambda: program.regions()[1] != home[1])
    program.point(program.middle_of_panel(1))
    program.key("5")  # spheres
    program.wait_until("both panels as they were", lambda: program.regions() == home)


def look_at_plan(program, home):
    """What a frame takes, which scrolls into sight: another column, the same pictures."""
    def is_another(column):
        now = program.column()
        return sum(now[i:i + 3] != column[i:i + 3] for i in range(0, len(now), 3 * 7)) > len(now) / 3 / 7 / 20  # more than a figure that changed
    before = program.column()
    program.key("e")
    program.wait_until("the stages of a frame", lambda: is_another(before))
    if program.settled() != home:
        raise Failure("the pictures changed with a look at the stages of a frame")
    stages = program.column()
    program.key("e")
    program.wait_until("the stages gone", lambda: is_another(stages))


def use_the_window(executable, scale):
    """Everything a hand does, at one content scale."""
    screen, smaller = ((1280, 800), (900, 600)) if scale == 1.0 else ((1800, 1200), (1500, 1000))
    with Display(*screen, dpi=int(96 * scale)) as display:
        program = Program(display, [executable, "view", *SCENE, "--left", "hold", "--right", "spheres"], scale)
        program.find_window()
        program.wait_for_panels("both panels show something")
        home = program.settled()

        program.drag(program.middle_of_panel(0), 1, [(int(20 * scale), int(6 * scale))] * 4)
        orbited = program.changed(home, "a drag in the left panel turns both")
        program.drag(program.middle_of_panel(1), 3, [(int(12 * scale), 0)] * 3)
        panned = program.changed(orbited, "a right drag in the right panel moves both")
        program.display.run("xdotool", "click", "4")
        program.changed(panned, "the wheel brings both nearer")

        program.key("r")
        program.wait_until("both panels back where they began", lambda: program.regions() == home)

        program.drag(program.middle_of_panel(0), 1, [(int(20 * scale), int(6 * scale))] * 4)
        program.changed(home, "a drag turns both again")
        program.point(program.middle_of_panel(0))
        program.display.run("xdotool", "click", "--repeat", "2", "--delay", "120", "1")
        program.wait_until("both panels back after a double click", lambda: program.regions() == home)

        look_at_errors(program, home)
        look_at_plan(program, home)

        program.point(program.middle_of_panel(0))
        program.key("4")  # points
        program.wait_until("another technique in the left panel", lambda: program.regions()[0] != home[0])
        if program.settled()[1] != home[1]:
            program.keep_photograph("the right panel keeps its technique")
            raise Failure("the right panel changed with the left one's technique")

        program.display.run("xdotool", "windowsize", program.window, str(smaller[0]), str(smaller[1]))
        program.wait_until("the new size", lambda: Picture.of_window(display, program.window).width == smaller[0])
        program.wait_for_panels("both panels show something after a change of size")

        program.key("ctrl+q")
        print(f"  Ctrl-Q: {program.ends('Ctrl-Q'):.2f} s")


def begin_catching_signals(program):
    """Waits until SIGTERM no longer kills the process."""
    def is_caught():
        try:
            with open(f"/proc/{program.process.pid}/status", encoding="ascii") as status:
                caught = next(line for line in status if line.startswith("SigCgt"))
        except (OSError, StopIteration):
            return False
        return int(caught.split()[1], 16) >> (signal.SIGTERM - 1) & 1
    deadline = time.monotonic() + PATIENCE_S
    while time.monotonic() < deadline and not is_caught():
        time.sleep(0.002)


def photograph_a_sweep(folder, executable, photograph):
    """Points of a sweep that was run before, and what is said of a file that is none. What every sweep has besides, spheres and points, is elsewhere."""
    sweep = os.path.join(folder, "sweep")
    subprocess.run([executable, "sweep", *SCENE, "--out", sweep, "--size", "48x48", "--quiet", "--techniques", "hold", "--heuristics", "median",
                    "--steps", "1", "--server-sides", "48", "--codecs", "raw", "--angles", "10"],
                   capture_output=True, timeout=PATIENCE_S, check=True)
    result, is_there = photograph(SCENE, "--front", os.path.join(sweep, "sweep.json"))
    if result.returncode != 0 or not is_there:
        raise Failure(f"a photograph with a sweep: exit code {result.returncode}, {result.stderr}")
    if not shows_a_ring(Picture.of_file(os.path.join(folder, "window.png")), HOLD):
        if "WARPSCOPE_TEST_ARTIFACTS" in os.environ:
            shutil.copy(os.path.join(folder, "window.png"), os.path.join(os.environ["WARPSCOPE_TEST_ARTIFACTS"], "window-sweeps-point.png"))
        raise Failure("the sweep's point is not in the window")
    os.remove(os.path.join(folder, "window.png"))
    no_sweep = os.path.join(folder, "none.json")
    with open(no_sweep, "w", encoding="utf-8") as file:
        file.write("{}")
    result, is_there = photograph(SCENE, "--front", no_sweep)
    if result.returncode != 1 or is_there or "holds no sweep" not in result.stderr:
        raise Failure(f"a front without rows: exit code {result.returncode}, {result.stderr}")


def size_of_photograph(folder, expected):
    with open(os.path.join(folder, "window.png"), "rb") as file:
        header = file.read(24)  # PNG: signature, length, "IHDR", width, height
    size = (int.from_bytes(header[16:20], "big"), int.from_bytes(header[20:24], "big"))
    if size != expected:
        raise Failure(f"a photograph of {size} pixels instead of {expected}")


def photograph_sizes(folder, photograph):
    """--size is the window's, and refused where the window's parts or the screen have no room for it."""
    result, is_there = photograph(SCENE, "--size", "900x610")
    if result.returncode != 0 or not is_there:
        raise Failure(f"a window of a size: exit code {result.returncode}, {result.stderr}")
    size_of_photograph(folder, (900, 610))
    os.remove(os.path.join(folder, "window.png"))
    for size, reason in (("300x610", "a window of 300x610 is too small: its parts need 640x420"),
                         ("1281x800", "a window of 1281x800 is too large: the screen has 1280x800"),
                         ("20000x800", "--size 20000x800: give WxH, each 1 to 16384")):
        result, is_there = photograph(SCENE, "--size", size)
        if result.returncode != 2 or is_there or reason not in result.stderr:
            raise Failure(f"a window of {size}: exit code {result.returncode}, {result.stderr}")


def photograph_scenes(display, executable):
    """The program closes by itself after a photograph, and without one where there is nothing to photograph."""
    with tempfile.TemporaryDirectory() as folder:
        report = os.path.join(folder, "report.json")

        def photograph(scene, *more):
            file = os.path.join(folder, "window.png")
            result = subprocess.run([executable, "view", *scene, *more, "--screenshot", file, "--after-ms", "4000", "--report", report, "--link", "4g"],
                                    env=display.environment, capture_output=True, text=True, timeout=PATIENCE_S, check=False)
            return result, os.path.exists(file)

        result, is_there = photograph(SCENE)
        if result.returncode != 0 or not is_there:
            raise Failure(f"a photograph: exit code {result.returncode}, {result.stderr}")
        size_of_photograph(folder, (1280, 800))
        os.remove(os.path.join(folder, "window.png"))
        with open(report, encoding="utf-8") as text:
            figures = json.load(text)
        if not figures["server"]["isConnected"] or figures["framesReceived"] < 1 or figures["panels"][1]["wireMs"] < 30.0:  # of about 50
            raise Failure(f"a report that cannot be: {figures}")
        for key in ("flip", "psnrDb", "holeFraction"):  # null where the machine was too slow to find out
            if key not in figures["panels"][1]:
                raise Failure(f"a report without {key}: {figures}")
        photograph_sizes(folder, photograph)
        photograph_a_sweep(folder, executable, photograph)
        broken = os.path.join(folder, "broken_9x9x9_uint8.raw")
        with open(broken, "wb") as file:
            file.write(b"x")
        result, is_there = photograph([broken])
        if result.returncode != 1 or is_there or "broken_9x9x9_uint8.raw: holds 1 bytes" not in result.stderr:
            raise Failure(f"a photograph of a scene that cannot be opened: exit code {result.returncode}, {result.stderr}")


def close_at_any_moment(executable):
    with Display(1280, 800) as display:
        program = Program(display, [executable, "view", *SCENE])
        program.find_window()
        x_client.press_close_button(display.name, program.window)
        print(f"  close button: {program.ends('close button'):.2f} s")

        program = Program(display, [executable, "view", "vessels", "--volume-size", "500x500x500"])
        program.find_window()
        time.sleep(1.0)
        program.process.send_signal(signal.SIGTERM)
        print(f"  during a long load: {program.ends('a signal during a long load'):.2f} s")

        # A resolver that hangs, as one without a network does.
        if slow_lookup := os.environ.get("WARPSCOPE_SLOW_LOOKUP"):
            program = Program(display, ["env", f"LD_PRELOAD={slow_lookup}", executable, "view", "--connect", "warp://slow.name:1"])
            program.find_window()
            time.sleep(0.5)
            x_client.press_close_button(display.name, program.window)
            seconds = program.ends("close button during a lookup", expected="looking up slow.name")
            print(f"  during a lookup: {seconds:.2f} s")

        photograph_scenes(display, executable)

        moments = random.Random(1)
        slowest = 0.0
        for i in range(20):
            program = Program(display, [executable, "view"] + (SCENE if i % 2 else ["vessels"]))
            begin_catching_signals(program)
            moment = moments.uniform(0.0, 0.5)
            time.sleep(moment)
            program.process.send_signal(signal.SIGINT if i % 3 == 0 else signal.SIGTERM)
            slowest = max(slowest, program.ends(f"a signal {moment:.3f} s after the start"))
        print(f"  signals: {slowest:.2f} s at most")


def main():
    executable, parts = sys.argv[1], sys.argv[2:] or ["1x", "2x", "closing"]
    missing = [tool for tool in ("Xvfb", "xdotool", "import", "xrdb") if shutil.which(tool) is None]
    if missing:
        print("skipped: not installed: " + " ".join(missing))
        return SKIPPED
    try:
        for part in parts:
            print(part)
            if part == "closing":
                close_at_any_moment(executable)
            else:
                use_the_window(executable, 2.0 if part == "2x" else 1.0)
    except Failure as failure:
        print(failure)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
