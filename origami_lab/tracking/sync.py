"""`origami-lab dashboard --sync`: push folders on disk to the MLflow store."""

from __future__ import annotations

from collections.abc import Callable, Collection, Iterable, Sequence
from pathlib import Path

from origami_lab.runs.run_finder import find_runs
from origami_lab.tracking.mlflow_log import MlflowLog
from origami_lab.tracking.store import RefusedError, StoreError, absolute_uri, check_store, default_uri, explain


def run_folders(directories: Sequence[Path], skip: Collection[Path]) -> list[Path]:
    """The run folders at or below some directories, but for those at or below the folders to skip.

    Raises
    ------
    InputError
        If there is no run folder in a directory.
    """
    found = [folder for directory in directories for folder in find_runs(directory, "--sync")]
    return [folder for folder in found if not any(folder.is_relative_to(left_out) for left_out in skip)]


def sync_folders(
    folders: Iterable[tuple[Path, type[MlflowLog]]],
    uri: str | None,
    say: Callable[[str], None],
    complain: Callable[[str], None],
) -> tuple[int, set[str]]:
    """Push what the stores do not have yet; one line a folder.

    Parameters
    ----------
    folders
        Each with the kind of its runs.
    uri
        The store to push to; None for the one that each folder names, or the default one.
    say, complain
        Take lines about folders that went well, and about those that did not.

    Returns
    -------
    How many folders could not be pushed, and the URIs of the stores that have the others.
    """
    if uri is not None:
        check_store(uri, "--uri")
    failed, stores = 0, set[str]()
    dead: dict[str, str] = {}
    for folder, kind in folders:
        store = uri or ""
        try:
            store = absolute_uri(uri or kind.store_of(folder) or default_uri())
            if store in dead:
                raise StoreError(dead[store])
            check_store(store)
            with kind.alone(folder) as free:
                if not free:
                    say(f"{folder}: left alone, another process runs or pushes it")
                    continue
                added = kind(folder, store, keep=uri is not None).push(live=False)
        except Exception as error:
            if isinstance(error, StoreError) and not isinstance(error, RefusedError):
                dead[store] = str(error)
            failed += 1
            complain(f"{folder}: {explain(error, store)}")
            continue
        stores.add(store)
        say(f"{folder}: " + ("already there" if added < 0 else f"{added} trial{'' if added == 1 else 's'} pushed"))
    return failed, stores
