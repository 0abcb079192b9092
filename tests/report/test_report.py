"""The whole report on a real run: its files, its page, the same bytes every time."""

from __future__ import annotations

import base64
import csv
import io
import os
import re
import shutil
import subprocess
import sys
from dataclasses import replace
from html.parser import HTMLParser
from pathlib import Path

import numpy as np
import pytest
from PIL import Image

from origami_lab.cli import main
from origami_lab.drawing.scene import BACK, FRONT
from origami_lab.fold_format.reader import read_fold
from origami_lab.report.design_files import write_designs
from origami_lab.report.gallery import Shape
from origami_lab.report.run_groups import Heading
from origami_lab.report.run_reader import Trial
from origami_lab.runs.trial_row import read_trials
from tests.drawing.test_viewer import in_chromium, visit
from tests.report.runs import trial, write_run
from tests.small_runs import SMALL, run

TABLES = {f"{name}.{kind}" for name in ("returns", "interactions") for kind in ("md", "csv", "tex")}


class Loads(HTMLParser):
    """All that a page would load, and its text."""

    def __init__(self, page: str) -> None:
        super().__init__()
        self.loads: list[str] = []
        self.tags: set[str] = set()
        self.text = ""
        self.feed(page)

    def handle_starttag(self, tag: str, attrs: list[tuple[str, str | None]]) -> None:
        self.tags.add(tag)
        self.loads += [value or "" for name, value in attrs if name in ("src", "href", "srcset", "data", "poster")]

    def handle_data(self, data: str) -> None:
        self.text += data


@pytest.fixture(scope="module")
def results(tmp_path_factory: pytest.TempPathFactory) -> Path:
    """A folder with a real run, the same under another name, one by hand without designs, and the report on them."""
    folder = tmp_path_factory.mktemp("report")
    assert run(folder, *SMALL, "seed=0..1", "workers=1", "tracking=none", "output=results/pyramid/rdm") == 0
    copy = folder / "results/pyramid/dfts"
    shutil.copytree(folder / "results/pyramid/rdm", copy)
    config = (copy / "config.yaml").read_text(encoding="utf-8")
    (copy / "config.yaml").write_text(config.replace("method: rdm", "method: dfts"), encoding="utf-8")
    write_run(folder / "results/cube/<b>", "cube", "rdm", [trial(-1.0), trial(-2.0)])
    assert run(folder, "report", "results", "--beside", "paper") == 0
    return folder / "results"


def test_all_files_are_there_and_whole(results: Path) -> None:
    report = results / "report"
    assert {path.name for path in report.iterdir()} == {*TABLES, "index.html", "figures", "designs", "files.json"}
    figures = {path.name for path in (report / "figures").iterdir()}
    expected = {"gallery", "learning-pyramid", "learning-cube", "solved-pyramid", "solved-cube"}
    expected |= {"pattern-pyramid", "motion-pyramid"}
    assert figures == {f"{name}.{kind}" for name in expected for kind in ("png", "svg")}
    for name in figures:
        path = report / "figures" / name
        if path.suffix == ".png":
            with Image.open(path) as image:
                assert len(image.convert("RGB").getcolors(image.width * image.height)) > 20
        else:
            assert path.read_text(encoding="utf-8").rstrip().endswith("</svg>")


def test_the_table_says_what_the_runs_say(results: Path) -> None:
    with (results / "report/returns.csv").open(newline="", encoding="utf-8") as file:
        lines = [line for line in csv.DictReader(file) if line["table"] == "returns"]
    for method in ("rdm", "dfts"):
        values = [row.return_ for row in read_trials(results / "pyramid" / method / "trials.csv")]
        [line] = [line for line in lines if (line["row"], line["column"]) == (method, "pyramid")]
        assert float(line["mean"]) == pytest.approx(np.mean(values))
        assert float(line["std"]) == pytest.approx(np.std(values, ddof=1))


def test_the_page_loads_nothing_from_elsewhere(results: Path) -> None:
    text = (results / "report/index.html").read_text(encoding="utf-8")
    page = Loads(text)
    assert page.tags.isdisjoint({"script", "link", "iframe", "object", "base"})
    links = [load for load in page.loads if not load.startswith(("data:image/", "#"))]
    designs = {f"designs/{path.name}" for path in (results / "report/designs").iterdir()}
    assert set(links) | {"designs/viewer.js"} == designs
    assert len(designs) == 2 * 3 + 1
    assert "certified" in page.text
    assert not re.search(r"url\(|@import|https?://", text)
    pictures = [load.partition(";base64,") for load in page.loads if load.startswith("data:")]
    drawn = {"png": 0, "svg": 0}
    for kind, _, content in pictures:
        data = base64.b64decode(content, validate=True)
        if kind == "data:image/png":
            with Image.open(io.BytesIO(data)) as image:
                image.load()
            drawn["png"] += 1
        else:
            svg = data.decode("utf-8")
            assert kind == "data:image/svg+xml"
            assert all(link.startswith("#") for link in re.findall(r'href="([^"]*)"', svg))
            drawn["svg"] += 1
    assert drawn == {"png": 2 + 5, "svg": 2 * 2 + 1}  # shapes and motion; curves and a pattern


def test_the_page_names_what_it_is_made_from(results: Path) -> None:
    page = Loads((results / "report/index.html").read_text(encoding="utf-8"))
    assert "../pyramid/rdm" in page.text
    assert "../cube/<b>/seed=0: not in the gallery" in page.text  # a name is no markup
    assert "origami-lab target=pyramid search=rdm" in page.text
    assert "numba" in page.text
    assert str(results) not in page.text


def test_the_shapes_are_drawn_from_the_designs(results: Path) -> None:
    page = Loads((results / "report/index.html").read_text(encoding="utf-8"))
    png = [load.partition(",")[2] for load in page.loads if load.startswith("data:image/png")]
    for content in png[:2]:
        with Image.open(io.BytesIO(base64.b64decode(content))) as image:
            pixels = np.asarray(image.convert("RGB"), dtype=np.float64).reshape(-1, 3)
        # paper of either side, lit: its colour up to brightness
        unit = pixels / np.linalg.norm(pixels, axis=1, keepdims=True).clip(1)
        sides = np.array([FRONT, BACK]) / np.linalg.norm([FRONT, BACK], axis=1, keepdims=True)
        assert np.mean((unit @ sides.T).max(axis=1) > 0.997) > 0.03


@pytest.mark.slow
def test_the_same_runs_make_the_same_bytes(results: Path, tmp_path: Path) -> None:
    shutil.copytree(results, tmp_path / "moved", ignore=shutil.ignore_patterns("report"))
    command = [sys.executable, "-m", "origami_lab", "report", "moved", "--beside", "paper"]
    environment = {**os.environ, "PYTHONHASHSEED": "7", "SOURCE_DATE_EPOCH": "1"}
    environment["PYTHONPATH"] = str(Path(__file__).parents[2])
    subprocess.run(command, cwd=tmp_path, env=environment, check=True, capture_output=True)
    first, second = results / "report", tmp_path / "moved/report"
    names = sorted(path.relative_to(first) for path in first.rglob("*") if path.is_file())
    assert names == sorted(path.relative_to(second) for path in second.rglob("*") if path.is_file())
    assert len(names) > 15
    for name in names:
        assert (first / name).read_bytes() == (second / name).read_bytes(), name


def test_a_report_is_written_again_and_nothing_else_is_overwritten(
    tmp_path: Path, capsys: pytest.CaptureFixture[str]
) -> None:
    write_run(tmp_path / "runs/a", "cube", "rdm", [trial(0.0), trial(0.0)])
    out = tmp_path / "out"
    arguments = ["report", str(tmp_path / "runs"), "--output", str(out)]
    assert main(arguments) == 0
    assert (out / "figures/learning-cube.svg").is_file()
    assert not (out / "figures/solved-cube.svg").exists()
    note = "cube: no curve of solved trials, the first design of each is as good as any"
    assert note in (out / "index.html").read_text(encoding="utf-8")
    assert f"note: {note}\n" in capsys.readouterr().err
    shutil.rmtree(tmp_path / "runs/a")
    write_run(tmp_path / "runs/b", "bowl", "rdm", [trial(-1.0)])
    assert main([*arguments, "--solved", "-1.5"]) == 0
    assert not (out / "figures/learning-cube.svg").exists()
    assert (out / "figures/solved-bowl.svg").is_file()
    capsys.readouterr()
    other = tmp_path / "other"
    other.mkdir()
    (other / "index.html").write_text("mine", encoding="utf-8")
    (tmp_path / "file").touch()
    for name, why in (("other", "must be a new or empty folder"), ("file", "must be a folder that can be written")):
        assert main([*arguments[:3], str(tmp_path / name)]) == 2
        assert why in capsys.readouterr().err
    assert [path.name for path in other.iterdir()] == ["index.html"]
    assert (other / "index.html").read_text(encoding="utf-8") == "mine"
    assert main([*arguments, "--solved", "nan"]) == 2
    assert main(["report", "--help"]) == 0
    assert main(["report"]) == 2


def test_what_a_folder_lacks_is_said(results: Path, tmp_path: Path, capsys: pytest.CaptureFixture[str]) -> None:
    shutil.copytree(results / "pyramid/rdm", tmp_path / "runs/rdm")
    for path in (tmp_path / "runs/rdm").glob("seed=*/motion.fold"):
        path.unlink()
    shutil.copytree(tmp_path / "runs/rdm", tmp_path / "designs/rdm")
    config = tmp_path / "designs/rdm/config.yaml"
    config.write_text(config.read_text(encoding="utf-8").replace("files: all", "files: designs"), encoding="utf-8")
    (tmp_path / "runs/rdm/target.ply").write_bytes(b"ply")
    shutil.copytree(results / "pyramid/dfts", tmp_path / "runs/dfts")
    for path in (tmp_path / "runs/dfts").glob("seed=*/*.fold"):
        path.write_text("{}", encoding="utf-8")
    assert main(["report", str(tmp_path / "runs")]) == 0
    notes = capsys.readouterr().err
    assert re.search(r"runs/dfts/seed=\d: not in the gallery \(best.fold", notes)
    assert re.search(r"runs/rdm: drawn without its target", notes)
    assert re.search(r"runs/rdm/seed=\d: its motion is drawn in fewer steps \(there is no motion.fold\)", notes)
    assert (tmp_path / "runs/report/figures/motion-pyramid.png").is_file()
    assert main(["report", str(tmp_path / "designs")]) == 0
    notes = capsys.readouterr().err
    assert re.search(r"its motion is drawn in fewer steps \(files=designs leaves out motion.fold\)", notes)
    assert "No such file" not in notes
    assert (tmp_path / "designs/report/figures/motion-pyramid.png").is_file()


@in_chromium
@pytest.mark.slow
def test_a_gallery_of_many_searchers_fits_the_page(results: Path, tmp_path: Path) -> None:
    text = (results / "report/index.html").read_text(encoding="utf-8")
    figures = re.compile(r'(?<=<div class="shapes">).*?(?=</div>\n)', re.DOTALL)
    [row] = (found for found in figures.findall(text) if "turn and fold" in found)
    text = figures.sub(row * 6, text)  # a picture of each of two searchers, one a row without a picture
    script = "<script>document.title = [...document.querySelectorAll('.shapes, .shapes figure')].map(e => "
    script += "[e.scrollWidth - e.clientWidth, e.getBoundingClientRect().right].join(':')).join(' ')</script>"
    (tmp_path / "page.html").write_text(text.replace("</body>", f"{script}</body>"), encoding="utf-8")
    for width in (1400, 500):
        title = re.search(
            r"<title>(.*?)</title>", visit(tmp_path / "page.html", "--dump-dom", f"--window-size={width},900")
        )
        assert title is not None
        boxes = [tuple(map(float, box.split(":"))) for box in title[1].split()]
        assert len(boxes) >= 1 + 2 * 6
        assert all(over <= 0 and right <= width for over, right in boxes)


def test_a_polished_design_has_a_page_of_its_own(results: Path, tmp_path: Path) -> None:
    folder = shutil.copytree(results / "pyramid/rdm", tmp_path / "run")
    row = read_trials(folder / "trials.csv")[0]
    place = (Heading("rdm", "rdm"), Heading("pyramid", "pyramid"))
    fold = read_fold(folder / f"seed={row.seed}/best.fold")
    for value, shown in ((None, ""), (-0.01, "polished −0.0100")):
        found = Trial(row.seed, replace(row, polished_return=value), folder)
        shape = Shape(found, fold, Image.new("RGB", (2, 2)), True)
        assert shape.polished == shown
        files: dict[str, str | bytes] = {}
        written = write_designs({place: shape}, lambda kind, label: "best", files)[place]
        assert written.polished is None  # there is no file of it
        shutil.copy(folder / f"seed={row.seed}/best.fold", folder / f"seed={row.seed}/polished.fold")
        written = write_designs({place: shape}, lambda kind, label: "best", files)[place]
        assert written.polished == (None if value is None else "designs/best-polished.html")
        assert (written.polished in files) == (value is not None)
        (folder / f"seed={row.seed}/polished.fold").unlink()
