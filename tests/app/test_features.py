"""Features are folders: each may be missing, or fail, and the page goes on (app/interface.py)."""

import logging
import re
import subprocess
import sys
from functools import cache
from pathlib import Path

import pytest

from app import environment, interface

APP = Path(__file__).parents[2] / "app"
FEATURES = APP / "features"
KINDS = ".py", ".js", ".css", ".html"
GENERAL = {"feature", "tasks", "index", "page"}  # names of scripts of any feature
NAMES = sorted(name for name in interface.found() if (FEATURES / name).exists())
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


LONGEST = 120  # characters of a line, as ruff holds for Python


@pytest.mark.parametrize("kind", ["js", "css", "html"])
def test_lines_of_scripts_styles_and_templates_have_at_most_120_characters(kind):
    files = list(APP.rglob(f"*.{kind}"))
    assert files
    lines = [(path.name, line) for path in files for line in path.read_text(encoding="utf-8").splitlines()]
    assert not [(name, line) for name, line in lines if len(line) > LONGEST]


@cache
def texts(folder):
    """{path: text} of the code in a folder."""
    paths = [path for path in folder.rglob("*") if path.suffix in KINDS and "__pycache__" not in path.parts]
    return {path: path.read_text(encoding="utf-8") for path in sorted(paths)}


def of_kinds(files, *kinds):
    return {path: text for path, text in files.items() if path.suffix in kinds}


@cache
def core():
    """{path: text} of the code of the app that belongs to no feature."""
    return {path: text for path, text in texts(APP).items() if FEATURES not in path.parents}


def named_in(path, text):
    """Names of the features whose modules or files a file imports, or mentions by their path."""
    relative = re.findall(r'(?:from |import\(|import )"(\.[^"]+)"', text) if path.suffix == ".js" else []
    reached = [(path.parent / name).resolve() for name in relative]
    inside = {other.relative_to(FEATURES).parts[0] for other in reached if FEATURES in other.parents}
    return (inside | set(re.findall(r"\bfeatures[./](\w+)", text))) & set(NAMES)


def test_the_core_imports_no_feature():
    assert not {path.name: found for path, text in core().items() if (found := named_in(path, text))}


@pytest.mark.parametrize("name", NAMES)
def test_a_feature_imports_only_those_that_its_sentence_names(name):
    known = {name, *interface.needed(name)}
    found = {path.name: named_in(path, text) - known for path, text in texts(FEATURES / name).items()}
    assert not {path: others for path, others in found.items() if others}


def words(pattern, files):
    """Words that a pattern finds in code, without those that a template makes."""
    code = [re.sub(r"\{\{.*?\}\}|\{%.*?%\}|\$\{.*?\}", "{}", text) for text in files.values()]
    found = {word for text in code for group in re.findall(pattern, text) for word in group.split()}
    return {word for word in found if "{}" not in word}


def ids(files):
    """Ids of the elements that templates and scripts make."""
    return words(r'\bid(?:="|: ")([^"]+)"', of_kinds(files, ".html", ".js"))


def classes(files):
    """Classes of the elements that templates and scripts make."""
    return words(r'\bclass(?:="|Name: "|List\.\w+\(")([^"]+)"', of_kinds(files, ".html", ".js"))


def fields(files):
    """Fields of the store that scripts declare."""
    return {
        field for group in re.findall(r"\bdeclare\(\{(.*?)\}\)", _one(files), re.S) for field in FIELD.findall(group)
    }


def keys(files):
    return set(re.findall(r'\bKEYS(?:\.|\[")(\w+)(?:"\])? = ', _one(files)))


FIELD = re.compile(r"(?:^|,)\s*(\w+):")


def _one(files):
    return "\n".join(of_kinds(files, ".js").values())


def shared_classes(name):
    """Classes of unrelated features: what several use without needing each other is the core's."""
    related = {other for other in NAMES if name in needs(other)} | needs(name)
    return set().union(*(classes(texts(FEATURES / other)) for other in set(NAMES) - related))


def needs(name):
    return {name}.union(*map(needs, interface.needed(name)))


def owned(name):
    """{what: names} that a feature declares."""
    made, files = interface.classes()[name], texts(FEATURES / name)
    orders = {one.order.name for one in vars(made).values() if hasattr(one, "order")}
    return {
        "message": set(made.PARAMS) | orders,
        "id": ids(files),
        "class": classes(files) - classes(core()) - shared_classes(name),
        "field": fields(files),
        "key": keys(files),
        "name in an address": set(made.READS | made.KEEPS),
        "file": {path.name for path in of_kinds(files, ".py", ".js") if path.stem not in GENERAL},
    }


USES = {  # how the core would use a name of a feature
    "message": r'\b(?:order|take|send)\("{0}"|^    {0} = param\.|\bstage\.{0}\b',
    "id": r'\b(?:by|on|say|getElementById)\("{0}"|#{0}(?![\w-])|\b(?:id|for|aria-\w+)="(?:[^"]* )?{0}[" ]',
    "class": r'\("[^"]*\.{0}(?![\w-])|\bclass="(?:[^"]* )?{0}[" ]',
    "class of a style": r"\.{0}(?![\w-])",
    "field": r'\bme\.{0}\b|\b(?:view|frame)\(\[[^\]]*"{0}"|\bset\(\{{[^}}]*\b{0}:',
    "key": r"\bKEYS = \{{[^}}]*\b{0}:",
    "name in an address": r'^FOR_\w+[^\n]*"{0}"|\b(?:get|has|set|delete|append)\("{0}"|arguments\["{0}"\]',
    "file": r'[/"`]{0}\b',
}


@pytest.mark.parametrize(
    ("what", "line"),
    [
        ("message", 'order("odd", { run })'),
        ("message", '    odd = param.Dict({}, doc="")'),
        ("id", 'by("odd").hidden = true'),
        ("id", "#odd > p { margin: 0; }"),
        ("id", '<label for="odd">'),
        ("class of a style", ".page .odd { margin: 0; }"),
        ("class", 'all("i.odd")'),
        ("class", '<b class="key odd">'),
        ("field", "me.odd = 1"),
        ("field", 'view(["run", "odd"], draw)'),
        ("key", "KEYS = { r: reset, odd: call }"),
        ("name in an address", 'FOR_BROWSER: set[str] = {"theme", "odd"}'),
        ("name in an address", 'search.get("odd")'),
        ("file", "// see later/odd"),
    ],
)
def test_a_use_of_a_name_is_recognised_and_one_of_a_longer_name_is_none(what, line):
    assert re.search(USES[what].format("odd"), line, re.M)
    assert not re.search(USES[what].format("odd"), line.replace("odd", "oddly"), re.M)


def test_names_are_found_where_features_declare_them():
    page = '<p id="odd {{ name }}-text" class="key wide of-{{ name }}">'
    script = 'make("b", { id: "more", className: "thin" }); declare({ first: 0, second: {} }); KEYS.m = call'
    files = {Path("run.html"): page, Path("index.js"): script}
    assert (ids(files), classes(files)) == ({"odd", "more"}, {"key", "wide", "thin"})
    assert (fields(files), keys(files)) == ({"first", "second"}, {"m"})


def used(what, word, path, text):
    """Whether a file of the core uses the name of a feature."""
    if what == "class" and path.suffix == ".css":
        what = "class of a style"
    return word in text and re.search(USES[what].format(re.escape(word)), text, re.M)


@pytest.mark.parametrize("name", NAMES)
def test_the_core_uses_no_name_that_a_feature_declares(name):
    declared = [(what, word) for what, found in owned(name).items() for word in sorted(found)]
    found = [(path.name, *each) for each in declared for path, text in core().items() if used(*each, path, text)]
    assert not found


@pytest.mark.parametrize("what", ["message", "id", "field", "key", "name in an address"])
def test_no_two_features_own_the_same(what):
    owners = {}
    for name in NAMES:
        for word in owned(name)[what]:
            owners.setdefault(word, []).append(name)
    assert not {word: names for word, names in owners.items() if len(names) > 1}


SESSION = tuple(f"session/{name}.py" for name in ("pursuit", "run", "orders", "controls"))
READ_FIRST = ("experiment.py", "stage.py", "interface.py", "static", "html", *SESSION)


def lines(files):
    return sum(text.count("\n") for text in files.values())


MOST, MOST_FIRST = 7955, 4770  # lines; wanted are 6,400 and 4,000
LARGER = {"files": 1053, "tour": 520}  # lines of features that are to become smaller


def test_the_core_grows_no_further():
    first = {path: text for path, text in core().items() if path.relative_to(APP).as_posix().startswith(READ_FIRST)}
    print(f"core {lines(core())} lines, read first {lines(first)}, with all features {lines(texts(APP))}")
    assert lines(core()) <= MOST and lines(first) <= MOST_FIRST


@pytest.mark.parametrize("name", NAMES)
def test_a_feature_has_at_most_500_lines_but_for_two(name):
    assert lines(texts(FEATURES / name)) <= LARGER.get(name, 500)
