"""A first client: reads a parameter, shows ten telegrams of actual values of a slave, gives reference values for two seconds.
IT MOVES EVERY DRIVE of the line that follows: for a simulated line.

Usage: first_client.py DOMAIN BUS SLAVE        Exit code: 0 done, 1 failed, 2 wrong usage
"""

import sys
import time

import cansync


def signed(raw):
    """Values are doublewords without a sign."""
    return raw - (1 << 32) if raw >> 31 else raw


def main(domain, bus, name):
    with cansync.connect(bus, domain=domain, name="first client") as line:
        slave = line.slave(name)
        print(f"parameter 301: 0x{line.read(slave, 301).raw:04X}")

        # They come while somebody gives reference values, or with process.poll_without_reference.
        with line.follow(cansync.ActualValues, timeout=10) as stream:
            mine = (values for values in stream if values.slave == slave)
            for _, values in zip(range(10), mine):
                print(f"value 0: {signed(values.raw[0])}, in its unit: {values.scaled[0]:g}")

        # What a control word means is the drive's matter: this one lets a simulated drive follow, and resets its fault.
        line.control_word(slave, 0x0087)
        before = signed(line.actual_values(slave).raw[0])
        with line.references() as references:  # for all drives of the line
            for _ in range(100):
                # Given every 20 ms, released for 60 intervals (of 1 ms: three times as long): two late ones leave no gap.
                references.give(1, [before + 65536, None, None, None], release_intervals=60)
                time.sleep(0.02)
            print(f"value 0 moved by {signed(line.actual_values(slave).raw[0]) - before}")
        # Given up: a drive that had reference values and gets none any more faults after a while.


if __name__ == "__main__":
    if len(sys.argv) != 4:
        sys.exit(print(__doc__, file=sys.stderr) or 2)
    try:
        main(int(sys.argv[1]), sys.argv[2], sys.argv[3])
    except cansync.Error as error:  # NotConnected says where it looked, and the remedy
        sys.exit(f"{error}")
