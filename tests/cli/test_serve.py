"""`serve` opens the installed page from any folder."""

import re
import subprocess
import sys
import urllib.request
from contextlib import contextmanager
from pathlib import Path

import pytest

SCRIPT = Path(sys.executable).parent / "mixed-mode-contact"
PROJECT = {  # a folder of the user's, with modules of the names that the page has
    "app/__init__.py": "raise SystemExit('of the folder')",
    "app/main.py": "raise SystemExit('of the folder')",
    "numba.py": "",
}


@pytest.fixture
def project(tmp_path):
    for name, text in PROJECT.items():
        (tmp_path / name).parent.mkdir(exist_ok=True)
        (tmp_path / name).write_text(text)
    return tmp_path


@contextmanager
def served(folder, *command):
    """The lines that a server logs."""
    run = [*command, "serve", "--port", "0", "--address", "127.0.0.1", "--prefix=lab"]
    piped = {"stdout": subprocess.PIPE, "stderr": subprocess.STDOUT, "text": True}
    with subprocess.Popen(run, cwd=folder, **piped) as server:
        try:
            yield server.stdout
        finally:
            server.kill()


@pytest.mark.slow
@pytest.mark.parametrize("own", ["", "solver.py"])
def test_the_installed_page_is_served_from_a_project_with_modules_of_the_same_names(project, own):
    """By options of Panel; `python -m` itself would take a solver.py of the folder."""
    if own:
        (project / own).write_text("raise SystemExit('of the folder')")
    else:
        (project / "numba.py").unlink()
    command = [SCRIPT] if own else [sys.executable, "-m", "solver"]
    with served(project, *command) as lines:
        log = []
        while not log or "workers are warm" not in log[-1]:
            log.append(next(lines))
        address = re.search(r"running at: (http://[\w.:/]+)", "".join(log))[1]
        page = urllib.request.urlopen(address, timeout=60).read().decode()
    assert address.endswith("/lab/app") and "page.js" in page
    assert "of the folder" not in "".join(log)


def test_help_of_serve_names_options_of_panel(call):
    for word in ("-h", "--help"):
        code, out, _ = call("serve", word)
        assert code == 0 and "--port" in out and "panel serve --help" in out
