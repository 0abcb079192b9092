"""What does a broken store cost? ``python -m benchmarks.tracking_faults [--out FILE.md] [NAME ...]``

Real runs of the command against stores that are down, slow, locked, damaged or die in mid-run. Of each: the exit
code, which results are on disk, how long it took beside the same run without tracking, every line that it printed
to stderr, and what the store has afterwards.
"""

from __future__ import annotations

import argparse
import os
import platform
import signal
import socket
import sqlite3
import subprocess
import sys
import tempfile
import threading
import time
from collections import Counter
from collections.abc import Callable, Iterator
from contextlib import closing, contextmanager
from dataclasses import dataclass, field
from http.server import BaseHTTPRequestHandler
from pathlib import Path

from benchmarks import write_report
from benchmarks.faulty_servers import ENVIRONMENT, MlflowServer, free_port, http_server, reply, reply_late
from origami_lab.runs.trial_row import read_trials
from origami_lab.tracking.store import create_database, open_client

RUN = ("target=pyramid", "search=rdm", "workers=1", "verbosity=quiet", "output=out")
SHORT = ("budget=400", "seed=0..1")
LONG = ("budget=60000", "seed=0..3")
"""Long enough for something to happen between its trials."""


@dataclass
class Outcome:
    """One command."""

    code: int
    seconds: float
    lines: list[str]
    on_disk: str
    notes: list[str] = field(default_factory=list)


def origami_lab(
    folder: Path, *arguments: str, during: Callable[[subprocess.Popen[str]], None] | None = None
) -> Outcome:
    """Run the command in a folder, and something else beside it."""
    command = [sys.executable, "-m", "origami_lab", *arguments]
    began = time.monotonic()
    process = subprocess.Popen(
        command, cwd=folder, env=ENVIRONMENT, stdout=subprocess.PIPE, stderr=subprocess.PIPE, text=True
    )
    if during is not None:
        during(process)
    out, err = process.communicate(timeout=600)
    seconds = time.monotonic() - began
    lines = [line for line in (out + err if "dashboard" in arguments else err).splitlines() if line.strip()]
    return Outcome(process.returncode, seconds, lines, results(folder / "out"))


def results(out: Path) -> str:
    """How complete a run folder is."""
    if not (out / "trials.csv").is_file():
        return "nothing was started"
    rows = read_trials(out / "trials.csv")
    whole = [row for row in rows if row.status == "ok" and (out / f"seed={row.seed}/motion.gif").is_file()]
    return f"{len(whole)} of {len(rows)} trials" + (", summary" if (out / "summary.json").is_file() else "")


def tracked(uri: str) -> str:
    """What a store has: parents and children with their statuses."""
    client = open_client(uri)
    runs = [run for experiment in client.search_experiments() for run in client.search_runs([experiment.experiment_id])]
    parents = [run.info.status for run in runs if "mlflow.parentRunId" not in run.data.tags]
    children = sorted(f"{run.info.run_name} {run.info.status}" for run in runs if "mlflow.parentRunId" in run.data.tags)
    return f"parent {', '.join(parents) or 'none'}; children: {', '.join(children) or 'none'}"


def after_first_trial(folder: Path, action: Callable[[], None]) -> Callable[[subprocess.Popen[str]], None]:
    """Do something when one trial is tracked, while the others run."""

    def during(process: subprocess.Popen[str]) -> None:
        while process.poll() is None and not (folder / "out/trials.csv").is_file():
            time.sleep(0.1)
        time.sleep(1.0)
        action()

    return during


# --- what goes wrong ---


def baseline(folder: Path) -> Iterator[tuple[str, Outcome]]:
    origami_lab(folder, *RUN, *SHORT, "tracking=none", "output=first")
    yield "no tracking", origami_lab(folder, *RUN, *SHORT, "tracking=none")


def refused(folder: Path) -> Iterator[tuple[str, Outcome]]:
    yield "connection refused", origami_lab(folder, *RUN, *SHORT, f"tracking.uri=http://127.0.0.1:{free_port()}")


def unroutable(folder: Path) -> Iterator[tuple[str, Outcome]]:
    yield "unroutable address", origami_lab(folder, *RUN, *SHORT, "tracking.uri='http://[fd00::1]:5000'")


def unknown_host(folder: Path) -> Iterator[tuple[str, Outcome]]:
    yield "unknown host name", origami_lab(folder, *RUN, *SHORT, "tracking.uri=http://no-such-host.invalid:5000")


def slow(folder: Path) -> Iterator[tuple[str, Outcome]]:
    with http_server(reply_late) as uri:
        yield "answers after 30 s", origami_lab(folder, *RUN, *SHORT, f"tracking.uri={uri}")


def interrupted(folder: Path) -> Iterator[tuple[str, Outcome]]:
    def during(process: subprocess.Popen[str]) -> None:
        while process.poll() is None and not (folder / "out/summary.json").is_file():
            time.sleep(0.1)
        time.sleep(8.0)  # the workers have left
        process.send_signal(signal.SIGINT)

    with http_server(reply_late) as uri:
        yield (
            "answers after 30 s, and Ctrl-C while it is waited for",
            origami_lab(folder, *RUN, *SHORT, f"tracking.uri={uri}", during=during),
        )


def healthy_but_slow(folder: Path) -> Iterator[tuple[str, Outcome]]:
    def answer(handler: BaseHTTPRequestHandler) -> None:
        reply(handler, 200, "OK") if handler.path == "/health" else reply_late(handler)

    with http_server(answer) as uri:
        yield "alive, but every call takes 30 s", origami_lab(folder, *RUN, *SHORT, f"tracking.uri={uri}")


def silent(folder: Path) -> Iterator[tuple[str, Outcome]]:
    with socket.socket() as listening:
        listening.bind(("127.0.0.1", 0))
        listening.listen(50)
        uri = f"http://127.0.0.1:{listening.getsockname()[1]}"
        yield "accepts and never answers", origami_lab(folder, *RUN, *SHORT, f"tracking.uri={uri}")


def error_500(folder: Path) -> Iterator[tuple[str, Outcome]]:
    with http_server(lambda handler: reply(handler, 500, "no")) as uri:
        yield "answers HTTP 500", origami_lab(folder, *RUN, *SHORT, f"tracking.uri={uri}")


def html(folder: Path) -> Iterator[tuple[str, Outcome]]:
    with http_server(lambda handler: reply(handler, 200, "<!doctype html><html>hello</html>")) as uri:
        yield "answers a web page", origami_lab(folder, *RUN, *SHORT, f"tracking.uri={uri}")


@contextmanager
def killed_in_mid_run(folder: Path) -> Iterator[tuple[MlflowServer, Outcome]]:
    """A server that was killed with SIGKILL while a run was tracked in it, and that run; the server is back then."""
    server = MlflowServer(folder / "server")
    try:
        tracking = f"tracking.uri={server.uri}"
        run = origami_lab(folder, *RUN, *LONG, tracking, during=after_first_trial(folder, server.kill))
        server.start()
        yield server, run
    finally:
        server.kill()


def killed_then_resumed(folder: Path) -> Iterator[tuple[str, Outcome]]:
    with killed_in_mid_run(folder) as (server, run):
        yield "MLflow server killed with SIGKILL in mid-run", run
        before = tracked(server.uri)
        again = origami_lab(folder, *RUN, *LONG, "resume=true")
        again.notes += [f"store before: {before}", f"store: {tracked(server.uri)}"]
        yield "… restarted, then `resume=true`", again


def killed_then_synced(folder: Path) -> Iterator[tuple[str, Outcome]]:
    with killed_in_mid_run(folder) as (server, run):
        yield "MLflow server killed with SIGKILL in mid-run, again", run
        for name in ("… restarted, then `dashboard --sync .`", "… and a second `--sync`"):
            again = origami_lab(folder, "dashboard", "--sync", ".")
            again.notes.append(f"store: {tracked(server.uri)}")
            yield name, again


def killed_run(folder: Path) -> Iterator[tuple[str, Outcome]]:
    holder: list[subprocess.Popen[str]] = []

    def during(process: subprocess.Popen[str]) -> None:
        holder.append(process)
        after_first_trial(folder, process.kill)(process)

    run = origami_lab(folder, *RUN, *LONG, during=during)
    time.sleep(5)
    uri = f"sqlite:///{folder}/results/mlflow.db"
    run.notes.append(f"store: {tracked(uri)}")
    yield "the run itself killed with SIGKILL", run
    again = origami_lab(folder, "dashboard", "--sync", "out")
    again.notes.append(f"store: {tracked(uri)}")
    yield "… then `dashboard --sync out`", again
    resumed = origami_lab(folder, *RUN, *LONG, "resume=true")
    resumed.notes.append(f"store: {tracked(uri)}")
    yield "… then `resume=true`", resumed


def killed_sync(folder: Path) -> Iterator[tuple[str, Outcome]]:
    origami_lab(folder, *RUN, "budget=400", "seed=0..3", "tracking=none")
    uri = f"sqlite:///{folder}/results/mlflow.db"
    (folder / "results").mkdir()
    create_database(folder / "results/mlflow.db")

    def during(process: subprocess.Popen[str]) -> None:
        while process.poll() is None:
            with closing(sqlite3.connect(uri.removeprefix("sqlite:///"), timeout=20)) as connection:
                if connection.execute("SELECT count(*) FROM runs").fetchone()[0] >= 3:
                    process.kill()
                    return

    run = origami_lab(folder, "dashboard", "--sync", "out", during=during)
    run.notes.append(f"store: {tracked(uri)}")
    yield "`--sync` of an untracked run, killed with SIGKILL at its third MLflow run", run
    again = origami_lab(folder, "dashboard", "--sync", "out")
    again.notes.append(f"store: {tracked(uri)}")
    yield "… then `--sync` again", again


# --- database files ---


def locked(folder: Path, seconds: float) -> Outcome:
    database = folder / "results/mlflow.db"
    create_database(database)
    with closing(sqlite3.connect(database, check_same_thread=False, isolation_level=None)) as connection:
        connection.execute("BEGIN EXCLUSIVE")
        if seconds < 600:
            threading.Timer(seconds, lambda: connection.execute("ROLLBACK")).start()
        run = origami_lab(folder, *RUN, *SHORT)
        if connection.in_transaction:
            connection.execute("ROLLBACK")
        run.notes.append(f"store: {tracked(f'sqlite:///{database}')}")
    return run


def locked_always(folder: Path) -> Iterator[tuple[str, Outcome]]:
    yield "SQLite file locked all the time", locked(folder, 1e6)


def locked_for_a_while(folder: Path) -> Iterator[tuple[str, Outcome]]:
    yield "SQLite file locked until 10 s after the start", locked(folder, 10.0)


def no_database(folder: Path) -> Iterator[tuple[str, Outcome]]:
    (folder / "results").mkdir()
    (folder / "results/mlflow.db").write_text("dear diary,\n")
    yield "store file is no database", origami_lab(folder, *RUN, *SHORT)


def damaged(folder: Path) -> Iterator[tuple[str, Outcome]]:
    database = folder / "results/mlflow.db"
    create_database(database)
    content = bytearray(database.read_bytes())
    content[100 : len(content) // 2] = b"\xff" * (len(content) // 2 - 100)
    database.write_bytes(content)
    yield "store file overwritten in part", origami_lab(folder, *RUN, *SHORT)


def schema(folder: Path) -> Iterator[tuple[str, Outcome]]:
    database = folder / "results/mlflow.db"
    create_database(database)
    with closing(sqlite3.connect(database)) as connection:
        connection.execute("UPDATE alembic_version SET version_num = '451aebb31d03'")
        connection.commit()
    yield "store of an older schema", origami_lab(folder, *RUN, *SHORT)
    with closing(sqlite3.connect(database)) as connection:
        connection.execute("UPDATE alembic_version SET version_num = 'ffffffffffff'")
        connection.commit()
    yield "store of an unknown schema", origami_lab(folder, *RUN, *SHORT, "output=out2")
    yield "… and `dashboard` on it", origami_lab(folder, "dashboard", "--port", str(free_port()))


def read_only(folder: Path) -> Iterator[tuple[str, Outcome]]:
    database = folder / "results/mlflow.db"
    create_database(database)
    database.chmod(0o444)
    if os.geteuid() == 0:  # root writes to anything, but not to what is marked immutable
        if subprocess.run(["chattr", "+i", str(database)], capture_output=True).returncode != 0:
            return
    try:
        yield "store file is read-only", origami_lab(folder, *RUN, *SHORT)
    finally:
        if os.geteuid() == 0:
            subprocess.run(["chattr", "-i", str(database)], check=True)


def no_folder(folder: Path) -> Iterator[tuple[str, Outcome]]:
    (folder / "results").write_text("a file where the folder should be")
    yield "folder of the store cannot be made", origami_lab(folder, *RUN, *SHORT)


def wrong_uris(folder: Path) -> Iterator[tuple[str, Outcome]]:
    for uri in ("foo://bar", "http://", "http://host:99999", "sqlite://my.db", "mlruns"):
        yield f"tracking.uri={uri}", origami_lab(folder, *RUN, *SHORT, f"tracking.uri={uri}")


def eight_at_once(folder: Path) -> Iterator[tuple[str, Outcome]]:
    """Runs without a search, so that eight of them reach the store together."""
    for number in range(8):
        out = origami_lab(folder, *RUN, "budget=400", f"seed={number}", "tracking=none", f"output=runs/{number}")
        assert out.code == 0
    began = time.monotonic()
    command = [sys.executable, "-m", "origami_lab", *RUN, "budget=400", "resume=true"]
    processes = [
        subprocess.Popen(
            [*command, f"seed={number}", f"output=runs/{number}"],
            cwd=folder,
            env=ENVIRONMENT,
            stdout=subprocess.DEVNULL,
            stderr=subprocess.PIPE,
            text=True,
        )
        for number in range(8)
    ]
    errors = [process.communicate(timeout=600)[1] for process in processes]
    codes = {process.returncode for process in processes}
    said = Counter(line for text in errors for line in text.splitlines() if line.strip())
    lines = [f"{number} times: {line}" for line, number in said.items() if "are on disk" not in line]
    whole = len(list(folder.glob("runs/*/seed=*/best.fold")))
    run = Outcome(max(codes), time.monotonic() - began, lines, f"{whole} of 8 trials")
    run.notes.append(f"store: {tracked(f'sqlite:///{folder}/results/mlflow.db')}")
    run.notes.append(f"files beside it: {sorted(file.name for file in (folder / 'results').iterdir())}")
    yield "eight processes make first use of a store", run


SCENARIOS: tuple[Callable[[Path], Iterator[tuple[str, Outcome]]], ...] = (
    *(baseline, refused, unroutable, unknown_host, slow, interrupted, healthy_but_slow, silent, error_500, html),
    *(killed_then_resumed, killed_then_synced, killed_run, killed_sync),
    *(locked_always, locked_for_a_while, no_database, damaged, schema, read_only, no_folder, wrong_uris),
    eight_at_once,
)


def main() -> None:
    """Run the scenarios and write the report."""
    parser = argparse.ArgumentParser(description=__doc__)
    parser.add_argument("names", nargs="*", help="scenarios (default: all)")
    parser.add_argument("--out", type=Path, help="where the report goes (default: stdout)")
    options = parser.parse_args()
    text = [
        "# What a broken store costs",
        "",
        f"`python -m benchmarks.tracking_faults`, Python {platform.python_version()}, {os.cpu_count()} cores. "
        "Each is a run of two short trials, or of four longer ones where something happens in mid-run; "
        "`tracking.uri` as named; seconds are those of the whole command, on a machine that was busy otherwise.",
        "",
        "| what is wrong | exit code | seconds | on disk | printed to stderr (of `dashboard`: all) |",
        "|---|---|---|---|---|",
    ]
    for scenario in SCENARIOS:
        if options.names and scenario.__name__ not in options.names:
            continue
        with tempfile.TemporaryDirectory(prefix="tracking-") as name:
            folder = Path(name).resolve()
            for title, run in scenario(folder):
                cells = [line.replace(str(folder), "DIR").replace("|", "\\|") for line in (*run.lines, *run.notes)]
                row = f"| {title} | {run.code} | {run.seconds:.0f} | {run.on_disk} | {'<br>'.join(cells) or '–'} |"
                print(row, flush=True)
                text.append(row)
    write_report(text, options.out)


if __name__ == "__main__":
    main()
