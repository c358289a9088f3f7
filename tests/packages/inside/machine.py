"""What the tests inside the booted machine share: running commands, waiting, the service, the configuration."""

import json
import os
import pathlib
import socket
import struct
import subprocess
import time

ACTIVE = 0x80  # w_OPTION_STATUS
LONG = 90  # seconds after which something has certainly gone wrong, also on a loaded machine
INTERFACE = "vcan0"
SERVICE = f"cansyncd@{INTERFACE}.service"
SIMULATOR = f"cansync-sim@{INTERFACE}.service"
CONFIGURATION = pathlib.Path(f"/etc/cansync/{INTERFACE}.toml")
# As the packages that the machine was installed with bring it.
EXAMPLE = pathlib.Path("/usr/share/doc/cansyncd/examples/can0.toml").read_text(encoding="utf-8")
# Of logind, while the line is in run: mode, what.
LOCKS = {("block", "sleep:idle:handle-power-key:handle-suspend-key:handle-hibernate-key:handle-lid-switch"), ("delay", "shutdown")}
ENVIRONMENT = dict(os.environ, CANSYNC_BUS=INTERFACE, SYSTEMD_PAGER="cat", SYSTEMD_COLORS="0", LC_ALL="C.UTF-8",
                   DEBIAN_FRONTEND="noninteractive",
                   NEEDRESTART_SUSPEND="1")  # by apt-get; a test calls it itself


def run(*command, expect=0, timeout=LONG):
    """What the command wrote on both outputs; an error when it ends with another code than `expect` (None: any)."""
    done = subprocess.run([str(part) for part in command], env=ENVIRONMENT, stdin=subprocess.DEVNULL, text=True,
                          stdout=subprocess.PIPE, stderr=subprocess.STDOUT, timeout=timeout, check=False)
    if expect is not None and done.returncode != expect:
        raise AssertionError(f"{' '.join(map(str, command))}: exit code {done.returncode}\n{done.stdout}")
    return done.stdout


def wait_for(what, condition, seconds=LONG):
    """The first result of `condition` that is true."""
    deadline = time.monotonic() + seconds
    while (began := time.monotonic()) < deadline:
        result = condition()
        if result:
            return result
        # Looking costs processor time that the line needs as well: never more than half of it.
        time.sleep(min(1.0, max(0.1, time.monotonic() - began)))
    raise AssertionError(f"not within {seconds} s: {what}\n{run('systemctl', 'status', SERVICE, expect=None)}")


def properties(*names, unit=SERVICE):
    """What systemd knows of the unit: values by name."""
    text = run("systemctl", "show", unit, *(f"--property={name}" for name in names))
    return dict(line.split("=", 1) for line in text.splitlines())


def main_pid(unit=SERVICE):
    return int(properties("MainPID", unit=unit)["MainPID"])


def cansync(*arguments, expect=0):
    """The objects that `cansync --json` wrote."""
    text = run("cansync", "--json", "--timeout", "30", *arguments, expect=expect)
    return [json.loads(line) for line in text.splitlines() if line.startswith("{")]


def line_is_active(slaves=2):
    """True while the service is up, the line in active operation, and every slave synchronized."""
    if properties("ActiveState")["ActiveState"] != "active":
        return False
    text = run("cansync", "--json", "--timeout", "10", "status", expect=None)
    statuses = [json.loads(line) for line in text.splitlines() if line.startswith("{")]
    return (len(statuses) == 1 and statuses[0]["option_status"] & ACTIVE != 0 and
            statuses[0]["slaves_synchronized"].bit_count() == slaves)


def wait_until_active():
    wait_for(f"{SERVICE} in active operation", line_is_active)


def locks():
    """(mode, what) of each lock that logind has of the daemon."""
    text = run("busctl", "call", "--json=short", "org.freedesktop.login1", "/org/freedesktop/login1",
               "org.freedesktop.login1.Manager", "ListInhibitors")
    return {(mode, what) for what, _, _, mode, _, pid in json.loads(text)["data"][0] if pid == main_pid()}


def locks_are_taken():
    return locks() == LOCKS


def wait_for_state(state, unit=SERVICE):
    wait_for(f"{unit} is {state}", lambda: properties("ActiveState", unit=unit)["ActiveState"] == state)


def journal(*arguments):
    """Entries of the journal: a list of objects."""
    text = run("journalctl", "--output=json", "--no-pager", "--all", *arguments)
    return [json.loads(line) for line in text.splitlines() if line.startswith("{")]


class SyncEdges:
    """SYNC frames on the interface, with the kernel's times, from `with` on."""

    SYNC, INTERVAL = 0x080, 0.008  # of configuration_text
    BUFFER = 256 << 20  # bytes that may wait, of a kernel that counts some 800 for each frame
    TIMESTAMP_NS = 35  # SO_TIMESTAMPNS

    def __enter__(self):
        self.socket = socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW)
        self.socket.setsockopt(socket.SOL_CAN_RAW, socket.CAN_RAW_FILTER, struct.pack("=II", self.SYNC, 0x7FF))
        self.socket.setsockopt(socket.SOL_SOCKET, 33, self.BUFFER)  # SO_RCVBUFFORCE
        self.socket.setsockopt(socket.SOL_SOCKET, self.TIMESTAMP_NS, 1)
        self.socket.bind((INTERFACE,))
        return self

    def __exit__(self, *_):
        self.socket.close()

    def steps(self):
        """Seconds from each that has come to the next."""
        times = []
        try:
            while True:
                ancillary = self.socket.recvmsg(16, 64, socket.MSG_DONTWAIT)[1]
                seconds, nanoseconds = struct.unpack("qq", ancillary[0][2])
                times.append(seconds + nanoseconds / 1e9)
        except BlockingIOError:
            return [after - before for before, after in zip(times, times[1:])]


def configuration_text():
    """The configuration of the virtual interface, made from the shipped one as an administrator does."""
    text = EXAMPLE.replace('interface = "can0"', f'interface = "{INTERFACE}"').replace("bit_rate = 500000", "bit_rate = 125000")
    text += """
[[slave]]
number = 1
name = "axis-1"

# No wires here: SYNC as a frame, which the simulated drives understand.
[sync]
output = "can"

[process]
reference_registers_1 = [0x01, 0x03, 0, 0]

[metrics]
file = "/run/cansync/vcan0/cansync.prom"
period_s = 1
"""
    return text


def write_configuration():
    CONFIGURATION.write_text(configuration_text(), encoding="utf-8")


def change_configuration(old, new):
    text = CONFIGURATION.read_text(encoding="utf-8")
    assert old in text, f"{old!r} is not in {CONFIGURATION}"
    CONFIGURATION.write_text(text.replace(old, new), encoding="utf-8")


def packages():
    """The files of the new packages and of those before, as they lie in the root: new, previous."""
    folder = pathlib.Path("/srv/packages")
    return sorted(folder.glob("new/*.deb")), sorted(folder.glob("previous/*.deb"))


def installed_version(package="cansyncd"):
    return run("dpkg-query", "-W", "-f=${Version}", package)
