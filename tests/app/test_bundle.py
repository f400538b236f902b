"""The script of a Stage: every module of the page as a function."""

import re

import pytest

from app import assets, bundle, modules

KINDS = bundle.PLAYED, bundle.LIVE


def exported(name):
    """The names that a module gives to others."""
    text = assets.text(name)
    return {*modules.EXPORT.findall(text), *(["root"] if modules.ROOT in text else [])}


@pytest.mark.parametrize("name", sorted(name for name in assets.files() if name.endswith(".js")))
def test_every_name_that_a_module_imports_is_exported(name):
    """Exports of several names at once, or of other modules' names, would be lost in the script."""
    text = assets.text(name)
    for _, names, other in modules.IMPORT.findall(text):
        wanted = {each.strip().split(" as ")[0] for each in names.split(",") if each.strip()}
        assert wanted <= exported(assets.imported(name, other)), other
    left = modules.EXPORT.sub("", modules.IMPORT.sub("", text))
    assert not re.search(r"^(?:import|export)\b", left, re.M)


def test_a_script_has_every_module_that_its_stages_need_and_no_other_root():
    text = bundle.script(*KINDS)
    for kind in KINDS:
        for name in assets.needed(assets.MAIN, *assets.scripts(kind)):
            assert f'"{name}"() {{' in text
    assert "document.documentElement" not in text.split("function makeStage")[1].split("// A Stage of a model")[0]
    assert modules.NAMED in assets.text(assets.MAIN) and text.count("const root = $root") == 2


def test_no_module_of_a_stage_looks_for_files_beside_itself():
    """In a layout of somebody else's there are none."""
    assert "import.meta" not in bundle.script(*KINDS)


def test_no_style_of_a_stage_reaches_beyond_it():
    style = bundle.script(bundle.PLAYED).split("function makeStage")[0]
    assert ":root" not in style and "html, body" not in style and "@media (max-width" not in style


def test_the_script_of_a_file_is_smaller_than_that_of_a_server():
    assert len(bundle.script(bundle.PLAYED)) < 0.8 * len(bundle.script(*KINDS))
    assert "lesson" not in bundle.script(*KINDS)  # belongs to the page


def test_the_page_has_each_module_once_and_loads_the_others_when_asked_for():
    first, later = assets.text(modules.PAGE), assets.text(modules.REST)
    scripts = {name for name in assets.files() if name.endswith(".js")} - {modules.OPENING}
    for name in scripts:
        assert (f'"{name}"() {{' in first) != (f'"{name}"() {{' in later), name
    beside = 'new URL("../features/theory/index.js", import.meta.url)'  # else files beside a module are not found
    assert beside in first and not re.search(r"[( ]import\.meta\.url", first.replace(beside, ""))
    assert '"features/tour/tour.js"() {' in later and '"static/js/player.js"() {' in first
