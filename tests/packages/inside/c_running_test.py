"""The service, started by systemctl, at work on vcan0."""

import contextlib
import ctypes
import os
import pathlib
import random
import re
import shutil
import signal
import subprocess
import time
import unittest
import urllib.request

from machine import *

REALTIME_THREAD, GATEWAY_THREAD, MAIN_THREAD = "cansync-rt", "cansync-gateway", "cansyncd"
RESTART = 1  # s, RestartSec=
PTRACE_SEIZE = 0x4206
PTRACE_INTERRUPT = 0x4207
WALL = 0x40000000  # __WALL of waitpid: threads, too


def tasks(pid):
    """The threads of a process, as folders of /proc."""
    return list(pathlib.Path(f"/proc/{pid}/task").iterdir())


def scheduling(task):
    """Realtime priority and policy of a thread; policy 1 is SCHED_FIFO."""
    fields = task.joinpath("stat").read_text(encoding="ascii").rsplit(")", 1)[1].split()  # from field 3 on
    return int(fields[37]), int(fields[38])


def sockets_of(pid):
    """The address families of the process's sockets."""
    tables = {}
    net = pathlib.Path(f"/proc/{pid}/net")
    # The column that holds the inode, by file.
    for name, column, family in (("unix", 6, "AF_UNIX"), ("udp", 9, "AF_INET"), ("tcp", 9, "AF_INET"),
                                 ("udp6", 9, "AF_INET6"), ("netlink", 9, "AF_NETLINK"), ("packet", 8, "AF_PACKET")):
        if (net / name).exists():
            for line in (net / name).read_text(encoding="ascii").splitlines()[1:]:
                tables[line.split()[column]] = family
    found = []
    for entry in os.scandir(f"/proc/{pid}/fd"):
        target = os.readlink(entry.path)
        if target.startswith("socket:"):
            found.append(tables.get(target[8:-1], "AF_CAN"))  # raw CAN sockets have no table with inodes
    return found


def scrape():
    """What node_exporter serves; nothing while it does not."""
    with contextlib.suppress(OSError), urllib.request.urlopen("http://127.0.0.1:9100/metrics", timeout=LONG) as answer:
        return answer.read().decode()
    return None


@contextlib.contextmanager
def running(*command):
    """A command under way, which has said something."""
    with subprocess.Popen(command, env=ENVIRONMENT, stdin=subprocess.DEVNULL, stdout=subprocess.PIPE, stderr=subprocess.STDOUT) as process:
        try:
            process.stdout.readline()
            yield process
        finally:
            process.kill()


class Running(unittest.TestCase):
    def test_01_starts_without_its_interface_and_with_it(self):
        for name in ("vcan9", "vcan-x", "vcan.1"):
            with self.subTest(name=name):
                file = pathlib.Path(f"/etc/cansync/{name}.toml")
                file.write_text(f'[bus]\ninterface = "{name}"\nbit_rate = 125000\n[[slave]]\nnumber = 0\n', encoding="utf-8")
                unit = run("systemd-escape", "--template=cansyncd@.service", name).strip()
                run("systemctl", "enable", "--now", unit)  # at the boot, too: it waits for nothing
                pid = main_pid(unit)
                self.assertEqual(cansync("--bus", name, "status")[0]["link_state"], "missing")
                run("ip", "link", "add", "dev", name, "type", "vcan")
                run("ip", "link", "set", name, "up")
                wait_for("it has its interface", lambda: cansync("--bus", name, "status")[0]["link_state"] == "up")
                run("ip", "link", "delete", name)
                wait_for("it has lost its interface", lambda: cansync("--bus", name, "status")[0]["link_state"] == "missing")
                self.assertEqual(main_pid(unit), pid)
                run("systemctl", "stop", unit)
                run("ip", "link", "add", "dev", name, "type", "vcan")
                wait_for_state("active", unit)  # the interface has started it
                run("systemctl", "disable", "--now", unit)
                run("ip", "link", "delete", name)
                file.unlink()
        self.assertEqual(run("systemctl", "--failed", "--no-legend", "--plain"), "")

    def test_02_setup_puts_a_line_in_place_and_starts_its_service(self):
        line = pathlib.Path("/tmp/line")
        shutil.copytree("/usr/share/doc/cansyncd/examples", line / "network",
                        ignore=lambda _, names: [name for name in names if not name.startswith(f"25-{INTERFACE}.")])
        text = configuration_text()
        for known in ('name = "axis-1"\n', '[sync]\noutput = "can"\n'):  # what setup is told
            self.assertIn(known, text)
            text = text.replace(known, "")
        (line / f"{INTERFACE}.toml").write_text(text, encoding="utf-8")
        # As on a computer whose network is not networkd's.
        run("systemctl", "disable", "systemd-networkd.service", "systemd-networkd-wait-online.service")
        before = os.umask(0o077)  # as root's shell may have it
        self.addCleanup(os.umask, before)
        told = run("cansync", "setup", line, "--yes", "--name", "1=axis-1", "--sync", "can", "--start", "active")
        for words in (f"write {CONFIGURATION}", f"keep /etc/systemd/network/25-{INTERFACE}.network",
                      f"run systemctl enable cansyncd@{INTERFACE}", f"run systemctl start cansyncd@{INTERFACE}",
                      f"cansyncd@{INTERFACE} runs with {CONFIGURATION}, and starts at every boot", f"next: cansync --bus {INTERFACE} doctor"):
            self.assertIn(words, told)
        self.assertEqual(run("systemctl", "is-enabled", SERVICE).strip(), "enabled")
        self.assertEqual(properties("ActiveState")["ActiveState"], "active")
        self.assertEqual(cansync("status")[0]["process"], main_pid())
        # What waits for the network at a boot does not wait for a CAN interface.
        self.assertEqual(run("systemctl", "is-enabled", "systemd-networkd.service").strip(), "enabled")
        began = time.monotonic()
        run("systemctl", "start", "network-online.target")
        self.assertLess(time.monotonic() - began, 5)

    def test_03_is_healthy_with_the_simulator(self):
        run("cansyncd", "--check", CONFIGURATION)
        run("systemctl", "start", SIMULATOR)
        wait_until_active()
        self.assertEqual(properties("ActiveState", unit=SIMULATOR)["ActiveState"], "active")
        text = properties("StatusText")["StatusText"]
        wait_for("the status text", lambda: properties("StatusText")["StatusText"] ==
                 "run: 2 of 2 slaves respond; bus vcan0 (vcan0) at 125000 bit/s")
        self.assertIn("Status: \"run: ", run("systemctl", "status", SERVICE), text)

    def test_04_reads_a_parameter_and_transfers_a_block(self):
        reply = cansync("read", "axis-1", "301")[0]
        self.assertEqual(reply["result"], "done")
        block = os.urandom(300)
        pathlib.Path("/tmp/block").write_bytes(block)
        self.assertEqual(cansync("download", "axis-0", "0x1000", "/tmp/block")[0]["result"], "done")
        self.assertEqual(cansync("upload", "axis-0", "0x1000", "300", "/tmp/back")[0]["result"], "done")
        self.assertEqual(pathlib.Path("/tmp/back").read_bytes(), block)

    def test_04_setup_names_the_program_that_it_would_cut_off(self):
        wanted = pathlib.Path("/tmp/wanted.toml")
        wanted.write_text(pathlib.Path(CONFIGURATION).read_text(encoding="utf-8").replace("bit_rate = 125000", "bit_rate = 250000"), encoding="utf-8")
        with subprocess.Popen(["cansync", "--bus", INTERFACE, "set", "0=0"], stderr=subprocess.DEVNULL) as writer:
            try:
                wait_for("it leads", lambda: f"process {writer.pid} " in cansync("status")[0]["reference_release"][0]["writer"])
                told = run("cansync", "setup", wanted, "--dry-run")
            finally:
                writer.terminate()
        self.assertRegex(told, rf"take effect at a restart: bus.bit_rate.*the drives report a fault. .*process {writer.pid} on host .* gives the reference values")

    def test_05_has_the_realtime_rights_that_it_insists_on(self):
        pid = main_pid()
        self.assertIn((60, 1), [scheduling(task) for task in tasks(pid)])  # SCHED_FIFO
        locked = re.search(r"VmLck:\s+(\d+) kB", pathlib.Path(f"/proc/{pid}/status").read_text(encoding="ascii"))
        self.assertGreater(int(locked.group(1)), 1000)
        # No more than that, and not for ever.
        limits = pathlib.Path(f"/proc/{pid}/limits").read_text(encoding="ascii")
        self.assertRegex(limits, r"Max realtime priority\s+60\s+60\s")
        self.assertRegex(limits, r"Max realtime timeout\s+1000000\s+2000000\s+us")
        self.assertEqual(properties("MemoryMax")["MemoryMax"], str(1 << 30))

    def test_06_has_no_capabilities_and_no_new_privileges(self):
        status = pathlib.Path(f"/proc/{main_pid()}/status").read_text(encoding="ascii")
        for kind in ("CapInh", "CapPrm", "CapEff", "CapBnd", "CapAmb"):
            self.assertRegex(status, rf"{kind}:\s+0000000000000000\n")
        self.assertRegex(status, r"NoNewPrivs:\s+1\n")
        self.assertRegex(status, r"Seccomp:\s+2\n")
        user = run("id", "-u", "cansync").strip()
        self.assertRegex(status, rf"Uid:\s+{user}\s+{user}\s+{user}\s+{user}\n")

    def test_07_sees_and_holds_no_other_users_files(self):
        pid = main_pid()
        for folder in ("/root", "/home"):
            listing = run("nsenter", f"--target={pid}", "--mount", "ls", "-A", folder, expect=None)
            self.assertTrue(listing == "" or "Permission denied" in listing, listing)
        run("nsenter", f"--target={pid}", "--mount", "touch", "/etc/cansync/made-by-test", expect=1)
        user = int(run("id", "-u", "cansync"))
        for entry in os.scandir(f"/proc/{pid}/fd"):
            facts, target = os.stat(entry.path), os.readlink(entry.path)
            # A lock of logind is a pipe that belongs to it.
            if target.startswith("/") and not target.startswith(("/dev/", "/run/systemd/inhibit/")):
                self.assertEqual(facts.st_uid, user, target)

    def test_08_has_sockets_of_the_stated_families_alone(self):
        stated = set(properties("RestrictAddressFamilies")["RestrictAddressFamilies"].split())
        self.assertEqual(stated, {"AF_UNIX", "AF_INET", "AF_NETLINK", "AF_CAN"})
        found = sockets_of(main_pid())
        self.assertLessEqual(set(found), stated)
        self.assertIn("AF_CAN", found)
        self.assertIn("AF_INET", found)
        # Bound to this computer alone.
        addresses = re.findall(r"cansyncd.*", run("ss", "--udp", "--listening", "--numeric", "--processes"))
        self.assertTrue(addresses)

    def test_09_reload_changes_a_mapping(self):
        pid = main_pid()
        before = cansync("map", "references")
        change_configuration("reference_registers_1 = [0x01, 0x03, 0, 0]", "reference_registers_1 = [0x05, 0x07, 0, 0]")
        run("systemctl", "reload", SERVICE)
        wait_for("the mapping has changed", lambda: cansync("map", "references") != before)
        first = [o for o in cansync("map", "references") if o["telegram"] == 1][0]
        self.assertEqual(first["registers"][:2], [0x05, 0x07])
        self.assertEqual(main_pid(), pid)
        wait_until_active()

    def test_10_a_wrong_file_on_reload_changes_nothing(self):
        pid = main_pid()
        change_configuration("bit_rate = 125000", "bit_rate = 125001")
        run("systemctl", "reload", SERVICE)
        wait_for("the error stands in the journal", lambda: "bus.bit_rate: found 125001" in
                 run("journalctl", "--no-pager", "--unit", SERVICE))
        change_configuration("bit_rate = 125001", "bit_rate = 125000")
        self.assertEqual(main_pid(), pid)
        wait_until_active()

    def test_11_killed_it_is_restarted(self):
        pid, restarts = main_pid(), int(properties("NRestarts")["NRestarts"])
        os.kill(pid, signal.SIGKILL)
        wait_for("systemd has restarted it", lambda: main_pid() not in (0, pid))
        wait_until_active()
        self.assertEqual(int(properties("NRestarts")["NRestarts"]), restarts + 1)

    def test_12_the_watchdog_restarts_it_when_a_thread_stands_still(self):
        libc = ctypes.CDLL(None, use_errno=True)
        for name in (REALTIME_THREAD, GATEWAY_THREAD, MAIN_THREAD):
            with self.subTest(thread=name):
                pid, since = main_pid(), int(time.time())
                thread = next(int(task.name) for task in tasks(pid) if task.joinpath("comm").read_text(encoding="ascii").strip() == name)
                # As a debugger does: this one thread stands still, all others go on.
                for request in (PTRACE_SEIZE, PTRACE_INTERRUPT):
                    self.assertEqual(libc.ptrace(request, thread, None, None), 0, os.strerror(ctypes.get_errno()))
                began = time.monotonic()

                def restarted():
                    with contextlib.suppress(ChildProcessError):  # we are its debugger: it is not gone before we know
                        os.waitpid(thread, WALL | os.WNOHANG)
                    return main_pid() not in (0, pid)

                wait_for("systemd has restarted it", restarted)
                self.assertLess(time.monotonic() - began, 10 + 2 + RESTART)  # WatchdogSec=, and to end it
                self.assertIn("Watchdog timeout", run("journalctl", "--no-pager", "--unit", SERVICE, f"--since=@{since}"))
                wait_until_active()

    def test_12_requests_for_recordings_leave_the_watchdog_content(self):
        pid, since, until = main_pid(), int(time.time()), time.monotonic() + 25
        while time.monotonic() < until:
            os.kill(pid, signal.SIGUSR1)
            time.sleep(1)
        self.assertEqual(main_pid(), pid)
        recordings = journal("EVENT=flight_recording", f"--since=@{since}")
        self.assertGreater(len(recordings), 10)
        kept = list(pathlib.Path(f"/var/lib/cansync/{INTERFACE}").glob("*-requested.json"))
        self.assertTrue(0 < len(kept) <= 10, kept)

    def test_13_a_wrong_configuration_is_shown_with_line_and_column(self):
        change_configuration("bit_rate = 125000", "bit_rate = 125001")
        line = 1 + CONFIGURATION.read_text(encoding="utf-8").split("bit_rate = 125001")[0].count("\n")
        wrong = f"{CONFIGURATION}:{line}:12: bus.bit_rate: found 125001; allowed: 125000, 250000,"
        # The last one that has run serves the line.
        run("systemctl", "restart", SERVICE)
        wait_until_active()
        self.assertIn(wrong, cansync("status")[0]["configuration_reason"])
        self.assertIn("configuration", [o["topic"] for o in cansync("doctor", expect=None) if o["level"] != "ok"])
        # Without one it is not tried again.
        for kept in pathlib.Path(f"/var/lib/cansync/{INTERFACE}").glob("*.toml"):
            kept.unlink()
        run("systemctl", "restart", SERVICE, expect=1)
        wait_for_state("failed")
        self.assertIn(wrong, run("systemctl", "status", SERVICE, expect=3))
        facts = properties("NRestarts", "ExecMainStatus")
        self.assertEqual(facts, {"NRestarts": "0", "ExecMainStatus": "78"})
        change_configuration("bit_rate = 125001", "bit_rate = 125000")
        run("systemctl", "reset-failed", SERVICE)
        run("systemctl", "start", SERVICE)
        wait_until_active()

    def test_14_metrics_are_there(self):
        text = wait_for("the file of the metrics", lambda: run("cat", "/run/cansync/vcan0/cansync.prom", expect=None))
        self.assertTrue(text.endswith("# EOF\n"), text)
        self.assertRegex(text, r'cansync_\w+\{[^}]*bus="vcan0"')
        pathlib.Path("/var/lib/prometheus/node-exporter/vcan0.prom").symlink_to("/run/cansync/vcan0/cansync.prom")  # docs/metrics.md
        run("systemctl", "start", "prometheus-node-exporter.service")
        scraped = wait_for("node_exporter answers", scrape)
        self.assertIn("\nnode_textfile_scrape_error 0\n", scraped)
        self.assertRegex(scraped, r'\ncansync_info\{[^}]*bus="vcan0"')
        run("systemctl", "stop", "prometheus-node-exporter.service")

    def test_15_the_python_package_works(self):
        program = (f"import cansync\nwith cansync.connect('{INTERFACE}', timeout={LONG}) as line:\n"
                   f"    line.wait_active({LONG})\n    print(line.slave('axis-1'), line.read('axis-1', 103).raw)\n")
        self.assertEqual(run("/usr/bin/python3", "-c", program).split(), ["1", "1"])

    def test_16_in_run_the_computer_does_not_sleep(self):
        wait_for("the locks are taken", locks_are_taken)
        refused = run("systemctl", "suspend", "--check-inhibitors=yes", expect=1)
        self.assertIn('Operation inhibited by "cansyncd"', refused)
        found = {o["topic"]: o for o in cansync("doctor", expect=None)}
        self.assertEqual(found["inhibitors"]["level"], "ok", found["inhibitors"])
        self.assertEqual(found["sleep"]["level"], "warning", found["sleep"])
        cansync("mode", "stop", "--yes")
        wait_for("the locks are given back", lambda: not locks())
        cansync("mode", "setup", "--yes")
        wait_for("the drives are ready, and the line runs", lambda: "done" in run("cansync", "--json", "mode", "run", "--yes", expect=None))
        wait_until_active()
        wait_for("the locks are taken again", locks_are_taken)

    def test_17_an_appliance_is_set_up_and_undone(self):
        run("cansync", "setup", "--appliance", "--yes")
        self.assertEqual({o["topic"]: o for o in cansync("doctor", expect=None)}["sleep"]["level"], "ok")
        self.assertIn("nothing to do", run("cansync", "setup", "--appliance", "--yes"))
        run("cansync", "setup", "--appliance", "--undo", "--yes")
        self.assertEqual(run("find", "/etc", "-name", "*cansync-appliance*"), "")

    def test_18_outlives_an_adapter_that_comes_and_goes(self):
        # How many gaps: the file `gaps` beside this one, if there is one (run.py --gaps).
        asked = pathlib.Path(__file__).with_name("gaps")
        draw = random.Random(18)
        gaps = [0.1, 0.3, 1, 30]
        gaps += [round(10 ** draw.uniform(-1, 0.7), 2) for _ in range(int(asked.read_text(encoding="ascii")) if asked.exists() else 4)]
        pid, before, since = main_pid(), cansync("status")[0], int(time.time())
        restarts = properties("NRestarts")
        with running("cansync", "set", "0=1", "--rate", "20") as writer, running("cansync", "watch") as hangs:
            hangs.send_signal(signal.SIGSTOP)
            for count, gap in enumerate(gaps, 1):
                run("ip", "link", "delete", INTERFACE)
                time.sleep(gap)
                run("ip", "link", "add", "dev", INTERFACE, "type", "vcan")  # networkd sets it up
                wait_for("it has its interface", lambda count=count: len(journal("EVENT=interface_up", f"--since=@{since}")) == count)
                wait_until_active()
                release = wait_for("the writer's values are released", lambda: cansync("status")[0]["reference_release"][0])
                self.assertIn(f"process {writer.pid} ", release["writer"])
            self.assertEqual(len(journal("EVENT=interface_missing", f"--since=@{since}")), len(gaps))
            self.assertIsNone(writer.poll())
        after = cansync("status")[0]
        self.assertEqual((main_pid(), after["daemon"]), (pid, before["daemon"]))
        self.assertEqual(properties("NRestarts"), restarts)
        self.assertEqual(after["missed_syncs"], before["missed_syncs"])

    def test_19_apart_from_other_programs(self):
        name = "vcan8"
        examples = pathlib.Path("/usr/share/doc/cansyncd/examples")
        units = pathlib.Path("/etc/systemd/system")
        example = (examples / "cansync-apart@.service").read_text(encoding="utf-8")
        # A virtual interface has no bit rate: what would set it is looked at, and done without.
        self.assertIn(" link set %I type can bitrate ${BIT_RATE} ", example)
        (units / "cansync-apart@.service").write_text(example.replace(" type can bitrate ${BIT_RATE} sample-point 0.600 restart-ms 100", " mtu 16"), encoding="utf-8")
        drop_in = units / f"cansyncd@{name}.service.d"
        drop_in.mkdir()
        shutil.copy(examples / "apart.conf", drop_in)
        file = pathlib.Path(f"/etc/cansync/{name}.toml")
        file.write_text(f'[bus]\ninterface = "{name}"\nprotocol = "layer2"\nbit_rate = 500000\n[dds]\ninterface = "dds"\n', encoding="utf-8")
        run("systemctl", "daemon-reload")
        run("systemctl", "enable", f"cansync-apart@{name}")
        run("ip", "link", "add", "dev", name, "type", "vcan")
        run("systemctl", "start", f"cansyncd@{name}")
        reach = ("--interface", f"dds-{name}", "--bus", name)
        for there in (True, False, True):
            if not there:  # unplugged, and plugged in again
                run("ip", "-n", f"cansync-{name}", "link", "delete", name)
                wait_for("it has lost its interface", lambda: cansync(*reach, "status")[0]["link_state"] == "missing")
                run("ip", "link", "add", "dev", name, "type", "vcan")
            wait_for("it has its interface", lambda: cansync(*reach, "status")[0]["link_state"] == "up")
            run("cansync", *reach, "can", "send", "123#11")
            # No other program, not even one of root, finds the interface.
            found = run("python3", "-c", "import socket; socket.socket(socket.AF_CAN, socket.SOCK_RAW, socket.CAN_RAW).bind(('" + name + "',))",
                        expect=1)
            self.assertIn("No such device", found)
        self.assertIn("network namespace", {o["topic"]: o for o in cansync(*reach, "doctor", expect=None)}["interface"]["found"])
        run("systemctl", "stop", f"cansyncd@{name}")
        run("systemctl", "disable", f"cansync-apart@{name}")
        run("ip", "netns", "delete", f"cansync-{name}")
        for path in (file, units / "cansync-apart@.service"):
            path.unlink()
        shutil.rmtree(drop_in)
        run("systemctl", "daemon-reload")
