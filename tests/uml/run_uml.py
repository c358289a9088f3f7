"""Boots user-mode-linux as an ordinary process and runs a Python program in it, at the speed of this machine: what is
measured on an interface of SocketCAN is measured so. (The tests on a real kernel run in a machine that has a time of its
own, tests/kernel.)

    run_uml.py PROGRAM [ARGUMENT ...]

The program finds an interface vcan0, and the name of a file behind its arguments; what it writes there is copied to
CANSYNC_UML_RESULT. CANSYNC_UML_REGISTERS: the library of uml_registers.c; without it the kernel stops at once on
processors with AMX. CANSYNC_UML_LIMIT: seconds for boot and program together.

Needs Debian's package user-mode-linux, no KVM, no rights. Exit code: that of the program, 77 when this machine cannot
run it (with the reason), 1 when the kernel did not end in order or in time.
"""

import glob
import os
import shlex
import shutil
import signal
import subprocess
import sys
import tempfile

from priority import prefer

SKIPPED = 77
MEMORY = 448  # MiB of the kernel inside
LIMIT = int(os.environ.get("CANSYNC_UML_LIMIT", "1500"))
MODULES = ("net/can/can", "net/can/can-raw", "net/can/can-bcm", "drivers/net/can/dev/can-dev", "drivers/net/can/vcan")
PROGRAMS = ("candump", "ip", "tc", "insmod", "mount")


def skip(reason):
    print(f"skipped: {reason}")
    sys.exit(SKIPPED)


def find_program(name):
    path = shutil.which(name, path=os.environ.get("PATH", "") + ":/usr/sbin:/sbin")
    if path is None:
        skip(f"{name} is missing; tools/install_packages installs it")
    return path


def find_modules():
    """The module files to insert, in this order."""
    for folder in sorted(glob.glob("/usr/lib/uml/modules/*/kernel")):
        files = [f"{folder}/{name}.ko" for name in MODULES]
        if all(map(os.path.exists, files)):
            return files
    skip("no CAN modules in /usr/lib/uml/modules; the package user-mode-linux has them")


def memory_folder():
    """Where the kernel's memory lies: a file that is executed from, best on a tmpfs."""
    for folder in ("/dev/shm", os.environ.get("TMPDIR", "/tmp"), "/tmp", "/var/tmp"):
        try:
            facts = os.statvfs(folder)
        except OSError:
            continue
        room = facts.f_bavail * facts.f_frsize >> 20
        if os.access(folder, os.W_OK) and not facts.f_flag & os.ST_NOEXEC and room > MEMORY:
            return folder
    skip(f"neither /dev/shm nor a temporary folder has {MEMORY} MiB to execute from; set TMPDIR to one that has")


def write_environment(work, modules):
    values = {
        "PYTHON": sys.executable,
        "INSIDE": os.path.join(os.path.dirname(os.path.abspath(__file__)), "inside.py"),
        "PROGRAM": shlex.join([os.path.abspath(sys.argv[1]), *sys.argv[2:]]),
        "MODULE_FILES": ":".join(modules),
        "LIMIT": str(LIMIT),
        "TMPDIR": os.path.join(work, "tmp"),
        "HOME": os.path.join(work, "tmp"),
    }
    for name in ("CANSYNC", "CANSYNCD", "CANSYNC_SIM"):
        if not os.path.exists(os.environ.get(name, "")):
            sys.exit(f"run_uml.py: {name} must be the path of that program")
        values[name] = os.path.abspath(os.environ[name])
    with open(os.path.join(work, "environment"), "w", encoding="utf-8") as file:
        for name, value in values.items():
            file.write(f"export {name}={shlex.quote(value)}\n")


def use_one_processor():
    """For what is started from now on: the kernel and its processes take turns at every system call. On a virtual machine
    waking another processor for that costs much; when the machine is busy the kernel has stood still for seconds."""
    os.sched_setaffinity(0, {max(os.sched_getaffinity(0))})


def boot(work, kernel):
    """Runs the kernel to its end, its console on our output. False: it had to be killed."""
    command = [kernel, f"mem={MEMORY}M", "rootfstype=hostfs", "root=/dev/root", "rootflags=/", "ro", "quiet",
               "con=null", "con0=null,fd:1", "ssl=null", f"uml_dir={work}/uml/", "umid=cansync", f"cansync_work={work}",
               f"init={os.path.dirname(os.path.abspath(__file__))}/init.sh"]
    environment = dict(os.environ, TMPDIR=memory_folder(), LD_PRELOAD=os.environ.get("CANSYNC_UML_REGISTERS", ""))
    use_one_processor()
    # A session of its own: the processes inside are processes here, and all of them must end with it.
    process = subprocess.Popen(command, stdin=subprocess.DEVNULL, env=environment, start_new_session=True,
                               preexec_fn=prefer)
    try:
        process.wait(LIMIT)
        return True
    except subprocess.TimeoutExpired:
        return False
    finally:
        try:
            os.killpg(process.pid, signal.SIGKILL)
        except ProcessLookupError:
            pass
        process.wait(60)  # after SIGKILL


def main():
    if len(sys.argv) < 2:
        sys.exit(__doc__)
    kernel = find_program("linux.uml")
    for program in PROGRAMS:
        find_program(program)
    modules = find_modules()
    with tempfile.TemporaryDirectory(prefix="cansync_uml_") as work:
        for folder in ("tmp", "out", "uml"):
            os.mkdir(os.path.join(work, folder))
        write_environment(work, modules)
        ended = boot(work, kernel)
        try:
            with open(os.path.join(work, "out", "exit_code"), encoding="ascii") as file:
                code = int(file.read())
        except (OSError, ValueError):
            print(f"run_uml.py: {'the kernel ended without a result' if ended else f'not done after {LIMIT} s, killed'}")
            code = 1
        result = os.path.join(work, "out", "result")
        if "CANSYNC_UML_RESULT" in os.environ and os.path.exists(result):
            shutil.copy(result, os.environ["CANSYNC_UML_RESULT"])
    sys.exit(code)


if __name__ == "__main__":
    main()
