"""Timing shared by the peer measurements."""

import json
import statistics
import sys
import time

WARM_UP = 2


def run_once(action, i):
    """Seconds of `action(i)`: wall clock, and processor time of all threads together."""
    start, cpu_start = time.perf_counter(), time.process_time()
    action(i)
    return time.perf_counter() - start, time.process_time() - cpu_start


def measure(action, repeats):
    """Seconds of `action(i)`: wall clock of every run, the smallest and the median, after warm-up runs that do not count.

    `cpu_min_s` is the smallest processor time of a run, all threads together; divided by the threads it says what a busy
    machine hides.
    """
    for i in range(WARM_UP):
        action(i)
    runs = [run_once(action, WARM_UP + i) for i in range(repeats)]
    seconds, cpu_seconds = zip(*runs)
    return {"min_s": min(seconds), "median_s": statistics.median(seconds), "cpu_min_s": min(cpu_seconds), "runs_s": seconds}


def serve(about, action):
    """Prints the line `about`, warmed up; then runs `action` once for every line that comes in, and prints its seconds.

    Who asks sets the pace, and so can alternate this with runs of its own.
    """
    for i in range(WARM_UP):
        action(i)
    print(json.dumps(about), flush=True)
    for i, _ in enumerate(sys.stdin):
        wall_s, cpu_s = run_once(action, i)
        print(json.dumps({"wall_s": wall_s, "cpu_s": cpu_s}), flush=True)
