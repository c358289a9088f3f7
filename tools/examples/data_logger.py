"""Writes every actual value telegram of every slave as a line of CSV to standard output.

Usage: data_logger.py DOMAIN BUS LINES        Exit code: 0 done, 1 failed, 2 wrong usage, 130 Ctrl-C
"""

import csv
import sys

import cansync


def main(domain, bus, lines):
    output = csv.writer(sys.stdout, lineterminator="\n")
    output.writerow(["receive_time_ns", "slave", "telegrams", "interval_1", "interval_2", *(f"value_{n}" for n in range(8))])
    with cansync.connect(bus, domain=domain, name="data logger") as line, line.follow(cansync.ActualValues) as stream:
        for _, values in zip(range(lines), stream):
            output.writerow([values.receive_time, values.slave, values.arrived, *values.interval, *values.scaled])
        if stream.dropped:
            print(f"{stream.dropped} telegrams lost: the output was too slow", file=sys.stderr)


if __name__ == "__main__":
    if len(sys.argv) != 4:
        sys.exit(print(__doc__, file=sys.stderr) or 2)
    try:
        main(int(sys.argv[1]), sys.argv[2], int(sys.argv[3]))
    except cansync.Error as error:
        sys.exit(f"{error}")
    except KeyboardInterrupt:
        sys.exit(130)
