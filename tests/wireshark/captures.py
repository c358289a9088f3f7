"""Captures of CANsync lines and what tshark says of them."""
import json
import os
import pathlib
import shutil
import subprocess
import tempfile

HERE = pathlib.Path(__file__).parent
SOURCE = pathlib.Path(os.environ["SOURCE"])
STARTS = ["-o", "cansync.stamps:start of the frame"]


class Folder:
    """A temporary folder, which is also the home whose plugins tshark loads: the dissector's folder as installed."""

    def __enter__(self):
        self.path = pathlib.Path(tempfile.mkdtemp(prefix="cansync-wireshark-"))
        plugins = self.path / ".local/lib/wireshark/plugins"
        plugins.mkdir(parents=True)
        shutil.copytree(SOURCE / "tools/wireshark/cansync", plugins / "cansync")
        return self

    def __exit__(self, *_):
        shutil.rmtree(self.path)

    def run(self, *command):
        """Standard output of a command that must succeed."""
        environment = dict(os.environ, HOME=str(self.path), XDG_CONFIG_HOME=str(self.path / ".config"), TZ="UTC",
                           LC_ALL="C.UTF-8")
        done = subprocess.run([str(part) for part in command], capture_output=True, env=environment, check=False)
        errors = done.stderr.decode()
        assert done.returncode == 0, f"{command}: {errors}"
        assert "Lua" not in errors, errors
        return done.stdout

    def capture(self, log):
        """The pcapng capture of a candump log."""
        out = self.path / (pathlib.Path(log).stem + ".pcapng")
        self.run(os.environ["CANSYNC"], "trace", log, "--pcapng", out)
        return out

    def traced(self, log):
        """Each frame of a log as `cansync trace --json` tells it."""
        text = self.run(os.environ["CANSYNC"], "trace", log, "--json").decode()
        return [json.loads(line) for line in text.splitlines()]

    def fields(self, capture, names, *options):
        """Rows of fields of every frame, in two passes, so that commands know their answers too."""
        arguments = [part for name in names for part in ("-e", name)]
        text = self.run("tshark", "-2", "-Y", "frame", "-r", capture, *STARTS, *options, "-T", "fields",
                        "-E", "separator=|", *arguments).decode()
        return [line.split("|") for line in text.splitlines()]


def differences(expected, got):
    """The first lines that differ, for people."""
    out = []
    for number, (left, right) in enumerate(zip(expected + [""] * len(got), got + [""] * len(expected)), 1):
        if left != right:
            out.append(f"line {number}\n  expected {left!r}\n  got      {right!r}")
    return "\n".join(out[:10])
