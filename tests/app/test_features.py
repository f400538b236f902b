"""Features are folders: each may be missing, or fail, and the page goes on (app/interface.py)."""

import logging
import subprocess
import sys
from pathlib import Path

import pytest

from app import environment, interface

NAMES = sorted(interface.found())
OTHERS = ["first", "second", "third"]


@pytest.mark.parametrize(
    ("text", "chosen"),
    [("", OTHERS), ("all", OTHERS), ("none", []), ("-first", OTHERS[1:]), ("-third  -first", ["second"])],
)
def test_features_are_chosen_by_an_environment_variable(monkeypatch, text, chosen):
    monkeypatch.setenv("APP_FEATURES", text)
    assert sorted(environment.chosen("APP_FEATURES", OTHERS)) == chosen


@pytest.mark.parametrize("text", ["-nothing", "first", "all -first", "none all", "-", "- first", "first -first"])
def test_another_choice_of_features_ends_the_server_with_the_names(monkeypatch, text):
    monkeypatch.setenv("APP_FEATURES", text)
    with pytest.raises(SystemExit, match=r"APP_FEATURES is .* Set it to all, none .*-first: first, second, third"):
        environment.chosen("APP_FEATURES", OTHERS)


def test_each_feature_begins_with_one_sentence_that_names_what_it_needs():
    for name, text in interface.found().items():
        sentence = text.split("\n")[0]
        assert 20 < len(sentence) <= 120 and sentence.endswith("."), (name, sentence)
        assert set(interface.needed(name)) <= set(NAMES) - {name}, name


FAILING = '''"""A feature that fails wherever it is called."""

from app import interface


class Feature(interface.Feature):
    def status(self):
        raise RuntimeError("of no use")

    requested = ended = nearer = close = status
'''


def test_a_feature_that_fails_is_logged_once_and_the_run_goes_on(session, caplog, monkeypatch, tmp_path):
    (tmp_path / "failing").mkdir()
    (tmp_path / "failing" / "feature.py").write_text(FAILING, encoding="utf-8")
    namespace = {}
    exec(FAILING, namespace)
    session.features["failing"] = namespace["Feature"](session)
    with caplog.at_level(logging.ERROR):
        session.hello()
        for _ in range(3):
            session.publish()
    said = [record.message for record in caplog.records]
    assert said == ["the feature failing failed: requested", "the feature failing failed: status"]
    assert session.status["state"] in ("running", "warming")
    del session.features["failing"]


LISTS = "from app import interface; print(*interface.classes())"


def listed(folder, features, **environment):
    """The features of a process with folders {name: text of feature.py} added, and its log."""
    for name, text in features.items():
        (folder / name).mkdir()
        (folder / name / "feature.py").write_text(text, encoding="utf-8")
    code = f"import logging; logging.basicConfig(level=logging.INFO); {LISTS}"
    ran = subprocess.run(
        [sys.executable, "-c", code],
        env={"APP_FEATURES_PATH": str(folder)} | environment,
        capture_output=True,
        text=True,
        check=True,
    )
    return ran.stdout.split(), ran.stderr


def test_a_feature_without_what_it_needs_and_one_that_cannot_be_imported_are_left_out(tmp_path):
    made, log = listed(
        tmp_path,
        {
            "first": '"""The first one of a chain. Needs missing."""',
            "second": '"""The second one of a chain. Needs first, simple."""',
            "broken": '"""One that cannot be imported."""\nimport nothing_of_this_name',
            "whole": '"""One that needs what is there. Needs simple."""',
            "simple": '"""One that needs nothing but a name."""',
        },
    )
    assert {"whole", "simple"} <= set(made) and not {"first", "second", "broken"} & set(made)
    assert "the feature first is left out: it needs missing" in log
    assert "the feature second is left out: it needs first" in log
    assert "the feature broken is left out" in log and "nothing_of_this_name" in log


APP = Path(__file__).parents[2] / "app"


LONGEST = 120  # characters of a line, as ruff holds for Python


@pytest.mark.parametrize("kind", ["js", "css", "html"])
def test_lines_of_scripts_styles_and_templates_have_at_most_120_characters(kind):
    files = list(APP.rglob(f"*.{kind}"))
    assert files
    lines = [(path.name, line) for path in files for line in path.read_text(encoding="utf-8").splitlines()]
    assert not [(name, line) for name, line in lines if len(line) > LONGEST]
