"""Runs inside user-mode-linux as the first process: sets up vcan0, runs the program, leaves its exit code, powers off."""

import ctypes
import os
import shlex
import subprocess
import sys
import traceback

POWER_OFF = 0x4321FEDC
LONG = 90  # seconds; one command


def set_up():
    for module in filter(None, os.environ["MODULE_FILES"].split(":")):
        subprocess.run(["insmod", module], check=True, timeout=LONG)
    subprocess.run(["ip", "link", "set", "lo", "up"], check=True, timeout=LONG)
    subprocess.run(["ip", "route", "add", "224.0.0.0/4", "dev", "lo"], check=True, timeout=LONG)
    subprocess.run(["ip", "link", "add", "dev", "vcan0", "type", "vcan"], check=True, timeout=LONG)
    subprocess.run(["ip", "link", "set", "vcan0", "up"], check=True, timeout=LONG)


def run_program(output):
    command = [sys.executable, "-B", *shlex.split(os.environ["PROGRAM"]), f"{output}/result"]
    return subprocess.run(command, check=False, timeout=int(os.environ["LIMIT"])).returncode


def main():
    code = 1
    try:
        set_up()
        code = run_program(sys.argv[1])
    except BaseException:  # whatever it is, the kernel must end and tell
        traceback.print_exc(file=sys.stdout)
    sys.stdout.flush()
    with open(os.path.join(sys.argv[1], "exit_code"), "w", encoding="ascii") as file:
        file.write(str(code))
    os.sync()
    ctypes.CDLL(None).reboot(POWER_OFF)


main()
