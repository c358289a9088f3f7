"""Remove, purge, and the upgrade from the packages before."""

import contextlib
import hashlib
import pathlib
import time
import unittest

from machine import *

APT = ("apt-get", "--yes", "-o", "Dpkg::Options::=--force-unsafe-io", "-o", "Dpkg::Use-Pty=0")
NAMES = ("cansyncd", "cansync-tools", "libcansync1", "libcansync-dev", "python3-cansync")
SLOW = 240


# Not of the packages: these tests, what systemd remembers of them, and man's own cache.
OTHERS = ("cansync-proof", "/run/systemd/", "/var/cache/man/", "/var/lib/apt/")


def leftovers():
    """Files with our name, and the user."""
    found = run("find", "/etc", "/usr", "/lib/systemd", "/lib/udev", "/var/lib", "/var/cache", "/run", "-xdev", "-iname",
                "*cansync*", expect=None).splitlines()
    found += [line for line in run("getent", "passwd").splitlines() if line.startswith("cansync:")]
    return [path for path in found if not any(other in path for other in OTHERS)]


def replace_library():
    """Puts a copy of a library that the daemon has loaded in its place, as dpkg does it."""
    library = next(line.split()[5] for line in pathlib.Path(f"/proc/{main_pid()}/maps").read_text(encoding="utf-8").splitlines()
                   if "libddsc.so" in line)
    run("cp", library, f"{library}.dpkg-new")
    run("mv", f"{library}.dpkg-new", library)


class Packages(unittest.TestCase):
    @contextlib.contextmanager
    def an_upgrade(self):
        """After it files are as they were, and the line was in run all the time, in the same process."""
        shipped = pathlib.Path("/etc/cansync/can0.toml")
        with shipped.open("a", encoding="utf-8") as file:
            file.write("# The administrator was here.\n")
        before = {path: hashlib.sha256(path.read_bytes()).digest() for path in (shipped, CONFIGURATION)}
        pid, version, began, since = main_pid(), installed_version(), cansync("status")[0], int(time.time()) + 1
        with SyncEdges() as edges:
            yield
            ended = cansync("status")[0]
            steps = edges.steps()
        self.assertNotEqual(installed_version(), version)
        self.assertEqual({path: hashlib.sha256(path.read_bytes()).digest() for path in before}, before)
        self.assertEqual(run("systemctl", "is-enabled", SERVICE).strip(), "enabled")
        self.assertTrue(pathlib.Path(f"/etc/systemd/system/multi-user.target.wants/{SERVICE}").is_symlink(), "starts with the computer")
        self.assertEqual((main_pid(), ended["daemon"]), (pid, began["daemon"]))
        self.assertTrue(line_is_active())
        self.assertGreater(len(steps), 100)
        self.assertEqual([step for step in steps if not 0.5 < step / edges.INTERVAL < 1.5], [], "seconds")
        self.assertEqual(ended["missed_syncs"], began["missed_syncs"])
        self.assertEqual(journal("EVENT=state_changed", "EVENT=daemon_stopping", f"--since=@{since}"), [])

    def test_1_remove_stops_and_keeps_the_configuration(self):
        run(*APT, "remove", *NAMES, timeout=SLOW)
        self.assertEqual(properties("ActiveState")["ActiveState"], "inactive")
        self.assertEqual(run("pgrep", "--list-name", "cansync", expect=None).replace("cansync-proof", ""), "")
        self.assertTrue(CONFIGURATION.exists())

    def test_2_purge_leaves_nothing(self):
        # Not apt-get, which knows no more of packages that are removed and have left nothing.
        run("dpkg", "--purge", *NAMES, timeout=SLOW)
        self.assertEqual(leftovers(), [])

    def test_2_the_example_of_packages_before_stays_where_nobody_has_touched_it(self):
        run(*APT, "install", *packages()[1], timeout=SLOW)
        example = pathlib.Path("/etc/cansync/can0.toml")
        shipped = example.read_bytes() if example.exists() else None
        run(*APT, "install", *packages()[0], timeout=SLOW)
        kept = example.read_bytes() if example.exists() else None
        self.test_2_purge_leaves_nothing()
        self.assertEqual(kept, shipped)
        if shipped is None:
            self.skipTest("the packages before are made of this commit, and have no example there")

    def test_3_the_packages_before_run_the_line(self):
        run(*APT, "install", *packages()[1], timeout=SLOW)
        write_configuration()
        run("systemctl", "enable", SERVICE)
        run("systemctl", "start", SIMULATOR, SERVICE)
        wait_until_active()

    def test_4_an_upgrade_leaves_the_line_that_runs_alone(self):
        # How many: the file `upgrades` beside this one, if there is one (run.py --upgrades).
        asked = pathlib.Path(__file__).with_name("upgrades")
        for number in range(int(asked.read_text(encoding="ascii")) if asked.exists() else 1):
            if number > 0:
                run(*APT, "-o", "Dpkg::Options::=--force-confold", "--allow-downgrades", "install", *packages()[1], timeout=SLOW)
                wait_until_active()
            with self.an_upgrade():
                run(*APT, "-o", "Dpkg::Options::=--force-confnew", "install", *packages()[0], timeout=SLOW)
                replace_library()
                run("env", "--unset=NEEDRESTART_SUSPEND", "needrestart", "-r", "a", timeout=SLOW)

    def test_5_what_waits_for_a_restart_is_named(self):
        run("systemctl", "reload", SERVICE)  # looks at the disk now
        found = wait_for("doctor names it", lambda: [o["found"] for o in cansync("doctor", expect=None)
                                                     if o["topic"] == "restart" and o["level"] == "warning"])[0]
        self.assertIn(f"cansyncd {installed_version()} is installed", found)
        self.assertIn("libddsc.so", found)
        self.assertIn("libddsc.so", journal("EVENT=restart_pending")[-1]["MESSAGE"])
        pid = main_pid()
        run("systemctl", "restart", SERVICE)
        self.assertNotEqual(main_pid(), pid)
        wait_until_active()
        self.assertIn({"topic": "restart", "level": "ok", "found": "nothing that the daemon has loaded was replaced on disk",
                       "remedy": None}, cansync("doctor", expect=None))

    def test_6_a_restart_at_each_upgrade_can_be_chosen(self):
        pid = main_pid()
        configure = ("/var/lib/dpkg/info/cansyncd.postinst", "configure", installed_version())
        run(*configure)
        self.assertEqual(main_pid(), pid)
        switch = pathlib.Path("/etc/default/cansyncd")
        switch.write_text(switch.read_text(encoding="ascii").replace("UPGRADE=no", "UPGRADE=yes"), encoding="ascii")
        run(*configure)
        self.assertNotEqual(main_pid(), pid)
        wait_until_active()
        switch.write_text(switch.read_text(encoding="ascii").replace("UPGRADE=yes", "UPGRADE=no"), encoding="ascii")

    def test_7_so_does_one_that_debian_makes_automatically(self):
        run(*APT, "-o", "Dpkg::Options::=--force-confold", "--allow-downgrades", "install", *packages()[1], timeout=SLOW)
        run("systemctl", "restart", SERVICE)
        wait_until_active()
        source = pathlib.Path("/etc/apt/sources.list.d/ours.list")
        source.write_text("deb [trusted=yes] file:/srv/packages/new ./\n", encoding="ascii")
        pathlib.Path("/etc/apt/apt.conf.d/99ours").write_text(
            'Unattended-Upgrade::Origins-Pattern { "origin=cansyncd"; };\nDPkg::Options { "--force-unsafe-io"; };\n', encoding="ascii")
        run("apt-get", "update", "-o", f"Dir::Etc::SourceList={source}", "-o", "Dir::Etc::SourceParts=-", timeout=SLOW)
        with self.an_upgrade():
            run("env", "--unset=NEEDRESTART_SUSPEND", "unattended-upgrade", "--verbose", timeout=SLOW)
