"""A CANsync master that is not ours, with python3-can, after the manuals: in each interval the software SYNC frame, both
reference value telegrams, and a read of a status word.

    other_master.py INTERFACE SECONDS

It says "begun" with its first frame and "ended" after its last one.
"""

import argparse
import time

import can

INTERVAL = 0.008  # seconds, at 125 kbit/s
SYNC = 0x080
REFERENCE_ONE, REFERENCE_TWO, COMMAND = 0x100, 0x180, 0x500
SLAVES = 4
STATUS_WORD = 301


def message(identifier, data=b""):
    return can.Message(arbitration_id=identifier, is_extended_id=False, data=data)


def read_command(slave, parameter):
    """Element 7, its value: `0 eee nnnn`, the number's lower byte, and no sub-slave."""
    return message(COMMAND + slave, bytes([0x70 | parameter >> 8, parameter & 0xFF, 0, 0]))


def main():
    parser = argparse.ArgumentParser()
    parser.add_argument("interface")
    parser.add_argument("seconds", type=float)
    arguments = parser.parse_args()
    bus = can.Bus(interface="socketcan", channel=arguments.interface)
    begin = time.monotonic()
    for number in range(max(1, int(arguments.seconds / INTERVAL))):
        time.sleep(max(0.0, begin + number * INTERVAL - time.monotonic()))
        slave = number % SLAVES
        bus.send(message(SYNC))
        bus.send(message(REFERENCE_ONE + slave, bytes(8)))
        bus.send(message(REFERENCE_TWO + slave, bytes(8)))
        bus.send(read_command(slave, STATUS_WORD))
        if number == 0:
            print("begun", flush=True)
    print("ended", flush=True)
    bus.shutdown()


main()
