"""The Gymnasium environment: Gymnasium's own checker, the rules of the game, pictures, and the vectorised form."""

from __future__ import annotations

import itertools
import subprocess
import sys
import warnings
from collections.abc import Iterator
from pathlib import Path
from typing import Any

import numpy as np
import pytest

gymnasium = pytest.importorskip("gymnasium", reason="needs the extra gym: pip install 'origami-lab[gym]'")

from gymnasium.error import Error, ResetNeeded  # noqa: E402
from gymnasium.utils.env_checker import check_env  # noqa: E402
from gymnasium.vector import AutoresetMode, SyncVectorEnv  # noqa: E402

from origami_lab.env import ENV_ID, RigidOrigamiEnv, RigidOrigamiVectorEnv  # noqa: E402
from origami_lab.errors import InputError  # noqa: E402
from origami_lab.game.game import Game  # noqa: E402
from origami_lab.game.start_patterns import Square  # noqa: E402
from origami_lab.objectives.shape import ShapeObjective  # noqa: E402
from origami_lab.targets.solids import pyramid  # noqa: E402

ROOT = Path(__file__).parents[2]


def parts() -> dict[str, Any]:
    # with sectors of π legal, random play hardly ever meets a vertex that cannot fold
    return {"game": Game(9, "xy", Square(1), straight_sectors=False), "objective": ShapeObjective(pyramid())}


def play(env: Any, rng: np.random.Generator) -> Iterator[tuple[Any, ...]]:
    """The steps of one episode of random play."""
    env.reset()
    for _ in itertools.count():
        step = env.step(rng.choice(np.flatnonzero(env.action_masks())))
        yield step
        if step[2]:
            return


@pytest.mark.parametrize("options", [{}, {"observation": "tensor"}, {"observation": "tensor", "vertices": 30}])
def test_gymnasium_has_nothing_to_say_against_it(options: dict[str, Any]) -> None:
    with warnings.catch_warnings():
        warnings.simplefilter("error")
        env = gymnasium.make(ENV_ID, overrides=["target=pyramid"], render_mode="rgb_array", **options)
        check_env(env.unwrapped)
        env.close()


def test_settings_are_the_commands() -> None:
    arguments = {"overrides": ["start.size=2"], "target": "bowl", "max_crease_length": 3}
    env = gymnasium.make("origami_lab.env:" + ENV_ID, **arguments).unwrapped
    assert (env.game.board_size, env.game.symmetry.name) == (25, "xyd")
    assert env.game.start == Square(2)
    assert float(env.game.rules.record["max_length_sq"][0]) == pytest.approx(9)
    assert env.action_space.n == env.game.rules.n_actions
    assert env.problem.objective.target.name == "bowl"
    assert RigidOrigamiEnv(observation="tensor").observation_space.shape == (9, 9, 83)  # the pyramid
    assert RigidOrigamiEnv(objective="table", max_crease_length=None).game.board_size == 13


@pytest.mark.parametrize(
    ("arguments", "message"),
    [
        ({"overrides": ["target=bowel"]}, "target=bowel"),
        ({"target": "bowl", "observation": "picture"}, "observation=picture: must be compact or tensor"),
        ({"target": "bowl", "render_mode": "human"}, "render_mode=human: must be rgb_array"),
        ({"overrides": "target=bowl"}, "overrides=target=bowl: must be a list of texts"),
        ({"game": Game(9, "xy", Square(1))}, "game="),
        ({"game": Game(9, "xy", Square(1)), "objective": object(), "target": "bowl"}, "overrides="),
    ],
)
def test_wrong_input_is_one_line(arguments: dict[str, Any], message: str) -> None:
    with pytest.raises(InputError) as caught:
        RigidOrigamiEnv(**arguments)
    assert message in str(caught.value)
    assert "\n" not in str(caught.value)


def test_an_episode_ends_with_its_return_and_its_actions() -> None:
    env, rng = RigidOrigamiEnv(**parts()), np.random.default_rng(0)
    best, statuses = -np.inf, set()
    for _ in range(60):
        *before, last = play(env, rng)
        info = last[4]
        assert all(step[4] == {} for step in before)
        total = sum(step[1] for step in [*before, last])
        assert total == pytest.approx(info["return"], rel=0, abs=1e-11)
        states = env.game.replay(info["actions"])
        statuses.add(info["status"])
        if info["status"] == "not foldable":
            assert info["return"] == env.game.penalty
        else:
            evaluator = env.problem.evaluator
            assert evaluator.score(states, evaluator.new_memos(1), 0).value == info["return"]
            best = max(best, info["return"])
    assert {"terminated", "not foldable"} <= statuses
    assert env.problem.outcome().value == best
    env.reset()
    *_, reward, ended, _, info = env.step(env.action_space.n - 3)
    assert (reward, ended, info["status"]) == (env.game.penalty, True, "illegal action")


def test_an_action_that_there_is_none_of_is_illegal() -> None:
    env, vector = RigidOrigamiEnv(**parts()), RigidOrigamiVectorEnv(3, **parts())
    vector.reset()
    assert vector.action_masks()[:, -1].all()  # to NumPy −1 is the last action
    actions = np.array([-1, -vector.game.rules.n_actions, vector.game.rules.n_actions])
    _, rewards, ended, _, infos = vector.step(actions)
    assert ended.all()
    assert infos["status"].tolist() == ["illegal action"] * 3
    for action, reward in zip(actions, rewards, strict=True):
        env.reset()
        _, *step, _, info = env.step(action)
        assert (step, info["status"]) == ([reward, True], "illegal action")
        assert reward == env.game.penalty


def test_an_action_that_is_no_whole_number_is_refused() -> None:
    env, vector = RigidOrigamiEnv(**parts()), RigidOrigamiVectorEnv(2, **parts())
    env.reset()
    vector.reset()
    with pytest.raises(TypeError):
        env.step(1.5)  # type: ignore[arg-type]
    with pytest.raises(ValueError, match="whole numbers, not float64"):
        vector.step(np.array([0.0, 1.5]))
    assert env.problem.interactions == vector.problem.interactions == 0


def test_a_step_needs_an_episode() -> None:
    env = RigidOrigamiEnv(**parts())
    with pytest.raises(ResetNeeded, match="reset"):
        env.step(0)
    for _ in play(env, np.random.default_rng(0)):
        pass
    played = env.problem.interactions
    with pytest.raises(ResetNeeded, match="reset"):
        env.step(0)
    assert env.problem.interactions == played
    env.reset()
    env.step(-1)
    with pytest.raises(ResetNeeded, match="reset"):
        env.step(0)


def at(x: int, y: int) -> int:
    """Number of a point on the 9×9 board."""
    return (y + 4) * 9 + x + 4


PYRAMID = [3 * 81 + 6, at(-1, 1), *(2 * 81 + at(*point) for point in ((0, 4), (-4, 0), (-2, 2))), 3 * 81]
"""The known design, whose return is a closed form: placement, leaf and mode, three locations, the end."""


def test_the_known_pyramid() -> None:
    env = RigidOrigamiEnv(target="pyramid", source_action=False)
    env.reset(seed=0)
    steps = [env.step(action) for action in PYRAMID]
    assert [step[2] for step in steps] == [False] * 5 + [True]
    assert steps[-1][4]["return"] == pytest.approx(-3 * np.sin(np.arccos(-1 / 3) - 1.884), abs=1e-9)
    assert steps[-1][4]["actions"] == tuple(PYRAMID)


def test_pictures_show_the_sheet() -> None:
    env = RigidOrigamiEnv(**parts(), render_mode="rgb_array")
    env.reset()
    frames = [env.render()]
    assert (frames[0] == 255).all()
    for action in PYRAMID[:5]:
        env.step(action)
        frames.append(env.render())
    changes = []
    for before, after in itertools.pairwise(frames):
        assert after.shape == before.shape == (450, 900, 3)
        changes.append(bool((after != before).any()))
    assert changes == [True, False, False, False, True]  # the square, then nothing until the extension is complete
    assert RigidOrigamiEnv(**parts()).render() is None


@pytest.mark.parametrize("mode", list(AutoresetMode))
def test_the_vector_form_is_many_single_ones(mode: AutoresetMode) -> None:
    """Step for step what Gymnasium makes of single environments."""
    count = 4
    vector = RigidOrigamiVectorEnv(count, **parts(), autoreset_mode=mode)
    single = SyncVectorEnv([lambda: RigidOrigamiEnv(**parts()) for _ in range(count)], autoreset_mode=mode)
    assert vector.metadata == single.metadata
    for space in ("observation_space", "action_space", "single_observation_space", "single_action_space"):
        assert getattr(vector, space) == getattr(single, space)
    rng = np.random.default_rng(7)
    same(vector.reset(seed=3), single.reset(seed=3))
    ends = 0
    for turn in range(250):
        masks = vector.action_masks()
        assert np.array_equal(masks, np.stack(single.call("action_masks")))
        actions = np.array([rng.choice(np.flatnonzero(mask)) if mask.any() else 0 for mask in masks])
        if turn % 50 == 20:
            actions[1] = int(np.flatnonzero(~masks[1])[0])  # illegal
        left, right = vector.step(actions), single.step(actions)
        same(left, right)
        over = left[2]
        ends += int(over.sum())
        if mode == AutoresetMode.DISABLED and over.any():
            with pytest.raises(ResetNeeded, match="have ended"):
                vector.step(actions)
            same(vector.reset(options={"reset_mask": over}), single.reset(options={"reset_mask": over}))
    assert ends > 20
    assert vector.problem.interactions == sum(problem.interactions for problem in single.get_attr("problem"))
    assert vector.problem.best_value == max(problem.best_value for problem in single.get_attr("problem"))


@pytest.mark.parametrize("mode", list(AutoresetMode))
def test_a_step_needs_an_action_and_an_episode_for_each_game(mode: AutoresetMode) -> None:
    vector = RigidOrigamiVectorEnv(3, **parts(), autoreset_mode=mode)
    with pytest.raises(ResetNeeded, match=r"\[0, 1, 2\]"):
        vector.step(np.zeros(3, dtype=np.int64))
    vector.reset(options={"reset_mask": np.array([True, False, True])})
    with pytest.raises(ResetNeeded, match=r"\[1\]"):
        vector.step(np.zeros(3, dtype=np.int64))
    before, _ = vector.reset()
    legal = int(np.flatnonzero(vector.action_masks()[0])[0])
    for actions in ([legal], [legal] * 5, [[legal] * 3], legal):
        with pytest.raises(ValueError, match="3 actions"):
            vector.step(np.array(actions))
    assert vector.problem.interactions == 0
    after, *_ = vector.step([legal] * 3)  # a list will do, as in SyncVectorEnv
    assert (after != before).any(axis=1).all()


def test_the_vector_form_takes_the_seeds_that_sync_vector_env_takes() -> None:
    vector = RigidOrigamiVectorEnv(3, **parts())
    single = SyncVectorEnv([lambda: RigidOrigamiEnv(**parts()) for _ in range(3)])
    for seed in (5, [1, 2, 3], [1, None, 3], (1, 2, 3), None):
        same(vector.reset(seed=seed), single.reset(seed=seed))
    for wrong, error in (([1, 2], ValueError), ([1, 2, 3, 4], ValueError), ([1, -2, 3], Error), (-1, Error)):
        for env in (vector, single):
            with pytest.raises(error):
                env.reset(seed=wrong)


@pytest.mark.parametrize("count", [0, -1, "3", 2.0, True, None])
def test_the_number_of_games_is_at_least_one(count: Any) -> None:
    with pytest.raises(InputError, match=f"num_envs={count}: must be a whole number, at least 1"):
        RigidOrigamiVectorEnv(count, **parts())


def same(left: Any, right: Any) -> None:
    assert type(left) is type(right)
    if isinstance(left, dict):
        assert left.keys() == right.keys()
        for key in left:
            same(left[key], right[key])
    elif isinstance(left, tuple | list):
        assert len(left) == len(right)
        for a, b in zip(left, right, strict=True):
            same(a, b)
    elif isinstance(left, np.ndarray) and left.dtype == object:
        same(left.tolist(), right.tolist())
    elif isinstance(left, np.ndarray):
        assert left.dtype == right.dtype
        assert np.array_equal(left, right)
    else:
        assert left == right


def test_make_vec_makes_it() -> None:
    vector = gymnasium.make_vec(ENV_ID, num_envs=3, target="pyramid", render_mode="rgb_array")
    assert isinstance(vector, RigidOrigamiVectorEnv)
    observations, infos = vector.reset(seed=1)
    assert observations.shape == vector.observation_space.shape == (3, 380)
    assert infos == {}
    assert [frame.shape for frame in vector.render()] == [(450, 900, 3)] * 3
    with pytest.raises(ValueError, match="reset_mask"):
        vector.reset(options={"reset_mask": np.array([True])})


def test_the_rest_does_without_gymnasium_and_torch() -> None:
    """What the command and a search import; and what the environment says where Gymnasium is missing."""
    program = """
import sys
sys.modules.update(dict.fromkeys(["gymnasium", "torch", "sb3_contrib", "stable_baselines3"]))
import origami_lab.experiment.trial_worker, origami_lab.search.ppo
import origami_lab.search.rl_episodes, origami_lab.game.observation
try:
    import origami_lab.env
except ImportError as error:
    print(error)
"""
    done = subprocess.run([sys.executable, "-c", program], capture_output=True, text=True, cwd=ROOT, check=True)
    assert done.stdout == "origami_lab.env needs Gymnasium: pip install 'origami-lab[gym]'\n"
