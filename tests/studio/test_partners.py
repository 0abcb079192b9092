"""The searchers as partners, and what is saved: a run folder like any other."""

from __future__ import annotations

import csv
import json
from pathlib import Path
from typing import Any

import pytest

import origami_lab
from origami_lab.cli import main
from origami_lab.errors import InputError
from origami_lab.game import Extend
from origami_lab.objectives import BucketObjective
from origami_lab.search import BreadthFirstSearch, NeighbourhoodSearch, RandomSearch
from origami_lab.studio.board_telling import spoken
from origami_lab.studio.design_board import DesignBoard
from origami_lab.studio.design_figures import measure_design
from origami_lab.studio.design_saving import ToSave, save_design
from origami_lab.studio.opening import Opened, open_design
from origami_lab.studio.partner_search import FoundDesign, Partner, SearchProgress
from tests.known_designs.game_moves import cube

BUDGET = 3000


@pytest.fixture(scope="module")
def opened() -> Opened:
    return open_design(["target=cube"])


@pytest.fixture
def board(opened: Opened) -> DesignBoard:
    """The cube with its walls, and without its lid."""
    game, moves = opened.game, cube()[1]
    return DesignBoard(game, opened.objective, game.finished_actions(game.replay_moves(moves[:2])))


class Ear:
    """Hears a partner, and stops it after so many designs."""

    def __init__(self, most: int = 10**9) -> None:
        self.found: list[FoundDesign] = []
        self.progress: list[SearchProgress] = []
        self.most = most

    def __call__(self, what: Any) -> None:
        (self.found if isinstance(what, FoundDesign) else self.progress).append(what)

    def stop(self) -> bool:
        return len(self.found) >= self.most


def partner(opened: Opened, ear: Ear) -> Partner:
    return Partner(opened.settings, opened.game, opened.objective, ear, ear.stop)


def worth(board: DesignBoard) -> tuple[float, int]:
    score = board.score()
    assert score is not None
    return score.value, score.angle


def is_what_it_says(board: DesignBoard, found: FoundDesign) -> None:
    """A design is played move by move on a board of its own, and is worth what was said."""
    other = DesignBoard(board.game, board.objective)
    actions = board.game.finished_actions(board.game.replay_moves(found.moves))
    other.adopt(actions, "test")
    value, angle = worth(other)
    assert value >= found.value - 1e-12
    assert angle == found.angle or value > found.value


@pytest.mark.parametrize("make", [NeighbourhoodSearch, BreadthFirstSearch, RandomSearch])
def test_finish_keeps_all_that_is_there(opened: Opened, board: DesignBoard, make: Any) -> None:
    ear, present = Ear(), worth(board)
    partner(opened, ear).finish(board.actions, present, make, BUDGET, 0)
    assert ear.progress[-1].interactions <= BUDGET
    if make is NeighbourhoodSearch:
        assert ear.found[-1].value == pytest.approx(-0.00225, abs=1e-5)  # the known optimum
    values = [present[0], *(found.value for found in ear.found)]
    assert values == sorted(values)
    for found in ear.found:
        assert found.moves[: len(board.moves)] == board.moves
        is_what_it_says(board, found)


@pytest.mark.parametrize("make", [NeighbourhoodSearch, BreadthFirstSearch])
def test_improve_finds_better_ones_only_and_stops_when_told(opened: Opened, board: DesignBoard, make: Any) -> None:
    ear, present = Ear(most=1), worth(board)
    partner(opened, ear).improve(board.actions, present, make, 20_000, 0)
    assert len(ear.found) <= 2
    for found in ear.found:
        assert found.value > present[0]
        is_what_it_says(board, found)
    if make is NeighbourhoodSearch:
        assert ear.found
        assert ear.progress[-1].interactions < 20_000
    board.terminate()  # a design that was ended is improved as it was
    again = Ear(most=1)
    partner(opened, again).improve(board.actions, present, make, 20_000, 0)
    assert [found.value for found in again.found] == [found.value for found in ear.found]


def test_repair_changes_nothing_but_what_hangs_on_the_region(opened: Opened) -> None:
    game, moves = opened.game, cube()[1]
    other = Extend((-3, 1), -1, (-2, 2), (-4, 1), (-3, 3))  # a lid that does not fit
    worse = game.finished_actions(game.replay_moves([*moves[:3], other]))
    board, ear = DesignBoard(game, opened.objective, worse), Ear()
    partner(opened, ear).repair(board.actions, worth(board), NeighbourhoodSearch, BUDGET, 0, [(-3, 1), (3, 3)])
    assert ear.found[-1].value == pytest.approx(-0.00225, abs=1e-5)
    for found in ear.found:
        assert found.moves[:3] == tuple(moves[:3])
        is_what_it_says(board, found)
    with pytest.raises(InputError, match="region"):
        partner(opened, ear).repair(board.actions, None, NeighbourhoodSearch, BUDGET, 0, [(4, 4)])


def test_suggestions_are_legal_next_moves_best_first(opened: Opened, board: DesignBoard) -> None:
    suggested = partner(opened, Ear()).suggest(board.actions, NeighbourhoodSearch, 6000, 0)
    assert 1 <= len(suggested) <= 5
    assert [value for _, value, _ in suggested] == sorted((value for _, value, _ in suggested), reverse=True)
    assert len({spoken(move) for move, _, _ in suggested}) == len(suggested)
    before = board.actions
    for move, value, found in suggested:
        assert found.value == value
        assert move in found.moves[len(board.moves) :]
        board.play_move(move)
        board.undo()
        assert board.actions == before


def test_any_objective_and_an_empty_board() -> None:
    opened = open_design(["objective=bucket", "board.size=9"])
    ear = Ear()
    whole = Partner(opened.settings, opened.game, BucketObjective(), ear, ear.stop)
    whole.finish(opened.game.start_actions, None, NeighbourhoodSearch, BUDGET, 0)
    whole.improve(opened.game.start_actions, None, RandomSearch, BUDGET, 0)
    assert ear.found
    is_what_it_says(DesignBoard(opened.game, BucketObjective()), ear.found[-1])


def test_figures_and_where_it_is_furthest(opened: Opened, board: DesignBoard) -> None:
    """Without its lid the cube's top is furthest in its middle: half of √2 from each wall, at height 2."""
    value, angle = worth(board)
    found = measure_design(opened.game, opened.objective, board.actions, angle)
    assert found.figures["return_vertex"] == value
    assert found.sharpest == pytest.approx(45)
    assert found.narrowest == pytest.approx(1)
    assert found.target is not None
    assert found.sheet is not None
    assert found.target.distance == pytest.approx(-value, abs=1e-6)
    assert found.target.at == pytest.approx((0, 0, 2), abs=0.05)
    assert found.sheet.distance < 0.01


@pytest.fixture(scope="module")
def saved(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """The whole cube, saved twice: the second time over the first."""
    opened = open_design(["target=cube"])
    path = tmp_path_factory.mktemp("saved") / "cube-1"
    game, moves = opened.game, cube()[1]
    for count in (2, 4):
        board = DesignBoard(game, opened.objective, game.finished_actions(game.replay_moves(moves[:count])))
        history = [{"step": "extension", "moves": count}]
        made = ToSave(path, board.actions, *worth(board), 100 + count, 3.5, history)
        save_design(opened.settings, game, opened.objective, opened.target, made)
    return path


@pytest.mark.slow
def test_what_is_saved_is_a_run_folder(saved: Path, capsys: pytest.CaptureFixture[str], tmp_path: Path) -> None:
    result = origami_lab.load(saved)
    assert result.exit_code == 0
    [row] = list(csv.DictReader((saved / "trials.csv").open()))
    assert float(row["return"]) == pytest.approx(-0.00225, abs=1e-5)
    assert (row["status"], row["certificate"], row["interactions"]) == ("ok", "certified", "104")
    assert json.loads((saved / "seed=0/history.json").read_text()) == [{"step": "extension", "moves": 4}]
    assert main(["verify", str(saved / "seed=0/best.fold")]) == 0
    assert main(["export", str(saved / "seed=0"), "--to", "svg,stl", "--output", str(tmp_path)]) == 0
    assert sorted(file.suffix for file in tmp_path.iterdir()) == [".stl", ".svg"]
    assert main(["report", str(saved), "--output", str(tmp_path / "report")]) == 0
    assert "studio" in (tmp_path / "report/index.html").read_text()
    store = f"sqlite:///{tmp_path / 'mlflow.db'}"
    assert main(["dashboard", "--sync", str(saved), "--uri", store]) == 0
    capsys.readouterr()


@pytest.mark.slow
def test_a_search_goes_on_from_it_and_the_studio_opens_it_again(saved: Path, tmp_path: Path) -> None:
    for words in ([str(saved)], [str(saved / "seed=0")], [str(saved / "seed=0/best.fold")]):
        again = open_design(words)
        board = DesignBoard(again.game, again.objective, again.actions)
        assert worth(board)[0] == pytest.approx(-0.00225, abs=1e-5)
    settings = ["target=cube", "start=file", f"start.path={saved / 'seed=0'}", "search=rdm", "budget=200", "seed=0"]
    done = origami_lab.run(
        [*settings, f"output={tmp_path / 'on'}", "tracking=none", "files=designs", "verbosity=quiet"]
    )
    assert done.exit_code == 0


def test_it_is_not_run_again(saved: Path, capsys: pytest.CaptureFixture[str]) -> None:
    for words in ([str(saved / "config.yaml")], [str(saved / "config.yaml"), f"output={saved}", "resume=true"]):
        assert main([*words, "tracking=none"]) == 2
        [line] = capsys.readouterr().err.splitlines()
        assert "a design made by hand cannot be run again" in line
        assert "origami-lab studio" in line
    assert main(["target=cube", "tracking=none", f"output={saved}", "resume=true"]) == 2
    [line] = capsys.readouterr().err.splitlines()
    assert "cannot be resumed with other settings" in line


@pytest.mark.parametrize(
    ("words", "says"),
    [
        (["nowhere"], "must be settings like target=bowl, or a file or folder that exists"),
        (["target=bawl"], "target=bawl"),
        ([".", "/"], "one too many"),
        (["."], "must be the folder of a run"),
    ],
)
def test_what_cannot_be_opened(words: list[str], says: str, tmp_path: Path, monkeypatch: pytest.MonkeyPatch) -> None:
    monkeypatch.chdir(tmp_path)
    with pytest.raises(InputError) as error:
        open_design(words)
    assert says in str(error.value)
