"""A local drive behind a daemon that is a slave, as local_drive.cpp: it follows reference value 0 with a lag, gives its
position as actual value 0, and answers for parameters 1000 (time constant) and 1001 (position, read only).

Usage: local_drive.py DOMAIN BUS SECONDS        Exit code: 0 done, 1 failed, 2 wrong usage, 130 Ctrl-C
"""

import sys
import time

import cansync
from cansync import SlaveEventKind as Kind

TIME_CONSTANT, POSITION = 1000, 1001
NOT_CHANGEABLE = 0xFFFC


class Drive:
    def __init__(self, slave):
        self.slave = slave
        self.position, self.time_constant = 0.0, 4
        self.references = self.jobs = 0

    def take(self, event):
        """One thing that came."""
        if event.kind == Kind.REFERENCES and event.arrived & 1:
            self.references += 1
            self.position += (event.values[0] - self.position) / self.time_constant
            self.slave.release(1, [int(self.position)])
        elif event.kind == Kind.PARAMETER:
            self.answer(event)
        elif event.kind == Kind.PARAMETER_END:
            self.jobs += event.answered

    def answer(self, asked):
        own = asked.number == TIME_CONSTANT
        if asked.write and not own:
            self.slave.refuse(asked, NOT_CHANGEABLE)
            return
        if asked.write:
            self.time_constant = max(1, asked.value)
        self.slave.answer(asked, self.time_constant if own else int(self.position), doubleword=not own)


def main(domain, bus, seconds):
    with cansync.connect_slave(bus, domain=domain, name="local drive") as slave:
        drive = Drive(slave)
        slave.take_over([TIME_CONSTANT, POSITION])
        end = time.monotonic() + seconds
        while (left := end - time.monotonic()) > 0:
            if event := slave.receive(min(left, 0.5)):
                drive.take(event)
        print(f"{drive.references} reference values, {drive.jobs} parameter jobs, position {drive.position:.0f}")


if __name__ == "__main__":
    if len(sys.argv) != 4:
        sys.exit(print(__doc__, file=sys.stderr) or 2)
    try:
        main(int(sys.argv[1]), sys.argv[2], float(sys.argv[3]))
    except cansync.Error as error:
        sys.exit(f"{error}")
    except KeyboardInterrupt:
        sys.exit(130)
