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
from origami_lab.experiment.trial_pool import TrialPool
from origami_lab.game.game import Game
from origami_lab.game.observation import view_of
from origami_lab.game.start_patterns import Rectangle, Square
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
    monkeypatch.setattr(TrialPool, "checked_parts", lambda pool: None)  # the worker, which has torch, would make it
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
def test_it_plays_with_either_observation_and_leaves_no_trace(
    torch: Any, observation: str, monkeypatch: pytest.MonkeyPatch, tmp_path: Path
) -> None:
    """More than one update; the global generators, torch's threads, its checks and temporary files are as they were."""
    monkeypatch.setattr("tempfile.tempdir", str(tmp_path))
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
    assert not list(tmp_path.glob("SB3*"))  # torch keeps a cache of its own there


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
    networks = model.policy.networks
    assert networks.beginning.shape == (380, 2 * 256)
    assert [tuple(weight.shape) for weight, _ in networks.parts.policy] == [(256, 256), (82, 256)]
    assert [tuple(weight.shape) for weight, _ in networks.parts.value] == [(256, 256), (1, 256)]
    assert model.action_space.n == 3 * 25 + 5 + 2  # three for each of 25 playable points, of the game's 250


def played(problem: Problem, *, stock: bool, observation: str, **numbers: Any) -> tuple[Any, Any]:
    """A learner after three batches: ours, or MaskablePPO as it comes; and what it has found."""
    from sb3_contrib import MaskablePPO

    from origami_lab.search.ppo_environment import EpisodeVecEnv
    from origami_lab.search.ppo_learner import isolated, learner

    batch, games = numbers["batch"], numbers["games"]
    episodes = Episodes(problem, games, view_of(problem.game, observation, 20 if observation == "tensor" else None))
    with isolated(7):
        if stock:
            model = MaskablePPO(
                "MlpPolicy",
                EpisodeVecEnv(episodes),
                learning_rate=numbers["learning_rate"],
                n_steps=batch // games,
                batch_size=numbers["minibatch"],
                n_epochs=numbers["epochs"],
                gamma=numbers["gamma"],
                gae_lambda=numbers["gae_lambda"],
                clip_range=numbers["clip"],
                ent_coef=numbers["entropy"],
                policy_kwargs={"net_arch": numbers["layers"]},
                device="cpu",
            )
        else:
            model = learner(episodes, **numbers)
        model.learn(3 * batch)
    return model, problem.outcome()


@pytest.mark.parametrize("observation", ["compact", "tensor"])
def test_it_learns_what_sb3_contrib_learns(torch: Any, observation: str) -> None:
    """The same play and, up to rounding, the same weights after three updates as those of MaskablePPO.

    A narrow clipping range and a large step, so that ratios are clipped on both sides and gradients are, too.
    """
    numbers = {"layers": [24, 16], "batch": 300, "games": 4, "epochs": 4, "minibatch": 64}
    numbers |= {"entropy": 0.05, "learning_rate": 2e-3, "clip": 0.05, "gamma": 0.97, "gae_lambda": 0.9}
    theirs, expected = played(cube_problem(10_000), stock=True, observation=observation, **numbers)
    ours, found = played(cube_problem(10_000), stock=False, observation=observation, **numbers)
    assert found == expected
    networks, mlp = ours.policy.networks, theirs.policy.mlp_extractor
    weight, seen = torch.cat([net[0].weight for net in (mlp.policy_net, mlp.value_net)]).T, networks.seen
    close = {"rtol": 0, "atol": 1e-4}
    torch.testing.assert_close(networks.parts.weight[: len(seen)], weight[seen], **close)
    assert (weight[seen] - networks.beginning[seen]).abs().max() > 0.02
    unseen = np.setdiff1d(np.arange(len(weight)), seen)
    assert 0 < len(seen) < len(unseen)
    assert torch.equal(networks.beginning[unseen], weight[unseen])  # they have not moved
    bias = torch.cat([net[0].bias for net in (mlp.policy_net, mlp.value_net)])
    torch.testing.assert_close(networks.parts.bias, bias, **close)
    for parts, net, last in (
        (networks.parts.policy, mlp.policy_net, theirs.policy.action_net),
        (networks.parts.value, mlp.value_net, theirs.policy.value_net),
    ):
        for mine, other in zip(parts, [*net[2::2], last], strict=True):
            torch.testing.assert_close(mine, (other.weight, other.bias), **close)


@pytest.mark.usefixtures("torch")
def test_a_batch_may_leave_a_minibatch_of_one() -> None:
    """Of one interaction there is no standard deviation."""
    problem = cube_problem(200)
    ProximalPolicyOptimization(batch=65, games=5, minibatch=64, layers=[8], epochs=2).search(
        problem, np.random.default_rng(0)
    )
    assert problem.interactions == 200


def test_numbers_that_vanish_take_no_time_and_change_no_weight(torch: Any) -> None:
    """Weights whose gradient ends take the same steps, to the last bit, as those of which nothing is taken for zero."""
    from contextlib import nullcontext

    from origami_lab.search.ppo_learner import isolated, vanishing_as_zero

    def stepped(step: Any) -> tuple[Any, Any]:
        weights = torch.linspace(-1.0, 1.0, 64).requires_grad_()
        optimizer = torch.optim.Adam([weights], lr=1e-3, eps=1e-5, fused=True)
        for number in range(1200):
            weights.grad = torch.linspace(-1e-3, 2e-3, 64) if number < 3 else torch.zeros(64)
            with step():
                optimizer.step()
        return weights.detach(), optimizer.state[weights]["exp_avg"]

    with isolated(0):  # one thread, as the learner
        weights, moments = stepped(vanishing_as_zero)
        plain, tiny = stepped(nullcontext)
    assert 0.0 < float(tiny.abs().max()) < float(np.finfo(np.float32).tiny), "so that there is something to be zero"
    assert not moments.any()
    assert torch.equal(weights, plain)
    assert float(torch.tensor(1e-38) * 0.1) > 0.0, "what others reckon is as it was"


class Memory:
    """Checkpoints that are all kept, one before each batch."""

    def __init__(self, content: bytes | None = None) -> None:
        self.content, self.kept, self.due = content, list[bytes](), True

    def write(self, content: bytes) -> None:
        self.kept.append(content)

    def read(self) -> bytes | None:
        return self.content


@pytest.mark.parametrize("observation", ["compact", "tensor"])
@pytest.mark.usefixtures("torch")
def test_a_search_that_was_killed_goes_on_to_the_same_bits(observation: str) -> None:
    """From whichever save, in the middle of its episodes; and from what was saved after it went on."""
    searcher = ProximalPolicyOptimization(observation, 20, batch=130, games=5, epochs=2, layers=[16])
    game, objective = Game(9, "y", Rectangle(), max_crease_length=4, source_action="boundary"), ShapeObjective(cube())

    def search(content: bytes | None, checkpoints: bool = True) -> tuple[Any, list[bytes]]:
        memory = Memory(content)
        problem = Problem(game, objective, 1000, checkpoints=memory if checkpoints else None)
        searcher.search(problem, np.random.default_rng(3))
        return problem.outcome(), memory.kept

    plain, _ = search(None, checkpoints=False)
    whole, kept = search(None)
    assert whole == plain
    assert len(kept) == 8  # before each of the batches, the first included
    for save in (1, 4, 7):
        again, later = search(kept[save])
        assert again == whole
        assert later == kept[save:]


@pytest.mark.usefixtures("torch")
@pytest.mark.parametrize("content", [b"", b"PK", b"\x80\x04."])
def test_a_save_that_cannot_be_read_counts_as_none(content: bytes) -> None:
    problem, expected = (Problem(cube_problem(1).game, ShapeObjective(cube()), 300) for _ in range(2))
    searcher = ProximalPolicyOptimization(batch=130, games=5, epochs=2, layers=[16])
    searcher.search(expected, np.random.default_rng(3))
    problem._saves = Memory(content)
    searcher.search(problem, np.random.default_rng(3))
    assert problem.outcome() == expected.outcome()


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
