"""What `cmake --install` installs of cansync-security is enough to follow docs/security.md.

The build's folder comes from the environment: BUILD_FOLDER.
"""

import os
import subprocess
import tempfile
import unittest


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


if __name__ == "__main__":
    unittest.main(verbosity=2)
