"""Boots a machine with two emulated CAN controllers and runs qemu_guest.py in it.

    run_qemu.py [TEST ...]      arguments go to unittest inside

Exit code: that of the tests; 77 when this machine cannot run them (with the reason), which is an error when
CANSYNC_KERNEL_TESTS is in the environment: CI must not skip.
"""

import os
import shlex
import sys
import tempfile
import time

import qemu_machine

HERE = os.path.dirname(os.path.abspath(__file__))
SKIPPED = 77
LIMIT = 600  # seconds for boot and tests together


def main():
    variables = {}
    for name in ("CANSYNC", "CANSYNCD", "CANSYNC_SIM"):
        if not os.path.exists(os.environ.get(name, "")):
            sys.exit(f"run_qemu.py: {name} must be the path of that program; `ctest -L kernel` sets it")
        variables[name] = os.path.abspath(os.environ[name])
    command = "ip route add 224.0.0.0/4 dev lo\n"
    command += "".join(f"export {name}={shlex.quote(value)}\n" for name, value in variables.items())
    inside = [sys.executable, "-B", os.path.join(HERE, "qemu_guest.py"), *sys.argv[1:]]
    command += shlex.join(inside) + "\n"
    begin = time.monotonic()
    try:
        with tempfile.TemporaryDirectory(prefix="cansync_qemu_") as shared:
            code = qemu_machine.run(command, shared, LIMIT, lambda line: print(f"{time.monotonic() - begin:6.1f} {line}", flush=True))
    except qemu_machine.Missing as reason:
        required = "CANSYNC_KERNEL_TESTS" in os.environ
        print(f"{'cannot run, but CANSYNC_KERNEL_TESTS is set' if required else 'skipped'}: {reason}")
        sys.exit(1 if required else SKIPPED)
    if code is None:
        sys.exit(f"run_qemu.py: the machine ended without a result, or not within {LIMIT} s")
    sys.exit(code)


main()
