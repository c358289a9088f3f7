"""The kernels of these tests run before whatever else runs on the machine, or they miss their slots."""

import contextlib
import os

NICE = -15


def prefer():
    """This process and what it starts; it leads a session of its own. Without the right to do it nothing changes."""
    with contextlib.suppress(OSError):
        os.nice(NICE)
    # Where the kernel shares the processors out among sessions, a process's nice value counts within its session alone.
    with contextlib.suppress(OSError), open("/proc/self/autogroup", "w", encoding="ascii") as group:
        group.write(str(NICE))
