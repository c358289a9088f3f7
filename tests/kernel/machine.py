"""A virtual PC with a Debian kernel, virtual CAN interfaces, and two CAN controllers (SJA1000) on one bus. It has a time of its own.

It runs in QEMU without KVM. Its clock goes on by the instructions it executes, and jumps when it has nothing to do: how fast
the host is, and what else runs there, makes no difference to anything inside. The same run takes the same course again, and
with another seed another one: its kernel draws other random numbers.
What it needs of this computer lies in its memory; it needs no right of its own.
"""

import hashlib
import os
import re
import shlex
import shutil
import subprocess
import threading

import debian_kernel
import memory_root
from debian_kernel import LONG, Missing

QEMU = "qemu-system-x86_64"
MEMORY = 1024  # MiB
# 2^0 ns for each instruction: a processor of 1000 MIPS.
TIME = ["-accel", "tcg,thread=single", "-icount", "shift=0,sleep=off", "-rtc", "base=2026-01-01T00:00:00,clock=vm"]
# Without instructions that copy or clear byte by byte, each byte as one instruction.
CPU = "max,-erms,-fsrm,-la57,-smap,-smep,-umip,-pku"
CONTROLLERS = ["-object", "can-bus,id=bus", "-device", "kvaser_pci,canbus=bus", "-device", "kvaser_pci,canbus=bus"]
# Without norandmaps: every start of a program would have to be translated anew, at twice the time for all.
KERNEL = "console=ttyS0 quiet panic=-1 mitigations=off no_timer_check tsc=reliable clocksource=tsc norandmaps init_on_alloc=0"
ENDED = re.compile(r"exit code (\d+), after (\S+) s of its own")

START = """#!/bin/busybox sh
export PATH=/usr/sbin:/usr/bin:/sbin:/bin HOME=/run TMPDIR=/run/tmp
b=/bin/busybox
$b mount -t proc proc /proc
$b mount -t sysfs sysfs /sys
$b mount -t devtmpfs dev /dev
$b mkdir -p /dev/shm /dev/pts
$b ln -s /proc/self/fd /dev/fd
$b mount -t tmpfs tmpfs /dev/shm
$b mount -t devpts devpts /dev/pts
$b mount -t tmpfs tmpfs /run
$b mkdir -p /run/tmp
$b hostname machine
for module in $($b cat /modules/order); do $b insmod /modules/$module || echo "insmod $module failed"; done
ip link set lo up
ip route add 224.0.0.0/4 dev lo
{environment}
{command}
echo "exit code $?, after $($b cut -d ' ' -f 1 /proc/uptime) s of its own"
$b poweroff -f
"""


def in_courses(run):
    """Exit code of `run(seed)`, None without one, in the course that CANSYNC_SEED in the environment names. Without it in course 1, and
    when something failed there in course 2: a race that one course in many meets does not keep a good commit back. It is not
    forgotten: the file CANSYNC_NOTES gets a line with what `run.name` says. What did not end has had its time."""
    if "CANSYNC_SEED" in os.environ:
        return run(int(os.environ["CANSYNC_SEED"]))
    code = run(1)
    if code in (0, None):
        return code
    name = run.name
    code = run(2)
    if code == 0:
        note(f"failed once, passed in course 2: {name}")
    return code


def note(text):
    """What the last line of tools/test tells, also of a run that passes."""
    if "CANSYNC_NOTES" in os.environ:
        with open(os.environ["CANSYNC_NOTES"], "a", encoding="utf-8") as notes:
            notes.write(f"{text}\n")


def need_qemu():
    """Raises Missing when it is not there."""
    if not shutil.which(QEMU):
        raise Missing(f"{QEMU} is not installed (Debian package qemu-system-x86)")


def run(command, environment, files, limit, show=print, seed=1):
    """Boots, runs `command` with `environment` and our `files`, and shuts down. `limit`: seconds of the host for all of it.

    Returns the command's exit code; None when the machine ended without one. `show` gets each line of the console.
    """
    need_qemu()
    kernel = debian_kernel.fetch()
    variables = "\n".join(f"export {name}={shlex.quote(value)}" for name, value in environment.items())
    start = START.format(environment=variables, command=shlex.join(command))
    return boot(kernel, [memory_root.make(files, kernel.modules, start)], MEMORY, limit, show, seed)


def boot(kernel, archives, memory, limit, show=print, seed=1):
    """Boots `kernel` with the file system of `archives` (cpio, one over the other) in `memory` MiB; as `run` for the rest. What runs
    in it says `exit code CODE, after SECONDS s of its own` on the console."""
    need_qemu()
    content = hashlib.sha256(subprocess.run([QEMU, "--version"], capture_output=True, check=True, timeout=LONG).stdout)
    with open(kernel.image, "rb") as image:
        content.update(image.read())
    # A file without a place in any folder: nothing is left of it, however this program ends.
    with os.fdopen(os.memfd_create("initrd"), "wb") as initrd:
        for archive in archives:
            initrd.write(archive)
            content.update(archive)
        initrd.flush()
        # Two runs of which this line is the same take the same course.
        show(f"machine {content.hexdigest()[:16]}, seed {seed}")
        # It ends with this program, however that ends.
        arguments = ["setpriv", "--pdeathsig", "KILL", QEMU, "-machine", "pc", "-cpu", CPU, "-smp", "1", "-m", str(memory), *TIME, "-seed", str(seed), *CONTROLLERS]
        arguments += ["-nodefaults", "-display", "none", "-serial", "stdio", "-no-reboot"]
        arguments += ["-kernel", kernel.image, "-initrd", f"/proc/self/fd/{initrd.fileno()}", "-append", KERNEL]
        return watch(arguments, initrd.fileno(), limit, show)


def watch(arguments, descriptor, limit, show):
    """Runs QEMU with the open file `descriptor` to its end, or for `limit` seconds; the exit code it told."""
    code = None
    with subprocess.Popen(arguments, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT, pass_fds=[descriptor]) as machine:
        watchdog = threading.Timer(limit, machine.kill)  # also while it is silent
        watchdog.start()
        try:
            for line in machine.stdout:
                text = line.decode(errors="replace").rstrip()
                ended = ENDED.match(text)
                code = int(ended.group(1)) if ended else code
                show(text)
            machine.wait(LONG)
        finally:
            watchdog.cancel()
            machine.kill()
    return code
