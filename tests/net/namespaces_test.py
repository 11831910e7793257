#!/usr/bin/env python3
# A server and a window on two machines, as far as one machine can be two: network namespaces joined by a link of 20 Mbit/s that is cut.
# ip-netns(8), veth(4), tc-tbf(8). Skipped, visibly, where these or the tools of tests/ui/window_test.py are missing.
"""Usage: namespaces_test.py PROGRAM. Exit codes: 0 passed, 1 failed, 77 skipped."""
import contextlib
import json
import os
import shutil
import subprocess
import sys
import tempfile
import time

sys.path.insert(0, os.path.join(os.path.dirname(os.path.abspath(__file__)), "..", "ui"))
from window_test import SKIPPED, Display, Failure, Picture, Program  # noqa: E402

SERVER_IP, CLIENT_IP = "10.177.1.1", "10.177.1.2"
RATE_BIT_PER_S = 20e6
ROUND_TRIP_MS = 200.0       # simulated, on top of the link's own
SCENE = ["vessels", "--volume-size", "96x96x96"]
# Frames of samples alone: small ones arrive within one round trip, whatever the windows of TCP.
PANELS = ["--left", "points", "--right", "spheres"]
SERVER_PATIENCE_S = 10.0    # net/server.h
CLIENT_PATIENCE_S = 10.4    # the server's, and twice the simulated round trip
BANNER = (82, 33, 31)       # kErrorBackground of app/ui/theme.h
# A machine that others use as well draws seldom and answers late. A window whose server is its own, without a link, shows how much of that
# is due to the machine: the attached one has to draw at least half as often.
LEAST_SHARE_OF_RATE = 0.5
SLACK_MS = 150.0            # beyond what link and transfer explain
ATTEMPTS = 3                # how busy the others are changes meanwhile


class Skip(Exception):
    pass


def require(command):
    result = subprocess.run(command, capture_output=True, text=True, check=False)
    if result.returncode != 0:
        raise Skip(f"'{' '.join(command)}' failed: {result.stderr.strip()}")


class TwoMachines:
    """Two network namespaces and the cable between them."""

    def __init__(self):
        self.server, self.client = f"warpscope-s{os.getpid()}", f"warpscope-c{os.getpid()}"
        self.server_end, self.client_end = f"wss{os.getpid()}", f"wsc{os.getpid()}"

    def __enter__(self):
        try:
            for name in (self.server, self.client):
                require(["ip", "netns", "add", name])
                require(["ip", "-n", name, "link", "set", "lo", "up"])
            require(["ip", "link", "add", self.server_end, "netns", self.server, "type", "veth", "peer", "name", self.client_end,
                     "netns", self.client])
            for name, end, address in ((self.server, self.server_end, SERVER_IP), (self.client, self.client_end, CLIENT_IP)):
                require(["ip", "-n", name, "address", "add", f"{address}/24", "dev", end])
                require(["ip", "-n", name, "link", "set", end, "up"])
                require(["tc", "-n", name, "qdisc", "add", "dev", end, "root", "tbf", "rate", f"{RATE_BIT_PER_S:.0f}bit", "burst", "16000",
                         "limit", "250000"])
        except Skip:
            self.__exit__()
            raise
        return self

    def __exit__(self, *_):
        for name in (self.server, self.client):  # the cable goes with them
            subprocess.run(["ip", "netns", "del", name], capture_output=True, check=False)

    def cut(self, is_cut=True):
        require(["ip", "-n", self.client, "link", "set", self.client_end, "down" if is_cut else "up"])

    @staticmethod
    def on(name, command):
        return ["ip", "netns", "exec", name, *command]


class Server:
    """`serve` in its namespace."""

    def __init__(self, machines, executable, folder):
        self.log = os.path.join(folder, "server.log")
        port_file = os.path.join(folder, "port")
        command = [executable, "serve", *SCENE, "--listen", f"{SERVER_IP}:0", "--port-file", port_file, "--verbose"]
        with open(self.log, "wb") as log:
            self.process = subprocess.Popen(machines.on(machines.server, command), stdout=subprocess.PIPE, stderr=log,
                                            env=dict(os.environ, HOME=folder, XDG_DATA_HOME=""))
        wait_until("the server's port", lambda: os.path.exists(port_file), 30.0)
        self.url = self.process.stdout.readline().decode().strip()
        if not self.url.startswith(f"warps://{SERVER_IP}:"):
            raise Failure(f"the server beyond loopback is at {self.url}")

    def said(self):
        with open(self.log, encoding="utf-8") as log:
            return log.read()

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.process.terminate()
        if self.process.wait() != 0 and sys.exc_info()[0] is None:
            raise Failure(f"the server ended with {self.process.returncode}: {self.said()}")


def wait_until(what, condition, patience_s):
    begin = time.monotonic()
    while time.monotonic() < begin + patience_s:
        if condition():
            return time.monotonic() - begin
        time.sleep(0.05)
    raise Failure(f"after {patience_s:.0f} s: not {what}")


def keep(file):
    folder = os.environ.get("WARPSCOPE_TEST_ARTIFACTS")
    if folder:
        shutil.copy(file, folder)


def take_the_same_picture(machines, executable, server, folder):
    """A picture over the link is the local one, and takes at least as long as its bytes."""
    shot = ["shot", "--size", "512x512", "--view-angle", "20", "--quiet"]
    local, remote = os.path.join(folder, "local.png"), os.path.join(folder, "remote.png")
    subprocess.run([executable, shot[0], *SCENE, *shot[1:], "-o", local], check=True)
    begin = time.monotonic()
    subprocess.run(machines.on(machines.client, [executable, *shot, "--connect", server.url, "-o", remote]), check=True)
    seconds = time.monotonic() - begin
    with open(local, "rb") as one, open(remote, "rb") as other:
        if one.read() != other.read():
            raise Failure("the picture over the link is not the local one")
    print(f"  shot: the local picture, byte for byte, in {seconds:.2f} s")


def swing(program, seconds):
    """Moves the pointer with the button held, to and fro, 50 times a second."""
    begin = time.monotonic()
    turns = 0
    program.point(program.middle_of_panel(1))
    program.display.run("xdotool", "mousedown", "1")
    while time.monotonic() < begin + seconds:
        step = "3" if turns % 2 == 0 else "-3"
        program.display.run("xdotool", *(["mousemove_relative", "--", step, "0", "sleep", "0.02"] * 25))
        turns += 1
    program.display.run("xdotool", "mouseup", "1")


def open_window(display, command):
    program = Program(display, command)
    program.find_window()
    program.wait_until("both panels show the vessels", lambda: all(shows_vessels(region) for region in program.regions()))
    return program


def shows_vessels(region):
    """True if a hundredth of the pixels are of their red; texts are grey."""
    pixels = [region[i:i + 3] for i in range(0, len(region), 3 * 7)]
    return sum(pixel[0] > 90 and pixel[0] > 1.5 * pixel[1] for pixel in pixels) > 0.01 * len(pixels)


def attached(machines, executable, server, *more):
    return machines.on(machines.client, [executable, "view", *PANELS, "--connect", server.url, "--link", f"delay={ROUND_TRIP_MS / 2:.0f}", *more])


def has_banner(program):
    picture = Picture.of_window(program.display, program.window)
    row = picture.region((20, picture.height - 70, picture.width // 2, picture.height - 69))  # at the panels' lower edge, above the sentence
    pixels = [tuple(row[i:i + 3]) for i in range(0, len(row), 3)]
    near = sum(all(abs(channel - wanted) <= 12 for channel, wanted in zip(pixel, BANNER)) for pixel in pixels)
    return near > len(pixels) // 3


def report_of(file):
    with open(file, encoding="utf-8") as text:
        return json.load(text)


def figures_of(display, command, folder, name):
    """What a window reports whose camera moves for five seconds."""
    screenshot, report = os.path.join(folder, name + ".png"), os.path.join(folder, name + ".json")
    program = open_window(display, [*command, "--screenshot", screenshot, "--after-ms", "14000", "--report", report])
    if has_banner(program):
        raise Failure("the window complains although it is connected")
    swing(program, 5.0)
    # The last frame is one that nothing else competes with, ground truth for counting holes included: what the wire took is the link's.
    time.sleep(2.0)
    program.drag(program.middle_of_panel(1), 1, [(20, 6)])
    code = program.process.wait(timeout=30.0)
    if code != 0:
        raise Failure(f"the window ended with {code}: {program.output()}")
    keep(screenshot)
    keep(report)
    figures = report_of(report)
    panel = figures["panels"][1]
    print(f"  {name}: display {figures['framesPerSecond']:.1f} frames/s, gaps {figures['gapMs']['median']:.0f} ms (median), "
          f"{figures['gapMs']['longest']:.0f} ms (longest); {figures['framesReceived']} frames received")
    print(f"    last frame: {panel['bytes']} bytes, wire {panel['wireMs']:.0f} ms, all stages {total_ms(panel):.0f} ms; "
          f"age while moving {figures['ageMs']['median']:.0f} ms (median), {figures['ageMs']['longest']:.0f} ms (longest)", flush=True)
    return figures


def total_ms(panel):
    return sum(panel[stage] for stage in panel if stage.endswith("Ms"))


def require_figures(local, remote):
    """The display does not wait for the network, and the timeline accounts for the link."""
    panel = remote["panels"][1]
    transfer_ms = panel["bytes"] * 8 / RATE_BIT_PER_S * 1e3
    if remote["framesPerSecond"] < LEAST_SHARE_OF_RATE * local["framesPerSecond"]:
        raise Failure(f"the window drew {remote['framesPerSecond']:.1f} times a second, without a link {local['framesPerSecond']:.1f} times")
    if not ROUND_TRIP_MS <= panel["wireMs"] <= ROUND_TRIP_MS + transfer_ms + SLACK_MS:
        raise Failure(f"the wire took {panel['wireMs']:.0f} ms for {ROUND_TRIP_MS:.0f} ms there and back and {transfer_ms:.0f} ms of bytes")
    # While the camera moves, a frame on show is as old as its way took, and the next one's way longer when that has come.
    if not ROUND_TRIP_MS <= remote["ageMs"]["median"] <= 3.0 * (ROUND_TRIP_MS + transfer_ms) + local["ageMs"]["longest"]:
        raise Failure(f"the frames on show were {remote['ageMs']['median']:.0f} ms old")
    if remote["framesReceived"] < 3:
        raise Failure(f"{remote['framesReceived']} frames came")


def move_the_camera(machines, executable, display, server, folder):
    for attempt in range(1, ATTEMPTS + 1):
        local = figures_of(display, [executable, "view", *PANELS, *SCENE], folder, "local")
        remote = figures_of(display, attached(machines, executable, server), folder, "attached")
        try:
            require_figures(local, remote)
            return
        except Failure as failure:
            if attempt == ATTEMPTS:
                raise
            print(f"  once more: {failure}")


def cut_the_link(machines, executable, display, server, folder):
    report = os.path.join(folder, "cut.json")
    program = open_window(display, attached(machines, executable, server, "--report", report))
    before = server.said()
    machines.cut()
    cut_at = time.monotonic()
    still = program.settled()
    program.drag(program.middle_of_panel(1), 1, [(20, 6)] * 4)
    program.changed(still, "both panels follow the camera without the server")
    wait_until("a sentence about the connection", lambda: has_banner(program), CLIENT_PATIENCE_S + 5.0)
    print(f"  the window said so {time.monotonic() - cut_at:.1f} s after the cut")
    wait_until("the server has dropped the client", lambda: server.said().count(" left") >= server.said().count(" connected"),
               SERVER_PATIENCE_S + 5.0)
    print(f"  the server had dropped both connections {time.monotonic() - cut_at:.1f} s after the cut")
    still = program.settled()
    program.drag(program.middle_of_panel(1), 1, [(-15, 6)] * 4)
    program.changed(still, "both panels follow the camera beneath the sentence")
    picture = os.path.join(folder, "cut.png")
    display.run("import", "-silent", "-window", program.window, picture)
    keep(picture)

    machines.cut(False)
    up_at = time.monotonic()
    wait_until("the sentence gone", lambda: not has_banner(program), 20.0)
    print(f"  connected again {time.monotonic() - up_at:.1f} s after the link was back")
    if server.said().count(" connected") <= before.count(" connected"):
        raise Failure("the sentence is gone, but nobody connected")
    swing(program, 2.0)
    program.settled()
    picture = os.path.join(folder, "again.png")
    display.run("import", "-silent", "-window", program.window, picture)
    keep(picture)
    program.key("ctrl+q")
    program.ends("Ctrl-Q")
    figures = report_of(report)
    if not figures["server"]["isConnected"] or figures["lastFrameAgeMs"] > 10e3:
        raise Failure(f"no frames came again: {figures}")


def main():
    executable = os.path.abspath(sys.argv[1])
    missing = [tool for tool in ("ip", "tc", "Xvfb", "xdotool", "import", "xrdb") if shutil.which(tool) is None]
    if missing:
        print("skipped: not installed: " + " ".join(missing))
        return SKIPPED
    if os.geteuid() != 0:
        print("skipped: network namespaces take root")
        return SKIPPED
    try:
        with contextlib.ExitStack() as stack:
            folder = stack.enter_context(tempfile.TemporaryDirectory())
            machines = stack.enter_context(TwoMachines())
            display = stack.enter_context(Display(1280, 800))
            server = stack.enter_context(Server(machines, executable, folder))
            for part in (take_the_same_picture, move_the_camera, cut_the_link):
                print(part.__name__.replace("_", " "), flush=True)
                if part is take_the_same_picture:
                    part(machines, executable, server, folder)
                else:
                    part(machines, executable, display, server, folder)
    except Skip as reason:
        print(f"skipped: {reason}")
        return SKIPPED
    except Failure as failure:
        print(failure)
        return 1
    return 0


if __name__ == "__main__":
    sys.exit(main())
