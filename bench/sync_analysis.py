"""What a row of SYNC instants says: deviation from the interval, phase against the ideal grid, skipped slots."""

import statistics


def steps(times, interval):
    """(nanoseconds, whole intervals) from each instant to the next."""
    return [(later - earlier, max(round((later - earlier) / interval), 1)) for earlier, later in zip(times, times[1:])]


def deviations(times, interval):
    """How far each step is from so many whole intervals, in ns."""
    return [abs(length - count * interval) for length, count in steps(times, interval)]


def skipped(times, interval):
    """Slots without an instant."""
    return sum(count - 1 for _, count in steps(times, interval))


def shortest(times):
    """The shortest step in ns."""
    return min(later - earlier for earlier, later in zip(times, times[1:]))


def phase_growth(times, interval):
    """How much the phase against the ideal grid has moved from the first tenth to the last, in ns.

    The grid has the given interval and begins with the first instant; slots without an instant count as passed.
    """
    phases, slot = [0], 0
    for at, (_, count) in zip(times[1:], steps(times, interval)):
        slot += count
        phases.append(at - times[0] - slot * interval)
    tenth = max(len(phases) // 10, 1)
    return statistics.median(phases[-tenth:]) - statistics.median(phases[:tenth])


def bunched(times, interval):
    """Instants that follow on another one within half an interval: two SYNC in one slot."""
    return sum(length < interval / 2 for length, _ in steps(times, interval))
