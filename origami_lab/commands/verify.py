"""`origami-lab verify`: is a design really rigidly foldable? A certificate, or why not."""

from __future__ import annotations

import sys
from collections.abc import Sequence

from origami_lab.commands import number
from origami_lab.commands.parser import Parser
from origami_lab.errors import InputError
from origami_lab.files import write_whole
from origami_lab.text import one_line


def main(arguments: Sequence[str]) -> int:
    """Print the certificate; returns 0 certified, 1 refuted, 3 not certifiable (2, unreadable, is raised)."""
    description = "Check a FOLD file: sheet, panels, loops, one degree of freedom, and that no panels cross on the way."
    epilog = "Exit codes: 0 certified, 1 refuted, 2 the file cannot be read, 3 not certifiable, 70 an error of ours."
    parser = Parser("origami-lab verify", description=description, epilog=epilog)
    parser.add_argument(
        "file",
        metavar="FILE",
        help="a FOLD file with folded states or fold angles, ours or any program's, or the folder of a trial",
    )
    parser.add_argument("--json", metavar="FILE", help="write the certificate as JSON; - writes it to standard output")
    parser.add_argument("--thickness", help="distance that panels must keep, in the file's units")
    options = parser.parse_args(arguments)
    from origami_lab.fold_format.motion_frames import fold_path
    from origami_lab.verification.verify_design import verify

    certificate = verify(fold_path(options.file), number("--thickness", options.thickness) or 0.0)
    for remark in certificate.remarks:
        print(f"note: {one_line(remark)}", file=sys.stderr)
    if options.json == "-":
        sys.stdout.write(certificate.json_text())
        return certificate.exit_code
    if options.json:
        try:
            write_whole(options.json, certificate.json_text())
        except OSError as error:
            raise InputError("--json", options.json, f"must be a file that can be written ({error.strerror})") from None
    print("\n".join(map(one_line, certificate.words().rstrip("\n").split("\n"))))  # a file's names are in it
    return certificate.exit_code
