"""PPO: what its learner is made of and fed with, and that it leaves the process as it was."""

from __future__ import annotations

import random
from importlib import util
from pathlib import Path
from typing import Any

import numpy as np
import pytest

from origami_lab.cli import main
from origami_lab.errors import InputError
from origami_lab.game.game import Game
from origami_lab.game.observation import view_of
from origami_lab.game.start_patterns import Square
from origami_lab.objectives.shape import ShapeObjective
from origami_lab.search.ppo import ProximalPolicyOptimization
from origami_lab.search.problem import Problem
from origami_lab.search.rl_episodes import Episodes
from origami_lab.targets.solids import bowl, cube


@pytest.fixture
def torch() -> Any:
    pytest.importorskip("sb3_contrib", reason="needs the extra ppo")
    return pytest.importorskip("torch", reason="needs the extra ppo")


def test_without_its_extra_it_says_how_to_install_it(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    found = util.find_spec
    monkeypatch.setattr("origami_lab.search.ppo.find_spec", lambda name: None if name == "torch" else found(name))
    monkeypatch.chdir(tmp_path)
    assert main(["target=pyramid", "search=ppo", "tracking=none", "output=out"]) == 2
    error = capsys.readouterr().err
    assert error.count("\n") == 1
    assert "search=ppo: needs" in error
    assert "pip install 'origami-lab[ppo]'" in error
    assert not list(tmp_path.iterdir())


def cube_problem(budget: int) -> Problem:
    return Problem(Game(9, "xy", Square(1), max_crease_length=2), ShapeObjective(cube()), budget)


@pytest.mark.usefixtures("torch")
@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"observation": "picture"}, r"search\.observation=picture: must be one of compact, tensor"),
        ({"games": 7}, r"search\.games=7: must divide search\.batch=2050"),
        ({"layers": []}, r"search\.layers"),
        ({"layers": [256, 0]}, r"search\.layers"),
        ({"minibatch": 4000}, r"search\.minibatch"),
        ({"gamma": 1.5}, r"search\.gamma"),
        ({"vertices": 0}, r"search\.vertices"),
    ],
)
def test_bad_numbers_are_refused(arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError, match=message):
        ProximalPolicyOptimization(**arguments)


@pytest.mark.usefixtures("torch")
def test_the_whole_tensor_of_a_large_board_is_refused_with_advice() -> None:
    game = Game(25, "xyd", Square("choose"), max_crease_length=2.9)
    problem = Problem(game, ShapeObjective(bowl()), 100)
    searcher = ProximalPolicyOptimization(observation="tensor", vertices=None)
    with pytest.raises(InputError, match=r"search\.observation=tensor: 391,875 numbers .* search\.vertices=64"):
        searcher.search(problem, np.random.default_rng(0))
    assert problem.interactions == 0


@pytest.mark.usefixtures("torch")
def test_the_command_refuses_it_before_anything_is_written(
    monkeypatch: pytest.MonkeyPatch, capsys: pytest.CaptureFixture[str], tmp_path: Path
) -> None:
    monkeypatch.chdir(tmp_path)
    whole = ["search=ppo", "search.observation=tensor", "search.vertices=null"]
    assert main(["target=bowl", *whole, "tracking=none", "output=out"]) == 2
    error = capsys.readouterr().err
    assert error.startswith("error: search.observation=tensor: 391,875 numbers")
    assert error.count("\n") == 1
    assert not list(tmp_path.iterdir())


@pytest.mark.parametrize("observation", ["compact", "tensor"])
def test_it_plays_with_either_observation_and_leaves_no_trace(torch: Any, observation: str) -> None:
    """More than one update; the global generators, torch's threads and its checks are as they were."""
    searcher = ProximalPolicyOptimization(observation, 30, batch=120, games=4, epochs=2, layers=[16])
    threads = torch.get_num_threads()
    torch.set_num_threads(2)
    try:
        random.seed(1)
        np.random.seed(2)  # noqa: NPY002
        torch.manual_seed(3)
        expected = random.random(), np.random.random(), float(torch.rand(1))  # noqa: NPY002
        random.seed(1)
        np.random.seed(2)  # noqa: NPY002
        torch.manual_seed(3)
        problem = cube_problem(500)
        searcher.search(problem, np.random.default_rng(0))
        assert (random.random(), np.random.random(), float(torch.rand(1))) == expected  # noqa: NPY002
        assert torch.get_num_threads() == 2
    finally:
        torch.set_num_threads(threads)
    assert problem.interactions == 500
    assert problem.episodes > 20


@pytest.mark.usefixtures("torch")
def test_the_learner_has_the_papers_numbers() -> None:
    from origami_lab.search.ppo_learner import isolated, learner

    problem = cube_problem(1)
    settings = ProximalPolicyOptimization()
    with isolated(0):
        names = (
            "layers",
            "batch",
            "games",
            "epochs",
            "minibatch",
            "entropy",
            "learning_rate",
            "clip",
            "gamma",
            "gae_lambda",
        )
        numbers = {name: getattr(settings, name) for name in names}
        model = learner(Episodes(problem, settings.games, view_of(problem.game)), **numbers)
    assert model.n_steps * model.n_envs == 2050
    assert (model.batch_size, model.ent_coef) == (64, 0.01)
    assert model.policy.net_arch == [256, 256]
    shapes = {tuple(parameter.shape) for parameter in model.policy.parameters()}
    assert {(256, 380), (256, 256), (82, 256), (1, 256)} <= shapes
    assert model.action_space.n == 3 * 25 + 5 + 2  # three for each of 25 playable points, of the game's 250


@pytest.mark.slow
@pytest.mark.usefixtures("torch")
def test_it_learns() -> None:
    """To fold with few vertices is soon learnt: the last episodes are better than the first."""
    returns: list[float] = []

    class Noted(Problem):
        def finish(self, positions: Any, i: int, *, above: float | None = None) -> float:
            returns.append(super().finish(positions, i, above=above))
            return returns[-1]

    class FewVertices:
        def score(self, sheet: Any) -> float:
            return -float(len(sheet.flat))

    problem = Noted(Game(9, "xy", Square(1), max_crease_length=2), FewVertices(), 6000, certify=False)
    searcher = ProximalPolicyOptimization(batch=500, games=5, layers=[64], learning_rate=2e-3)
    searcher.search(problem, np.random.default_rng(0))
    tenth = len(returns) // 10
    assert np.mean(returns[-tenth:]) > np.mean(returns[:tenth]) + 1
