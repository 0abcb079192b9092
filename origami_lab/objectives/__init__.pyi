"""Public names, and the modules that they live in; each is imported when it is first used."""

from .bucket import BucketObjective
from .chair import ChairObjective
from .compiled_objective import CompiledEvaluator, CompiledObjective
from .objective import Evaluator, Objective, Score, SheetEvaluator
from .packaging import PackagingObjective
from .shape import ShapeEvaluator, ShapeObjective
from .shelf import ShelfObjective
from .table import TableObjective

__all__ = [
    "BucketObjective",
    "ChairObjective",
    "CompiledEvaluator",
    "CompiledObjective",
    "Evaluator",
    "Objective",
    "PackagingObjective",
    "Score",
    "ShapeEvaluator",
    "ShapeObjective",
    "SheetEvaluator",
    "ShelfObjective",
    "TableObjective",
]
