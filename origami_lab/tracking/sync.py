"""`origami-lab dashboard --sync`: push the run folders on disk to the MLflow store."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterator, Sequence
from contextlib import contextmanager
from pathlib import Path

from omegaconf import DictConfig, OmegaConf

from origami_lab.config.settings import Settings, read_settings
from origami_lab.errors import InputError
from origami_lab.runs.locks import held, locked
from origami_lab.runs.run_finder import find_runs
from origami_lab.runs.run_folder import read_note
from origami_lab.tracking.experiment_runs import Runs
from origami_lab.tracking.store import RefusedError, StoreError, absolute_uri, check_store, default_uri, explain


def read_run(folder: Path) -> Settings:
    """The settings that a run folder was made with.

    Raises
    ------
    InputError
        If its config.yaml cannot be read or is not one.
    """
    file = folder / "config.yaml"
    try:
        config = OmegaConf.load(file)
    except Exception as error:
        lines = str(error).splitlines() or [""]
        raise InputError("configuration", file, f"cannot be read ({lines[0]})") from error
    if not isinstance(config, DictConfig):
        raise InputError("configuration", file, "must be the configuration of a run")
    return read_settings(config)


@contextmanager
def _alone(folder: Path) -> Iterator[bool]:
    """Keep other pushes out of a run folder that no run writes to; whether it could be had."""
    try:
        with locked(folder):
            pass  # not kept: a run that is resumed now waits for this push, and need not be refused
    except InputError:
        yield False
        return
    with held(folder, wait=False) as free:
        yield free


def sync_runs(
    directories: Sequence[Path],
    uri: str | None,
    say: Callable[[str], None],
    complain: Callable[[str], None],
    skip: Collection[Path] = (),
) -> tuple[int, set[str]]:
    """Push what the stores do not have yet; one line a run folder.

    Parameters
    ----------
    uri
        The store to push to; None for the one that each run folder names, or the default one.
    say, complain
        Take lines about folders that went well, and about those that did not.
    skip
        Folders whose run folders are left out.

    Returns
    -------
    How many folders could not be pushed, and the URIs of the stores that have the others.

    Raises
    ------
    InputError
        If there is no run folder in a directory.
    """
    if uri is not None:
        check_store(uri, "--uri")
        uri = absolute_uri(uri)
    failed, stores = 0, set[str]()
    dead: dict[str, str] = {}
    for folder in (folder for directory in directories for folder in find_runs(directory, "--sync")):
        if any(folder.is_relative_to(left_out) for left_out in skip):
            continue
        store = uri
        try:
            settings = read_run(folder)
            store = uri or read_note(folder).get("uri") or settings.tracking.uri or default_uri()
            store = absolute_uri(str(store))
            if store in dead:
                raise StoreError(dead[store])
            check_store(store)
            with _alone(folder) as free:
                if not free:
                    say(f"{folder}: left alone, another process runs or pushes it")
                    continue
                added = Runs(settings, folder, store, keep=uri is not None).push(live=False)
        except Exception as error:
            if isinstance(error, StoreError) and not isinstance(error, RefusedError) and store is not None:
                dead[store] = str(error)
            failed += 1
            complain(f"{folder}: {explain(error, store or '')}")
            continue
        stores.add(store)
        say(f"{folder}: " + ("already there" if added < 0 else f"{added} trial{'' if added == 1 else 's'} pushed"))
    return failed, stores
