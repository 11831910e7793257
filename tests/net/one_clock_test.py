#!/usr/bin/env python3
"""Nothing in net/ asks for the time or waits but by the clock that it was handed. Usage: one_clock_test.py SOURCES.

net/timer.* is the one place that knows Asio's timers; see net/timer.h."""
import pathlib
import re
import sys

OTHER_WAYS = re.compile(r"\b(steady_clock|system_clock|high_resolution_clock|steady_timer|system_timer|deadline_timer|sleep_for|sleep_until"
                        r"|wait_for|wait_until|usleep|nanosleep|clock_gettime|gettimeofday)\b")


def main() -> int:
    room = pathlib.Path(sys.argv[1]) / "net"
    sources = [path for path in sorted(room.iterdir()) if path.suffix in (".h", ".cpp")]
    found = 0
    for path in sources:
        if path.stem == "timer":
            continue
        for number, line in enumerate(path.read_text().splitlines(), 1):
            if match := OTHER_WAYS.search(line.split("//")[0]):
                print(f"{path}:{number}: {match.group()}: time is clockOf(executor)'s or IoThread::clock()'s, waiting is net/timer.h's")
                found += 1
    if not sources or "steady_timer" not in (room / "timer.cpp").read_text():
        print(f"{room} is not the room that this test knows")
        return 1
    return 1 if found else 0


if __name__ == "__main__":
    sys.exit(main())
