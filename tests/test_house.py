"""The tree explains itself: public names resolve, names have one meaning, the wheel holds what is tracked."""

from __future__ import annotations

import ast
import importlib
import random
import re
import subprocess
import sys
from collections import defaultdict
from pathlib import Path

import pytest
import yaml

from origami_lab import jit

ROOT = Path(__file__).parents[1]
PACKAGE = ROOT / "origami_lab"
STUBS = sorted(PACKAGE.rglob("__init__.pyi"))
MODULES = [file for file in sorted(PACKAGE.rglob("*.py")) if file.name != "__init__.py"]


def dotted(folder: Path) -> str:
    return ".".join(folder.relative_to(ROOT).parts)


def public_names() -> list[str]:
    """Dotted paths of all that a package exports."""
    found = []
    for stub in STUBS:
        for node in ast.parse(stub.read_text(encoding="utf-8")).body:
            if isinstance(node, ast.ImportFrom):
                found += [f"{dotted(stub.parent)}.{alias.name}" for alias in node.names]
    return found


def targets(node: object) -> list[str]:
    """All ``_target_`` in a configuration."""
    if isinstance(node, dict):
        own = [str(value) for key, value in node.items() if key == "_target_"]
        return own + [name for value in node.values() for name in targets(value)]
    return [name for item in node for name in targets(item)] if isinstance(node, list) else []


CONFIGURED = sorted(
    {name for file in (ROOT / "conf").rglob("*.yaml") for name in targets(yaml.safe_load(file.read_text("utf-8")))}
)
RESOLVE = """
import importlib, sys
for path in sys.argv[1:]:
    package, _, name = path.rpartition(".")
    value = getattr(importlib.import_module(package), name)
    assert not isinstance(value, type(sys)), f"{path} is a module"
"""


@pytest.mark.slow
@pytest.mark.parametrize("seed", [0, 1, 2])
def test_public_names_resolve_in_any_order(seed: int) -> None:
    pytest.importorskip("gymnasium", reason="needs the extra gym")
    names = public_names() + CONFIGURED
    random.Random(seed).shuffle(names)
    done = subprocess.run([sys.executable, "-c", RESOLVE, *names], capture_output=True, text=True, cwd="/", check=False)
    assert done.returncode == 0, done.stderr


def test_configurations_use_public_names() -> None:
    assert len(CONFIGURED) > 20
    assert set(CONFIGURED) <= set(public_names())


def test_a_package_exports_what_its_stub_says() -> None:
    for stub in STUBS:
        tree = ast.parse(stub.read_text(encoding="utf-8"))
        imported = [alias.name for node in tree.body if isinstance(node, ast.ImportFrom) for alias in node.names]
        [listed] = [node.value for node in tree.body if isinstance(node, ast.Assign)]
        assert sorted(ast.literal_eval(listed)) == sorted(imported), stub


def test_a_command_starts_its_worker_before_it_imports_kernels() -> None:
    """They take as long as all else until then, and the worker can import them meanwhile."""
    program = "import sys, origami_lab.experiment.api; sys.exit(bool({'numba', 'scipy'} & sys.modules.keys()))"
    done = subprocess.run([sys.executable, "-c", program], check=False, cwd=ROOT, env={"PYTHONPATH": str(ROOT)})
    assert done.returncode == 0


@pytest.mark.slow
def test_importing_searchers_brings_no_learner_and_compiles_nothing(tmp_path: Path) -> None:
    program = """
import sys
import origami_lab.search, origami_lab.objectives, origami_lab.targets, origami_lab.game
assert not {"torch", "gymnasium", "numba"} & sys.modules.keys()
from origami_lab.search import BreadthFirstSearch, ProximalPolicyOptimization
from origami_lab.objectives import ShapeObjective
assert not {"torch", "gymnasium", "mlflow", "hydra"} & sys.modules.keys()
"""
    done = subprocess.run(
        [sys.executable, "-c", program],
        capture_output=True,
        text=True,
        check=False,
        env={"NUMBA_CACHE_DIR": str(tmp_path), "PYTHONPATH": str(ROOT), "PATH": "/usr/bin"},
    )
    assert done.returncode == 0, done.stderr
    assert not list(tmp_path.rglob("*.nb[ic]"))


def test_no_module_bears_the_name_of_a_function_or_class_beside_it() -> None:
    for file in MODULES:
        names = {node.name for node in ast.parse(file.read_text(encoding="utf-8")).body if hasattr(node, "name")}
        assert not {name for name in names if not name.startswith("_")} & {
            beside.stem for beside in file.parent.glob("*.py") if dotted(file.parent) != "origami_lab.commands"
        }, file


def test_file_and_class_names_have_one_meaning() -> None:
    homes: dict[str, list[Path]] = defaultdict(list)
    for file in MODULES:
        homes[file.name].append(file)
        for node in ast.parse(file.read_text(encoding="utf-8")).body:
            if isinstance(node, ast.ClassDef):
                homes[node.name].append(file)
    assert {name: files for name, files in homes.items() if len(files) > 1} == {}


def test_the_cache_of_kernels_is_named_by_all_files_that_have_some() -> None:
    with_kernels = {
        file.relative_to(PACKAGE).parts[0]
        for file in MODULES
        if re.search(r"^@(kernel|inlined)\b", file.read_text(encoding="utf-8"), re.MULTILINE)
    }
    assert "geometry" in with_kernels
    assert with_kernels <= {*jit._WITH_KERNELS, "jit.py"}  # which is among them, too
    assert all((PACKAGE / name).is_dir() for name in jit._WITH_KERNELS)


def test_files_are_of_a_size_to_be_read() -> None:
    assert {file.name for file in MODULES if len(file.read_text(encoding="utf-8").splitlines()) > 400} == set()


PAGES = [ROOT / "README.md", ROOT / "CONTRIBUTING.md", *sorted((ROOT / "docs").glob("*.md"))]


@pytest.mark.parametrize("page", PAGES, ids=[page.name for page in PAGES])
def test_files_that_pages_name_are_there(page: Path) -> None:
    """Paths in backticks: from the project's root, the package, or the folder of the one named before."""
    text = page.read_text(encoding="utf-8")
    folder = ROOT
    for name in re.findall(r"`((?:[\w.-]+/)*[\w-]+\.py)`", re.sub(r"```.*?```", "", text, flags=re.DOTALL)):
        places = [base / name for base in (ROOT, PACKAGE, folder) if (base / name).is_file()]
        assert places or name in OF_THE_USER, f"{page}: {name}"
        folder = places[-1].parent if places else folder


OF_THE_USER = {"saddle.py", "tower.py", "climb.py", "mine.py"}
"""Files that a page tells its reader to write."""


def test_every_package_is_imported_by_its_whole_name() -> None:
    for stub in STUBS:
        assert importlib.import_module(dotted(stub.parent)).__doc__, stub


@pytest.mark.parametrize("file", MODULES, ids=lambda file: file.relative_to(ROOT).as_posix())
def test_a_module_says_what_it_is_and_takes_nothing_private(file: Path) -> None:
    tree = ast.parse(file.read_text(encoding="utf-8"))
    said = ast.get_docstring(tree) or ""
    assert " " in said.strip(), "its docstring is a sentence"
    for node in ast.walk(tree):
        if isinstance(node, ast.ImportFrom) and (node.module or "").startswith("origami_lab"):
            private = [alias.name for alias in node.names if alias.name.startswith("_") and alias.name != "__version__"]
            assert not private, f"{private} of {node.module}"
