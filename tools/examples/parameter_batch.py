"""Reads and writes many parameters of one slave at once: every job is handed over before the first answer is awaited.

Usage: parameter_batch.py DOMAIN BUS SLAVE PARAMETER|PARAMETER=VALUE...
A parameter is a number, with raw values, or a name of the slave's drive profile, with values in its unit.
Exit code: 0 all done, 1 one failed or there is no daemon, 2 wrong usage
"""

import sys

import cansync


def number_or_name(text):
    return int(text, 0) if text[:1].isdigit() else text


def submit(line, slave, item):
    """The job of PARAMETER or PARAMETER=VALUE."""
    parameter, equals, value = item.partition("=")
    if not equals:
        return line.submit_read(slave, number_or_name(parameter))
    return line.submit_write(slave, number_or_name(parameter), float(value) if "." in value else int(value, 0))


def main(domain, bus, slave, items):
    failed = 0
    with cansync.connect(bus, domain=domain, name="parameter batch") as line:
        jobs = []
        for item in items:
            try:
                jobs.append((item, submit(line, number_or_name(slave), item)))
            except cansync.Error as error:  # refused before anything was sent
                failed = 1
                print(f"{item}: {error}")
        for item, job in jobs:
            try:
                value = job.result()
                print(f"{item}: done" if value is None else f"{item} = {value}")
            except cansync.Error as error:
                failed = 1
                print(f"{item}: {error}")
    return failed


if __name__ == "__main__":
    if len(sys.argv) < 5:
        sys.exit(print(__doc__, file=sys.stderr) or 2)
    try:
        sys.exit(main(int(sys.argv[1]), sys.argv[2], sys.argv[3], sys.argv[4:]))
    except cansync.Error as error:
        sys.exit(f"{error}")
