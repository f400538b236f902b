"""The recipes of CONTRIBUTING work as printed: their code is put into a copy of the sources and used there."""

import re
import shutil
import subprocess
import sys
from pathlib import Path
from textwrap import dedent

import pytest

ROOT = Path(__file__).parents[2]
CODE = re.compile(r"^( *)```python\n(.*?)^\1```", re.M | re.S)


def recipe(title):
    """The blocks of Python of a recipe, by its title in bold."""
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    part = re.search(rf"^\*\*{re.escape(title)}\.?\*\*.*?(?=^\*\*[A-Z])", text, re.M | re.S)
    return [dedent(block) for _, block in CODE.findall(part[0])]


@pytest.fixture
def copy(tmp_path):
    """A copy of the sources, in which a test may write."""
    for name in ("solver", "app"):
        shutil.copytree(ROOT / name, tmp_path / name, ignore=shutil.ignore_patterns("__pycache__", "runs"))
    return tmp_path


def after(file, line, block, indent=""):
    """Put a block below the line that begins so."""
    text = file.read_text(encoding="utf-8")
    (start,) = re.findall(rf"^{re.escape(line)}.*\n", text, re.M)
    file.write_text(text.replace(start, start + "".join(indent + each + "\n" for each in block.splitlines())))


def ran(folder, code):
    """What a Python process in the folder prints."""
    command = [sys.executable, "-c", code]
    return subprocess.run(command, cwd=folder, capture_output=True, text=True, timeout=300, check=True).stdout.strip()


def test_the_recipe_of_a_surface_makes_a_surface(copy):
    field, gap = recipe("A surface")
    after(copy / "solver" / "scene.py", "    surface: str", field, "    ")
    with open(copy / "solver" / "surfaces.py", "a", encoding="utf-8") as file:
        file.write("\n\n" + gap)
    code = "from solver import Scene; gap = Scene(surface='two-level', step=3.0, nodes=64, width=160.0).profile"
    assert ran(copy, f"{code}; print(sorted(set(gap.tolist())), (gap == 0.0).sum())") == "[0.0, 3.0] 31"


def test_the_recipe_of_a_page_makes_a_page_of_the_menu(copy):
    feature, page = recipe("A page")
    blank = copy / "app" / "features" / "blank"
    blank.mkdir()
    (blank / "feature.py").write_text(feature, encoding="utf-8")
    (blank / "page.py").write_text(page, encoding="utf-8")
    code = "from app.features.pages.feature import Feature, listed; page = listed()['blank']; page.Page"
    assert ran(copy, f"{code}; print(page.TITLE, Feature.declared('')['blank'])") == "Blank ['blank']"


def test_the_recipe_of_a_law_makes_a_law(copy):
    word, opening = recipe("A cohesive law")
    with open(copy / "solver" / "scene.py", "a", encoding="utf-8") as file:
        file.write(word)
    after(copy / "solver" / "mechanics" / "cohesive_law.py", "OPENING = ", opening)
    code = "from solver import Scene; from solver.mechanics.cohesive_law import law_constants"
    code += "; print(*(law_constants(Scene(law=law))[6] for law in ('np1', 'halfway', 'xu-needleman')))"
    assert ran(copy, code) == "0.0 0.5 1.0"


def test_every_file_that_a_recipe_names_exists():
    text = (ROOT / "CONTRIBUTING.md").read_text(encoding="utf-8")
    named = re.findall(r"`((?:solver|app|tests|docs)/[\w/.]+)`", text)
    assert len(named) > 20
    assert not [name for name in named if not (ROOT / name).exists() and not re.search("blank|NAME", name)]
