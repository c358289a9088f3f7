"""What a row of SYNC instants says: deviation from the interval, phase against the ideal grid, skipped slots."""

import statistics

REMEMBERED = 9  # instants whose phase tells that of the next


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


def phases(times, interval):
    """How far each instant is from the ideal grid, in ns.

    The grid has the given interval and begins with the first instant. An instant belongs to the slot that is nearest by the
    phase of those before it, so that one that is late by more than half an interval changes nothing for those behind it.
    """
    found = []
    for at in times:
        expected = times[0] + (statistics.median(found[-REMEMBERED:]) if found else 0)
        found.append(at - times[0] - round((at - expected) / interval) * interval)
    return found


def phase_growth(times, interval):
    """How much the phase against the ideal grid has moved from the first tenth to the last, in ns."""
    found = phases(times, interval)
    tenth = max(len(found) // 10, 1)
    return statistics.median(found[-tenth:]) - statistics.median(found[:tenth])


def bunched(times, interval):
    """Instants that follow on another one within half an interval: two SYNC in one slot."""
    return sum(length < interval / 2 for length, _ in steps(times, interval))
