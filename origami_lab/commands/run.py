"""The command without a word: a Hydra application that runs one experiment or, with ``-m``, several."""

from __future__ import annotations

import io
import os
import sys
from collections.abc import Callable, Iterator, Sequence
from contextlib import ExitStack, contextmanager, redirect_stdout
from pathlib import Path
from typing import TYPE_CHECKING, NoReturn

from origami_lab.addresses import hidden
from origami_lab.errors import EXIT_INTERRUPTED, InputError
from origami_lab.files import expanded

if TYPE_CHECKING:
    from omegaconf import DictConfig

    from origami_lab.experiment.trial_process import TrialProcess

RERUN_SETTINGS = (
    "hydra.run.dir=.",
    "hydra.output_subdir=null",
    "hydra.job.name=origami-lab",
    "hydra/job_logging=none",
    "hydra/hydra_logging=none",
    "+hydra.callbacks.check_jobs._target_=origami_lab.multirun.CheckJobs",
)
"""Hydra's settings in conf/config.yaml, for a run's own config.yaml, which has none."""


def run(overrides: Sequence[str], flags: Sequence[str] = ()) -> int:
    """Compose the configuration and run one experiment, or several with ``-m``; returns the exit code."""
    from origami_lab.experiment.trial_process import early_process

    # the worker of the usual command imports meanwhile; it would not hear of what Hydra is told to change around it
    if flags or any("hydra" in word.partition("=")[0] for word in overrides):
        return _run(overrides, flags, None)
    with early_process() as early:
        return _run(overrides, flags, early)


def _run(overrides: Sequence[str], flags: Sequence[str], early: TrialProcess | None) -> int:
    import hydra

    from origami_lab.config.checked_files import check_typed, only_checked_files
    from origami_lab.config.compose import hydra_words, known_keys, working_directory_importable
    from origami_lab.config.hydra_errors import explain, find_culprit
    from origami_lab.config.option_files import CONFIG_NAME, config_dir
    from origami_lab.experiment.api import run_one
    from origami_lab.multirun.check_jobs import RefusedJobs
    from origami_lab.multirun.folder_of_command import SWEEP_DIR, multirun_folder, own_words
    from origami_lab.multirun.launchers import has_local_jobs, launcher_settings
    from origami_lab.multirun.run_jobs import Multirun

    several, flags = _checked_flags(flags)
    codes: list[int] = []
    raised: list[Exception] = []
    application = os.getpid()
    multirun: Multirun | None = None

    def task(config: DictConfig) -> float | None:
        if multirun is not None and os.getpid() != application:
            return multirun.run_launched(config)  # where only exceptions come through
        try:
            code, mean = run_one(config, (*overrides, *flags), early) if multirun is None else multirun.run_job(config)
        except Exception as error:
            # kept from Hydra, which would print its own lines about it
            raised.append(error)
            return None
        if code == EXIT_INTERRUPTED and several:
            raise KeyboardInterrupt  # or Hydra would start the next job
        codes.append(code)
        return mean

    check_typed(overrides)
    words = own_words(hydra_words(overrides), several)
    ours: list[str] = []
    if any(flag.startswith(("--config-path", "-cp")) for flag in flags):
        ours += RERUN_SETTINGS
    with ExitStack() as stack:
        try:
            if several:
                folder = stack.enter_context(multirun_folder(words))
                multirun = stack.enter_context(Multirun(folder, Path.cwd(), (*flags, *overrides)))
                if has_local_jobs(words):
                    stack.enter_context(multirun.listening())
                words = [word for word in words if not word.startswith(f"{SWEEP_DIR}=")]
                ours.append(multirun.sweep_dir)
            ours += launcher_settings(words)
            stack.enter_context(_as_hydra_sees_it([*ours, *words, *flags]))
            stack.enter_context(only_checked_files())
            stack.enter_context(working_directory_importable())
            run_it = hydra.main(config_path=str(config_dir()), config_name=CONFIG_NAME, version_base="1.3")(task)
            if any(flag.startswith(("--cfg", "-c", "--info", "-i")) for flag in flags):
                _show_without_secrets(run_it)
            else:
                run_it()
        except RefusedJobs as refused:
            raise explain(refused.error, overrides, known_keys) or refused.error from None
        except Exception as error:
            if multirun is not None and multirun.started:  # a launcher's trouble, or a job's
                raise
            found = explain(error, overrides, known_keys) or find_culprit(words)
            raise _of_its_configuration(found, flags, known_keys()) or found or error from None
    if raised:
        raise raised[0]
    if multirun is not None:  # of all its jobs, also those that ran in other processes or in an earlier command
        codes.append(multirun.exit_code)
    return max(codes, default=0)


def _show_without_secrets(show: Callable[[], object]) -> None:
    """Print what Hydra shows of a configuration; what it resolves may hold secrets."""
    shown = io.StringIO()
    try:
        with redirect_stdout(shown):
            show()
    finally:
        print("\n".join(map(hidden, shown.getvalue().split("\n"))), end="")


def rerun(word: str, overrides: Sequence[str], flags: Sequence[str]) -> int:
    """Run a finished run's configuration again, from `origami-lab DIR/config.yaml`."""
    from origami_lab.config.compose import known_keys
    from origami_lab.config.option_files import check_file

    file = Path(word)
    check_file(file, known_keys())
    values = []
    for override in overrides:
        key, _, value = override.partition("=")
        if key == "trust":  # in no file
            values.append(f"++{override}")
        elif key == "tracking":  # the one group that says nothing of the experiment itself
            values.append(f"tracking.kind={value}")
        elif key in ("target", "objective", "board", "symmetry", "start", "search", "experiment", "program"):
            expected = f"a finished configuration takes values like {key}.KEY=...; start anew for another {key}"
            raise InputError(key, value, expected)
        else:
            values.append(override)
    place = ["--config-path", str(file.resolve().parent), "--config-name", file.stem]
    return run(values, [*place, *flags])


@contextmanager
def _as_hydra_sees_it(command: list[str]) -> Iterator[None]:
    """The command in sys.argv, and errors raised instead of printed."""
    before = sys.argv, os.environ.get("HYDRA_FULL_ERROR")
    sys.argv = ["origami-lab", *command]
    os.environ["HYDRA_FULL_ERROR"] = "1"  # raise, and we say it in one line
    try:
        yield
    finally:
        sys.argv = before[0]
        if before[1] is None:
            del os.environ["HYDRA_FULL_ERROR"]
        else:
            os.environ["HYDRA_FULL_ERROR"] = before[1]


def _checked_flags(flags: Sequence[str]) -> tuple[bool, list[str]]:
    """Whether a multirun starts, and the flags with folders named from anywhere; Hydra would look beside our modules.

    Raises
    ------
    InputError
        If they are not Hydra's flags, whose parser would say so in a page, or name a folder that is not there.
    """
    from hydra._internal.utils import get_args_parser

    def refuse(message: str) -> NoReturn:
        raise InputError("flag", " ".join(flags), f"{message}; see --hydra-help")

    parser = get_args_parser()
    parser.error = refuse  # type: ignore[method-assign]
    known = parser.parse_args(list(flags))
    if known.resolve and not (known.cfg or known.help):
        raise InputError("flag", "--resolve", "must come with --cfg job")
    found = list(flags)
    for flag, folder in (("--config-dir", known.config_dir), ("--config-path", known.config_path)):
        if folder is None or "://" in folder:
            continue
        if not expanded(folder).is_dir():
            raise InputError(flag, folder, "there is no such folder")
        found += [flag, str(expanded(folder).absolute())]  # the last one counts
    shows = (known.cfg, known.info, known.help, known.hydra_help, known.shell_completion)
    return bool(known.multirun) and not any(shows), found


def _of_its_configuration(error: InputError | None, flags: Sequence[str], keys: Sequence[str]) -> InputError | None:
    """The error for a --config-name that is no experiment's: Hydra then finds no key that others have."""
    from hydra._internal.utils import get_args_parser

    name = get_args_parser().parse_args(list(flags)).config_name
    if name is None or error is None or error.field not in keys or "no such key" not in error.expected:
        return None
    expected = f"must name the configuration of an experiment, and this one has no {error.field}"
    return InputError("--config-name", name, f"{expected}; one of your own has config in its list of defaults")
