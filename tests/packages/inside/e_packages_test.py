"""Remove, purge, and the upgrade from the packages before."""

import hashlib
import pathlib
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


class Packages(unittest.TestCase):
    def test_1_remove_stops_and_keeps_the_configuration(self):
        run(*APT, "remove", *NAMES, timeout=SLOW)
        self.assertEqual(properties("ActiveState")["ActiveState"], "inactive")
        self.assertEqual(run("pgrep", "--list-name", "cansync", expect=None).replace("cansync-proof", ""), "")
        self.assertTrue(CONFIGURATION.exists())

    def test_2_purge_leaves_nothing(self):
        # Not apt-get, which knows no more of packages that are removed and have left nothing.
        run("dpkg", "--purge", *NAMES, timeout=SLOW)
        self.assertEqual(leftovers(), [])

    def test_3_the_packages_before_run_the_line(self):
        run(*APT, "install", *packages()[1], timeout=SLOW)
        write_configuration()
        run("systemctl", "enable", SERVICE)
        run("systemctl", "start", SIMULATOR, SERVICE)
        wait_until_active()

    def test_4_upgrade_keeps_the_configuration_and_comes_back(self):
        shipped = pathlib.Path("/etc/cansync/can0.toml")
        with shipped.open("a", encoding="utf-8") as file:
            file.write("# The administrator was here.\n")
        before = {path: hashlib.sha256(path.read_bytes()).digest() for path in (shipped, CONFIGURATION)}
        pid, version = main_pid(), installed_version()
        run(*APT, "install", *packages()[0], timeout=SLOW)
        self.assertNotEqual(installed_version(), version)
        self.assertEqual({path: hashlib.sha256(path.read_bytes()).digest() for path in before}, before)
        wait_for("the new program runs", lambda: main_pid() not in (0, pid))
        wait_until_active()
        self.assertEqual(run("systemctl", "is-enabled", SERVICE).strip(), "enabled")
