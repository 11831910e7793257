#!/usr/bin/env python3
# What the real window does while its own server marches: pictures of the display a second, and milliseconds of a march, camera moving.
# Xvfb and llvmpipe, a pointer that drags in circles (xdotool); figures are `view --report`'s. A measurement, not a test.
"""Usage: window_bench.py [--scene NAME] [--size WxH] [--left T] [--right T] [--seconds N] [--runs N] [--rest S] [--open FILE]... [--handled | --vanishing]
                       PROGRAM... [-- OPTION...]

Of each program, in turns: framesPerSecond and the longest gap of the display, pictures a second of both panels, median and longest march, frames of the
window's own thread over 33 ms; of all cores' time, what the host of a virtual machine kept for others (steal, proc(5)), and of frames over 33 ms how
many are so without what was kept of one core meanwhile.
--rest S: the pointer rests every second for S seconds.
--handled: it is also resized, files are opened (--open, and built-in scenes), the transfer function is dragged, errors are measured.
--vanishing: its server is another process, which is killed and comes back, twice. It stands for one elsewhere: it has what the window leaves of the cores (nice 19).
What follows -- is for every program's `view`."""
import argparse
import json
import math
import os
import re
import subprocess
import sys
import tempfile
import threading
import time
import types

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "ui"))
import window_test as ui  # noqa: E402

PERIOD_S = 4.0       # of a circle of the pointer
RADIUS_PX = 60
LIMIT_MS = 33.0      # of a frame that a hand would feel (window_report.cpp)
STEP_S = 0.008       # between two moves of the pointer: twice as often as the display draws
OPENING_S = 3.0      # for the scene, before the pointer moves
OPEN_FIELD, CURVE = (186, 91), (100, 180)  # px from the window's right and upper edge, at scale 1: where a file is named, the transfer function


def circle(seconds, rest_s):
    """One command of xdotool that drags for so long."""
    command = ["xdotool", "mousedown", "1"]
    before, passed = (RADIUS_PX, 0), 0.0
    while passed < seconds:
        passed += STEP_S
        angle = 2.0 * math.pi * passed / PERIOD_S
        now = (round(RADIUS_PX * math.cos(angle)), round(RADIUS_PX * math.sin(angle)))
        if now != before:
            command += ["mousemove_relative", "--", str(now[0] - before[0]), str(now[1] - before[1])]
        before = now
        isSecondOver = int(passed) != int(passed - STEP_S)
        command += ["sleep", str(rest_s if rest_s > 0.0 and isSecondOver else STEP_S)]
    return command + ["mouseup", "1"]


def size_of(arguments):
    return tuple(int(length) for length in arguments.size.split("x"))


def drag(display, window, arguments):
    # By the window's size alone: a look at it would keep the display's server from showing frames, for longer than one of them may take.
    left, top, right, bottom = window.panels(types.SimpleNamespace(width=size_of(arguments)[0], height=size_of(arguments)[1]))[0]
    window.point(((left + right) // 2, (top + bottom) // 2))
    display.run(*circle(arguments.seconds, arguments.rest))


def handle(display, window, arguments):
    """What people do with it one after another, dragging in between."""
    width, height = size_of(arguments)
    for location in [*arguments.open, "vessels", arguments.scene]:
        window.point((width - OPEN_FIELD[0], OPEN_FIELD[1]))
        display.run("xdotool", "click", "1", "key", "ctrl+a", "type", "--delay", "20", location)
        display.run("xdotool", "key", "Return")
        drag(display, window, arguments)
    for step in (60, 120, 40, 200, 20, 0):
        display.run("xdotool", "windowsize", "--sync", window.window, str(width + step), str(height + step // 2))
        time.sleep(0.4)
    drag(display, window, arguments)
    window.point((width - CURVE[0], CURVE[1]))
    display.run("xdotool", "mousedown", "1", *(["mousemove_relative", "--", "2", "1", "sleep", "0.05"] * 20),
                *(["mousemove_relative", "--", "-2", "-1", "sleep", "0.05"] * 20), "mouseup", "1")
    window.key("m")
    time.sleep(4.0)
    drag(display, window, arguments)


def vanish(display, window, arguments, serve):
    """The server goes while the picture is dragged, and comes back."""
    for _ in range(2):
        drag(display, window, arguments)
        serve.kill()
        drag(display, window, arguments)
        serve.start()
        drag(display, window, arguments)


class Server:
    """One that can be killed and started again, on the port that it was given first."""

    def __init__(self, command, folder):
        self.command, self.process, self.port = command, None, 0
        self.port_file = os.path.join(folder, "port")

    def start(self):
        if os.path.exists(self.port_file):
            os.remove(self.port_file)
        self.process = subprocess.Popen(["nice", "-n", "19", *self.command, "--listen", f"127.0.0.1:{self.port}", "--port-file", self.port_file], stdout=subprocess.DEVNULL)
        while not os.path.exists(self.port_file):
            if self.process.poll() is not None:
                raise ui.Failure(f"the server ended with {self.process.returncode}")
            time.sleep(0.01)
        with open(self.port_file, encoding="utf-8") as file:
            self.port = int(file.read())

    def kill(self):
        self.process.kill()
        self.process.wait()


def measured(program, arguments, view_options):
    with tempfile.TemporaryDirectory() as folder, ui.Display(1480, 1124) as display:
        report = os.path.join(folder, "report.json")
        place = [arguments.scene]
        serve = Server([program, "serve", arguments.scene, "--quiet"], folder)
        if arguments.vanishing:
            serve.start()
            place = ["--connect", f"warp://127.0.0.1:{serve.port}"]
        window = ui.Program(display, [program, "view", *place, "--left", arguments.left, "--right", arguments.right, "--size", arguments.size,
                                      "--report", report, *view_options])
        try:
            window.find_window()
            time.sleep(OPENING_S)
            if arguments.handled:
                handle(display, window, arguments)
            elif arguments.vanishing:
                vanish(display, window, arguments, serve)
            else:
                drag(display, window, arguments)
            window.key("ctrl+q")
            window.process.wait(timeout=30)
        finally:
            if serve.process:
                serve.kill()
        with open(report, encoding="utf-8") as file:
            return json.load(file)


def stolen_s():
    """Seconds that each of a virtual machine's cores has been kept waiting by its host, since it started."""
    tick_s = 1.0 / os.sysconf("SC_CLK_TCK")
    with open("/proc/stat", encoding="ascii") as file:
        cores = [line.split() for line in file if re.match(r"cpu\d", line)]
    return [int(core[8]) * tick_s if len(core) > 8 else 0.0 for core in cores]


class Thief:
    """What the host kept of the cores, ever since it is watched: seconds of the monotonic clock, and each core's stolen seconds until then."""

    PERIOD_S = 0.01  # the system counts no finer

    def __enter__(self):
        self.seen, self.over = [(time.monotonic(), stolen_s())], threading.Event()
        self.thread = threading.Thread(target=self.watch)
        self.thread.start()
        return self

    def __exit__(self, *_):
        self.over.set()
        self.thread.join()

    def watch(self):
        while not self.over.wait(self.PERIOD_S):
            self.seen.append((time.monotonic(), stolen_s()))

    def between(self, begin_s, end_s):
        """Of each core, s; ticks of the system that were under way at either end are counted."""
        before = [stolen for at, stolen in self.seen if at <= begin_s - self.PERIOD_S] or [self.seen[0][1]]
        after = [stolen for at, stolen in self.seen if at >= end_s + self.PERIOD_S] or [self.seen[-1][1]]
        return [end - begin for begin, end in zip(before[-1], after[0])]

    def share(self):
        """Of all cores' time."""
        begin_s, end_s = self.seen[0][0], self.seen[-1][0]
        return sum(self.between(begin_s, end_s)) / ((end_s - begin_s) * len(self.seen[0][1]))


def hitches_of(frames, thief):
    """Each with what was stolen of each core while it lasted."""
    for hitch in frames["hitches"]:
        lasted_ms = hitch["sessionMs"] + hitch["widgetsMs"] + hitch["openGlMs"]
        yield {**hitch, "lastedMs": lasted_ms, "stolenMs": [round(1e3 * lost_s) for lost_s in thief.between(hitch["endedS"] - 1e-3 * lasted_ms, hitch["endedS"])]}


def main():
    own, view_options = sys.argv[1:], []
    if "--" in own:
        own, view_options = own[:own.index("--")], own[own.index("--") + 1:]
    parser = argparse.ArgumentParser()
    parser.add_argument("--scene", default="vessels")
    parser.add_argument("--size", default="800x600")
    parser.add_argument("--left", default="spheres")
    parser.add_argument("--right", default="splats")
    parser.add_argument("--seconds", type=float, default=8.0)
    parser.add_argument("--runs", type=int, default=3)
    parser.add_argument("--rest", type=float, default=0.0)
    parser.add_argument("--open", action="append", default=[])
    parser.add_argument("--handled", action="store_true")
    parser.add_argument("--vanishing", action="store_true")
    parser.add_argument("programs", nargs="+")
    arguments = parser.parse_args(own)
    for run in range(arguments.runs):
        for program in arguments.programs:
            with Thief() as thief:
                figures = measured(program, arguments, view_options)
            hitches = list(hitches_of(figures["threadFrames"], thief))
            # Of the core that lost most: two that lose at once delay a frame by no more.
            unstolen = [hitch for hitch in hitches if hitch["lastedMs"] - max(hitch["stolenMs"]) > LIMIT_MS]
            marches = figures.get("movingMarchMs") or {}
            pictures = figures.get("picturesPerSecond") or []
            print(f"{run} {program}: display {figures['framesPerSecond']:.1f}/s, longest gap {figures['gapMs']['longest']:.0f} ms; "
                  f"panels {', '.join(f'{rate:.1f}' for rate in pictures)}/s; march {marches.get('median', float('nan')):.0f} ms, "
                  f"longest {marches.get('longest', float('nan')):.0f}; frames {figures['framesReceived']}; "
                  f"age {(figures['ageMs'] or {}).get('median', float('nan')):.0f} ms; "
                  f"thread {figures['threadMs']['median']:.1f} ms, longest {figures['threadMs']['longest']:.0f}, "
                  f"{len(hitches)} of {figures['threadFrames']['all']} over {LIMIT_MS:.0f} ms, {len(unstolen)} without what was stolen; stolen {100.0 * thief.share():.1f} %", flush=True)
            for hitch in hitches:
                print("    " + ", ".join(f"{name} {value:.3f}" if isinstance(value, float) else f"{name} {value}" for name, value in hitch.items()))


if __name__ == "__main__":
    main()
