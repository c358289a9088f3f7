"""What `cmake --install` installs of cansync-security is enough to follow docs/security.md.

The build's folder comes from the environment: BUILD_FOLDER.
"""

import os
import re
import subprocess
import tempfile
import unittest


def read(*path):
    with open(os.path.join(*path), encoding="utf-8") as file:
        return file.read()


def openssl(*arguments):
    return subprocess.run(["openssl", *arguments], check=True, capture_output=True, text=True, timeout=120).stdout


class Installed(unittest.TestCase):
    def test_makes_identities_with_its_own_templates(self):
        with tempfile.TemporaryDirectory() as folder:
            place = ["--prefix", folder, "--component", "security"]
            subprocess.run(["cmake", "--install", os.environ["BUILD_FOLDER"], *place], check=True, capture_output=True)
            program = os.path.join(folder, "bin/cansync-security")
            authority = os.path.join(folder, "ca")
            for arguments in (("init", authority), ("add", authority, "daemon", "--role", "daemon")):
                result = subprocess.run([program, *arguments], capture_output=True, text=True, timeout=120)
                self.assertEqual(result.returncode, 0, result.stderr)
            listed = subprocess.run([program, "list", authority], capture_output=True, text=True, timeout=120)
            self.assertIn("daemon", listed.stdout, listed.stderr)
            self.renew(program, authority)

    def renew(self, program, authority):
        """New certificates under the same authorities, for the same role and buses; the old folder is kept."""
        def run(*arguments):
            return subprocess.run([program, *arguments], capture_output=True, text=True, timeout=120)

        added = run("add", authority, "panel", "--role", "operator", "--bus", "can0", "--bus", "can1", "--days", "20")
        self.assertEqual(added.returncode, 0, added.stderr)
        panel = os.path.join(authority, "panel")
        before = {name: read(panel, name) for name in os.listdir(panel)}
        renewed = run("renew", authority, "panel", "--days", "30")
        self.assertEqual(renewed.returncode, 0, renewed.stderr)
        self.assertIn("programs that run use it after a restart", renewed.stdout)
        after = {name: read(panel, name) for name in os.listdir(panel)}
        self.assertEqual(after.keys(), before.keys())
        for name in before:
            same = name in ("identity_ca.pem", "permissions_ca.pem", "governance.p7s")
            self.assertEqual(after[name] == before[name], same, name)
        partitions = re.compile(r"<partition>.*</partition>")
        self.assertEqual(partitions.findall(after["permissions.p7s"]), partitions.findall(before["permissions.p7s"]))
        certificate = os.path.join(panel, "certificate.pem")
        openssl("verify", "-CAfile", os.path.join(authority, "identity_ca.pem"), certificate)
        self.assertIn("OU = operator", openssl("x509", "-in", certificate, "-noout", "-subject"))
        openssl("x509", "-in", certificate, "-noout", "-checkend", str(29 * 86400))
        kept, = [folder for folder, _, files in os.walk(os.path.join(authority, "authority", "replaced")) if files]
        self.assertEqual({name: read(kept, name) for name in os.listdir(kept)}, before)
        for folder, _, names in os.walk(authority):
            for name in names:
                self.assertEqual(os.stat(os.path.join(folder, name)).st_mode & 0o077, 0, name)
        daemon = run("renew", authority, "daemon")
        self.assertIn("restart the daemon when the line may stop", daemon.stdout, daemon.stderr)
        openssl("x509", "-in", os.path.join(authority, "daemon", "certificate.pem"), "-noout", "-checkend", str(3649 * 86400))
        for arguments, code, words in ((("renew", authority, "nobody"), 1, "is no identity"),
                                       (("renew", authority), 2, "folder and name are needed"),
                                       (("renew", authority, "panel", "--days", "9000"), 1, "expires in less than 9000 days")):
            result = run(*arguments)
            self.assertEqual((result.returncode, words in result.stderr), (code, True), result.stderr)
        self.assertEqual(read(panel, "certificate.pem"), after["certificate.pem"], "a refusal changes nothing")


if __name__ == "__main__":
    unittest.main(verbosity=2)
