"""Timing shared by the peer measurements."""

import statistics
import time


def measure(action, repeats, warm_up=2):
    """Seconds of `action(i)`: wall clock of every run, the smallest and the median, after `warm_up` runs that do not count.

    `cpu_min_s` is the smallest processor time of a run, all threads together; divided by the threads it says what a busy
    machine hides.
    """
    for i in range(warm_up):
        action(i)
    seconds, cpu_seconds = [], []
    for i in range(repeats):
        start, cpu_start = time.perf_counter(), time.process_time()
        action(warm_up + i)
        seconds.append(time.perf_counter() - start)
        cpu_seconds.append(time.process_time() - cpu_start)
    return {"min_s": min(seconds), "median_s": statistics.median(seconds), "cpu_min_s": min(cpu_seconds), "runs_s": seconds}
