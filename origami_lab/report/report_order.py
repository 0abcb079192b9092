"""The order of tasks and searchers in reports: the places that their options give them, then by name."""

from __future__ import annotations

from collections.abc import Iterable, Mapping, Sequence
from dataclasses import dataclass

from origami_lab.config.option_files import read_options
from origami_lab.report.run_reader import Run


@dataclass(frozen=True)
class Ordering:
    """Places of tasks and searchers by their names, as ``report_order`` of a configuration gives them."""

    of_tasks: Mapping[str, float]
    of_methods: Mapping[str, float]

    @classmethod
    def of(cls, runs: Iterable[Run]) -> Ordering:
        """The places that the options of conf/ give, then those that runs kept of options of a user's own."""
        options = {**read_options("objective"), **read_options("target")}, read_options("search")
        places: list[dict[str, float]] = []
        for key, found in zip(("task", "method"), options, strict=True):
            written = [(name, (content.get("report_order") or {}).get(key)) for name, content in found.items()]
            kept = [(getattr(run, key), run.report_order.get(key)) for run in runs]
            places.append({name: place for name, place in (*written, *kept) if place is not None})
        return cls(*places)

    def tasks(self, names: Iterable[str]) -> list[str]:
        """Names of tasks in order."""
        return _ordered(names, self.of_tasks)

    def methods(self, names: Iterable[str]) -> list[str]:
        """Names of searchers in order."""
        return _ordered(names, self.of_methods)


def _ordered(names: Iterable[str], places: Mapping[str, float]) -> list[str]:
    """By their places, each followed by what is named after it: bowl, bowl_as_published; others by name."""

    def key(name: str) -> tuple[bool, float, str]:
        parts = name.split("_")
        stems: Sequence[str] = ["_".join(parts[:length]) for length in range(len(parts), 0, -1)]
        place = next((places[stem] for stem in stems if stem in places), None)
        return place is None, place or 0.0, name

    return sorted(names, key=key)
