"""Names of the files in a run folder: what writes them, what reads them back and what pushes them agree here."""

from __future__ import annotations

from pathlib import Path

CONFIG = "config.yaml"
TARGET = "target.ply"
START = "start.json"
TRIALS = "trials.csv"
SUMMARY = "summary.json"
TRACKING = "tracking.json"

PAGE, PAGE_DATA = "index.html", "index.data"
"""The page of a run, a multirun or a sweep, and the folder of what it shows."""

RESULT = "result.json"
BEST = "best.fold"
MOTION = "motion.fold"
ACTIONS = "actions.json"
CURVE = "curve.csv"
HISTORY = "history.json"
"""How a design of the studio came about."""
CERTIFICATE = "certificate.json"
STATE = "search.npz"
PATTERN_PNG = "pattern.png"
FOLDED_PNG = "folded.png"
FILM = "motion.gif"
VIEWER = "best.html"
PATTERN_SVG = "pattern.svg"
PATTERN_DXF = "pattern.dxf"
CUT_SHEETS = ("pattern.cut.svg", "pattern.cut.pdf")
"""Written where a board cell has a length on paper."""
POLISHED, SIMPLIFIED = "polished", "simplified"
"""How the names of the files of a design begin that was made of a trial's best one."""

DESCRIBED = {
    VIEWER: "turn and fold it",
    FOLDED_PNG: "folded",
    PATTERN_PNG: "crease pattern",
    PATTERN_SVG: "pattern for Origami Simulator",
    FILM: "motion",
    CUT_SHEETS[1]: "sheet to cut, PDF",
    CUT_SHEETS[0]: "sheet to cut, SVG",
    PATTERN_DXF: "pattern for CAD",
    BEST: "FOLD file",
    CERTIFICATE: "certificate",
    f"{POLISHED}.html": "polished, to turn and fold",
    f"{POLISHED}.png": "polished, folded",
    f"{POLISHED}.fold": "polished, FOLD file",
    f"{SIMPLIFIED}.html": "simplified, to turn and fold",
    f"{SIMPLIFIED}.fold": "simplified, FOLD file",
}
"""Files of a trial that people are led to, and what they are called there."""

FOLDER_FORMAT = 2
"""Version of what a run folder holds; folders of version 0.1.0 do not say theirs, which is 1."""

CHECKPOINT = ".checkpoint"
SEED = "seed="
"""First letters of the name of a trial's folder."""


def trial_folder(run: Path, seed: int) -> Path:
    """The folder of one trial in the folder of its run."""
    return run / f"{SEED}{seed}"


def checkpoint_file(run: Path, seed: int) -> Path:
    """The file of one trial's search that is not finished."""
    return run / f"{SEED}{seed}{CHECKPOINT}"


def error_file(run: Path, seed: int) -> Path:
    """The file with the traceback of a trial that failed."""
    return run / f"{SEED}{seed}.error.txt"
