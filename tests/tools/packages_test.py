"""tools/install_packages and tools/packages.txt: what a group installs, and whether it is what the build takes."""

import os
import pathlib
import re
import subprocess
import sys
import tempfile
import unittest

ROOT = pathlib.Path(__file__).parents[2]
ESSENTIAL = {"g++"}  # of build-essential, which no Debian source package names
OF_PACKAGES_ALONE = {"debhelper-compat", "dh-sequence-installsysusers", "dh-sequence-python3", "python3-cffi", "python3-dev"}  # only the packages are made with it


class PackagesTest(unittest.TestCase):
    def install(self, *arguments, states=""):
        """Exit status, and the packages apt-get is told to install where dpkg knows these states."""
        with tempfile.TemporaryDirectory() as folder:
            for name, text in (("dpkg-query", f"printf '{states}'; exit 1"), ("id", "echo 0"), ("apt-get", f'[ "$1" != install ] || echo "$@" >{folder}/told')):
                path = pathlib.Path(folder, name)
                path.write_text(f"#!/bin/sh\n{text}\n")
                path.chmod(0o755)
            done = subprocess.run([ROOT / "tools/install_packages", *arguments], capture_output=True, text=True,
                                  env={**os.environ, "PATH": f"{folder}:{os.environ['PATH']}"})
            told = pathlib.Path(folder, "told")
            return done.returncode, {word for word in told.read_text().split()[1:] if word[0] != "-"} if told.exists() else set()

    def test_the_group_build_is_what_the_debian_package_is_built_with(self):
        status, installed = self.install("build")
        self.assertEqual(status, 0)
        control = (ROOT / "packaging/debian/control").read_text()
        listed = re.search(r"^Build-Depends:(.*?)\n\S", control, re.MULTILINE | re.DOTALL)[1]
        needed = {entry.split()[0] for entry in listed.split(",") if entry.strip()}
        self.assertEqual(installed - ESSENTIAL, needed - OF_PACKAGES_ALONE)

    def test_without_a_group_all_are_installed(self):
        status, everything = self.install()
        self.assertEqual(status, 0)
        self.assertEqual(everything, self.install("build")[1] | self.install("test")[1])
        self.assertIn("qemu-system-x86", everything)

    def test_what_is_installed_is_not_installed_again(self):
        states = r"git install ok installed\ncmake hold ok installed\nlowdown deinstall ok config-files\n"
        everything = self.install()[1]
        self.assertEqual(self.install(states=states), (0, everything - {"git", "cmake"}))

    def test_an_unknown_group_is_an_error(self):
        self.assertEqual(self.install("demo"), (2, set()))

    def test_every_package_has_its_reason(self):
        documented = (ROOT / "docs/dependencies.md").read_text()
        self.assertEqual({name for name in self.install()[1] if f"`{name}`" not in documented}, set())


if __name__ == "__main__":
    unittest.main(argv=[sys.argv[0], *sys.argv[1:]])
