"""What tshark's own dissector of J1939 makes of everything that a node can say: nothing is malformed, and priority, PGN, source
and destination of each frame are what the node means."""
import os

from captures import Folder

FIELDS = ("j1939.priority", "j1939.pgn", "j1939.src_addr", "j1939.dst_addr")


def main():
    with Folder() as folder:
        log, meanings = folder.path / "messages.log", folder.path / "meanings"
        folder.run(os.environ["MESSAGE_CAPTURE"], log, meanings)
        meant = meanings.read_text().splitlines()
        assert len(meant) > 800, len(meant)
        decode = ["tshark", "-r", log, "-d", "can.subdissector,j1939"]
        malformed = folder.run(*decode, "-Y", "_ws.malformed || _ws.unreassembled || _ws.expert.severity >= 6291456").decode()
        assert not malformed, malformed
        arguments = [part for name in FIELDS for part in ("-e", name)]
        rows = folder.run(*decode, "-Y", "j1939", "-T", "fields", "-E", "separator=|", *arguments).decode().splitlines()
        assert len(rows) == len(meant), (len(rows), len(meant))
        for number, (row, line) in enumerate(zip(rows, meant), 1):
            numbers = [int(text or "255") for text in row.split("|")]  # a group from PDU format 240 on names no destination
            assert numbers == [int(text) for text in line.split("|")], f"frame {number}: tshark {row}, meant {line}"
        groups = {int(line.split("|")[1]) for line in meant}
        assert {0xEC00, 0xEB00, 0xC800, 0xC700, 0xE800, 0xEA00, 0xEE00, 0x1FEF1} <= groups, groups
        # It finds what it is for: a frame with an identifier of 11 bits is none of J1939.
        log.write_text("(0.000000) can0 123#0102\n")
        assert not folder.run(*decode, "-Y", "j1939")
        print(f"{len(meant)} frames, none malformed")


main()
