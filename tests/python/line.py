"""A line of simulated drives with the real daemon, for tests of the Python package.

CANSYNCD is the daemon's program; PYTHONPATH has the package.
"""

import os
import pathlib
import sys

ROOT = pathlib.Path(__file__).resolve().parents[2]
sys.path.insert(0, str(ROOT / "tests/end_to_end"))
os.environ.setdefault("CANSYNC", "")  # the command is not used here
from gateway import LONG, NEVER_MISSING_REFERENCES, Gateway  # noqa: E402  (its folder is named above)

import cansync  # noqa: E402

PROFILES = ROOT / "config/profiles"


class Line(Gateway):
    """Four drives, of which number 1 is called winder; 0 and 1 have the profile of the simulated drive."""

    def __init__(self, *options):
        profile = PROFILES / "simulated-drive.toml"
        super().__init__(options=("--set", f"slave.0.profile={profile}", "--set", f"slave.1.profile={profile}",
                                  *NEVER_MISSING_REFERENCES, *options))

    def connect(self, **options):
        return cansync.connect(self.bus, domain=self.domain, profiles=str(PROFILES), timeout=LONG, **options)

    def wait_active(self):
        with self.connect() as line:
            line.wait_active(LONG)
