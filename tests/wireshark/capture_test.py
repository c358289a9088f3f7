"""Captures of `cansync trace --pcapng` are what Wireshark's own tools say they are, and are read again."""
import os
import subprocess

from captures import HERE, Folder

CANSYNC = os.environ["CANSYNC"]
LOG = HERE / "telegrams.log"


def frames_of(text):
    """The lines of a log that are frames, with times as numbers: leading zeroes do not count."""
    out = []
    for line in text.splitlines():
        if not line.startswith("#"):
            time, interface, frame = line.split()
            out.append((float(time.strip("()")), interface, frame))
    return out


def check_capinfos(folder, capture):
    said = folder.run("capinfos", "-M", capture).decode()
    frames = frames_of(LOG.read_text())
    edges = sum(interface == "sync" for _, interface, _ in frames)
    for part in ("pcapng", "SocketCAN (125 - socketcan)", f"Number of packets:   {len(frames)}",
                 "Time precision = nanoseconds (9)", "Number of interfaces in file: 2", "Name = sync", "Name = can0",
                 f"Number of packets = {edges}\n", f"Number of packets = {len(frames) - edges}\n",
                 "First packet time:   1970-01-01 00:00:01.001000000", "Capture application: cansync "):
        assert part in said, f"{part!r} is not in\n{said}"


def check_read_again(folder, capture):
    """A log, its capture, and that capture after Wireshark has written it anew, all hold the same frames."""
    wanted = frames_of(LOG.read_text())
    anew = folder.path / "anew.pcapng"
    folder.run("editcap", "-F", "pcapng", capture, anew)
    for file in (capture, anew):
        assert frames_of(folder.run(CANSYNC, "trace", file, "--candump").decode()) == wanted, file


def check_standard_output(folder, capture):
    """- writes the same bytes, is read from a pipe, and an interface's or slave's part is a capture of its own."""
    written = folder.run(CANSYNC, "trace", LOG, "--pcapng", "-")
    assert written == capture.read_bytes()
    with open(capture, "rb") as file:
        piped = subprocess.run([CANSYNC, "trace", "-", "--json"], stdin=file, capture_output=True, check=True).stdout
    assert piped == folder.run(CANSYNC, "trace", LOG, "--json")
    part = folder.path / "part.pcapng"
    folder.run(CANSYNC, "trace", LOG, "--slave", "5", "--count", "100000", "--pcapng", part)
    rows = folder.fields(part, ["cansync.channel", "cansync.slave"])
    assert {row[1] for row in rows if row[0] == "RC"} == {"5"}, rows


def refused(*arguments):
    done = subprocess.run([CANSYNC, "trace", *map(str, arguments)], capture_output=True, check=False)
    return done.returncode, done.stderr.decode()


def check_errors(folder, capture):
    code, text = refused(LOG, "--pcapng", folder.path / "x", "--candump")
    assert code == 2 and "--pcapng: found together with --candump or --json" in text, text
    code, text = refused(LOG, "--pcapng", folder.path / "no/such/folder")
    assert code == 1 and "no/such/folder" in text, text
    cut = folder.path / "cut.pcapng"
    cut.write_bytes(capture.read_bytes()[:-7])
    code, text = refused(cut)
    assert code == 11 and "the capture ends in the middle of a block" in text, text
    cut.write_bytes(capture.read_bytes()[:56] + b"\x03" * 100)
    code, text = refused(cut)
    assert code == 1 and "This is no pcapng capture" in text, text


def main():
    with Folder() as folder:
        capture = folder.capture(LOG)
        check_capinfos(folder, capture)
        check_read_again(folder, capture)
        check_standard_output(folder, capture)
        check_errors(folder, capture)


main()
