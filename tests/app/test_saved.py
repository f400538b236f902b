"""A Result in a file or a notebook: a page that plays without a server."""

import sys
from pathlib import Path

import pytest

from app import server_log
from app.stage import Stage
from solver import Scene, simulate


def test_a_stage_without_a_result_is_not_saved(tmp_path):
    with pytest.raises(ValueError, match="no result"):
        Stage().save(tmp_path / "punch.html")
    assert not list(tmp_path.iterdir())


def test_a_stage_without_a_result_says_so_in_a_notebook():
    assert "no result" in Stage()._repr_html_() and "iframe" not in Stage()._repr_html_()


@pytest.fixture(scope="module")
def short():
    """A result with few frames."""
    return simulate(Scene(nodes=256, width=625.0, u_x_max=1.0))


@pytest.mark.parametrize("allowed", ["", "teacher.example:5006"])
def test_a_saved_file_and_a_notebook_name_no_machine_address_or_folder(short, tmp_path, monkeypatch, allowed):
    """Of a machine without a network only the names are tested that a server would accept."""
    monkeypatch.setenv("BOKEH_ALLOW_WS_ORIGIN", allowed)
    Stage(short).save(tmp_path / "punch.html")
    text = (tmp_path / "punch.html").read_text(encoding="utf-8")
    texts = [text, Stage(short)._repr_html_()]
    folders = Path(server_log.__file__).parents[1], sys.prefix, Path.home(), Path.cwd(), tmp_path
    own = [*map(str, folders), *server_log.addresses(), *filter(None, [allowed])]
    assert [name for name in own if any(name in each for each in texts)] == []


def test_a_played_result_keeps_its_cautions():
    """They were dropped in silence."""
    result = simulate(Scene(nodes=64, width=160.0, u_x_max=1.0))  # a steep punch
    assert result.cautions and Stage(result).status["cautions"] == list(result.cautions)


def test_a_title_that_no_file_can_hold_is_refused_with_its_value(short):
    with pytest.raises(ValueError, match=r"title = 'a\\ud800'.*allowed"):
        Stage(short, title="a\ud800")
