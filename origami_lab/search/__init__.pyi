"""Public names, and the modules that they live in; each is imported when it is first used."""

from .branch_and_bound import BreadthFirstSearch, DepthFirstSearch
from .evolution import EvolutionarySearch
from .mcts import MonteCarloTreeSearch
from .neighbourhood.given_design import state_of_design
from .neighbourhood.search import NeighbourhoodSearch
from .ppo import ProximalPolicyOptimization
from .problem import Improvement, LastingSearcher, Outcome, Positions, Problem, SearchEnded, Searcher
from .random_search import RandomSearch
from .random_stream import Draws
from .rl_episodes import Episodes

__all__ = [
    "BreadthFirstSearch",
    "DepthFirstSearch",
    "Draws",
    "Episodes",
    "EvolutionarySearch",
    "Improvement",
    "LastingSearcher",
    "MonteCarloTreeSearch",
    "NeighbourhoodSearch",
    "Outcome",
    "Positions",
    "Problem",
    "ProximalPolicyOptimization",
    "RandomSearch",
    "SearchEnded",
    "Searcher",
    "state_of_design",
]
