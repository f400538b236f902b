"""What may import what: the core stands without reports, and nothing in the solver knows the app."""

import ast
import inspect
import re
import sys
from graphlib import TopologicalSorter
from pathlib import Path

import pytest

import solver

HERE = Path(solver.__file__).parent
ROOMS = ["mechanics", "continuation", "run", "following"]
CORE = ["schema.py", "surfaces.py", "scene.py", "text.py", *ROOMS]
REPORTS = {"analysis", "accuracy", "measured"}
NUMERICS = {"numpy", "scipy", "numba", "llvmlite", "pyfftw"}  # llvmlite belongs to Numba
STANDARD = sys.stdlib_module_names


def modules(*places):
    paths = [HERE / place for place in places]
    return [path for one in paths for path in ([one] if one.suffix else sorted(one.rglob("*.py")))]


def imported(path):
    """Dotted names of what a module imports, its own package as `solver....`; those within functions too."""
    package = ["solver", *path.relative_to(HERE).parent.parts] if HERE in path.parents else []
    for node in ast.walk(ast.parse(path.read_text())):
        if isinstance(node, ast.Import):
            yield from (alias.name for alias in node.names)
        elif isinstance(node, ast.ImportFrom):
            base = package[: len(package) - node.level + 1] if node.level else []
            stem = ".".join([*base, *([node.module] if node.module else [])])
            yield from (f"{stem}.{alias.name}" for alias in node.names)


@pytest.mark.parametrize("path", modules(*CORE), ids=lambda path: str(path.relative_to(HERE)))
def test_the_core_needs_numerics_only_and_no_report(path):
    for name in imported(path):
        first, *rest = name.split(".")
        assert first == "solver" or first in STANDARD | NUMERICS, name
        assert first != "solver" or rest[0] not in REPORTS, name


@pytest.mark.parametrize("path", modules("continuation"), ids=lambda path: path.name)
def test_continuation_knows_nothing_of_contacts(path):
    for name in imported(path):
        assert not name.startswith("solver.") or name.startswith("solver.continuation"), name


@pytest.mark.parametrize("path", modules("mechanics"), ids=lambda path: path.name)
def test_mechanics_knows_nothing_of_runs(path):
    assert not any(name.startswith("solver.run") for name in imported(path))


@pytest.mark.parametrize("path", modules("."), ids=lambda path: str(path.relative_to(HERE)))
def test_the_solver_does_not_know_the_app(path):
    assert not any(name.split(".")[0] == "app" for name in imported(path))
    assert path.name == "serve.py" or '"app"' not in path.read_text()  # that command hands its folder to Panel


@pytest.mark.parametrize("path", modules("."), ids=lambda path: str(path.relative_to(HERE)))
def test_the_solver_loads_plots_and_pages_only_where_a_function_draws(path):
    loaded = [node for node in ast.parse(path.read_text()).body if isinstance(node, ast.Import | ast.ImportFrom)]
    names = {alias.name for node in loaded if isinstance(node, ast.Import) for alias in node.names}
    names |= {node.module or "" for node in loaded if isinstance(node, ast.ImportFrom) and not node.level}
    assert not {name.split(".")[0] for name in names} & {"holoviews", "bokeh", "panel", "matplotlib"}


def messages(path):
    """The texts of a module but docstrings."""
    tree = ast.parse(path.read_text())
    documented = [n for n in ast.walk(tree) if isinstance(n, ast.Module | ast.ClassDef | ast.FunctionDef)]
    told = {id(n.body[0].value) for n in documented if n.body and isinstance(n.body[0], ast.Expr)}
    return [n.value for n in ast.walk(tree) if isinstance(n, ast.Constant) and id(n) not in told]


def test_messages_of_the_library_do_not_name_options_of_the_command_line():
    """`accuracy/report.py` prints a command."""
    options = set(re.findall(r"--[a-z]+", "".join(path.read_text() for path in modules("cli"))))
    assert {"--set", "--over", "--slips"} <= options
    for path in modules("."):
        if path.parent.name == "cli" or path.match("accuracy/report.py"):
            continue
        named = [text for text in messages(path) if isinstance(text, str) and options & set(text.split())]
        assert not named, f"{path.name}: {named}"


def lines():
    """{module or folder: number of its line} in the list of the solver's docstring."""
    text = solver.__doc__.split("below its own:\n")[1]
    named = [re.split(" {2,}", line)[0].split(", ") for line in text.splitlines() if line and line[:3] != "cli"]
    return {name.rstrip("/"): k for k, names in enumerate(named) for name in names}


def test_modules_import_only_from_their_line_of_the_docstring_and_above():
    order = lines()
    assert {"scene", "mechanics", "run", "accuracy"} <= order.keys()
    for path in modules(*(f"{name}.py" if (HERE / f"{name}.py").is_file() else name for name in order)):
        own = path.relative_to(HERE).parts[0].removesuffix(".py")
        for name in imported(path):
            first, *rest = name.split(".")
            if first == "solver" and rest[0] in order:
                assert order[rest[0]] <= order[own], f"{path.relative_to(HERE)} imports {name}"


def test_no_modules_import_each_other_in_a_circle_not_even_within_functions():
    def named(path):
        parts = path.relative_to(HERE.parent).with_suffix("").parts
        return ".".join(parts[:-1] if parts[-1] == "__init__" else parts)

    files = {named(path): path for path in modules(".")}
    imports = {  # the folder of a module is made before it, so that all import `solver`
        module: {one if one in files else one.rpartition(".")[0] for one in imported(path)}
        & files.keys() - {module, "solver"}
        for module, path in files.items()
    }
    TopologicalSorter(imports).prepare()  # raises CycleError, which names them


def test_no_test_imports_another():
    for path in Path(__file__).parents[1].rglob("*.py"):
        borrowed = [name for name in imported(path) if name.split(".")[0].startswith("test_")]
        assert not borrowed, f"{path.name}: {borrowed}"


def exported():
    """(name, function) of each function that `solver` exports, and of the methods and properties of its classes."""
    for name in solver.__all__:
        one = getattr(solver, name)
        for member, value in vars(one).items() if inspect.isclass(one) else [("", one)]:
            function = getattr(value, "fget", None) or getattr(value, "func", value)  # of properties, kept or not
            if inspect.isfunction(function) and (member == "__init__" or not member.startswith("_")):
                yield f"{name}.{member}".rstrip("."), function


def test_all_exports_of_the_solver_are_annotated():
    functions = dict(exported())
    assert {"load_path", "SceneError.__init__", "Scene.changed", "Frame.F", "Skeleton.slips"} <= set(functions)
    for name, function in functions.items():
        signature = inspect.signature(function)
        bare = [p.name for p in signature.parameters.values() if p.annotation is p.empty and p.name != "self"]
        assert not bare and signature.return_annotation is not signature.empty, (name, bare)
    assert (HERE / "py.typed").is_file()


@pytest.mark.parametrize("path", modules("."), ids=lambda path: str(path.relative_to(HERE)))
def test_public_functions_annotate_what_they_return(path):
    def bare(body):
        for node in body:
            if isinstance(node, ast.ClassDef) and node.name[0] != "_":
                yield from bare(node.body)
            elif isinstance(node, ast.FunctionDef) and node.name[0] != "_" and node.returns is None:
                yield node.name

    assert not list(bare(ast.parse(path.read_text()).body))


APP = HERE.parent / "app"


def test_public_functions_of_the_app_annotate_what_they_take_and_return():
    def functions(body):
        for node in body:
            if isinstance(node, ast.ClassDef):
                yield from functions(node.body)
            elif isinstance(node, ast.FunctionDef | ast.AsyncFunctionDef) and node.name[0] != "_":
                yield node

    found = [node for path in APP.rglob("*.py") for node in functions(ast.parse(path.read_text()).body)]
    own = "self", "cls"
    given = {node: [each for each in node.args.args + node.args.kwonlyargs if each.arg not in own] for node in found}
    bare = [node.name for node in found if not node.returns or not all(each.annotation for each in given[node])]
    assert len(found) > 200 and len(bare) <= 0.05 * len(found), bare


NOT_IMPORTED = {
    "service": {"app.session", "app.features"},
    "session": {"app.features"},
}


@pytest.mark.parametrize("folder", NOT_IMPORTED)
def test_folders_of_the_app_import_only_downwards(folder):
    """A feature is given its session; the core asks the interface for features (app/interface.py)."""
    for path in (APP / folder).rglob("*.py"):
        through = [
            name for name in imported(path) if any(f"{name}.".startswith(f"{other}.") for other in NOT_IMPORTED[folder])
        ]
        assert not through, f"{path.name}: {through}"


def scripts():
    """{script: scripts that it needs at once}; those that it fetches when they are asked for come later."""
    found = {}
    for path in [*(APP / "static").rglob("*.js"), *(APP / "features").rglob("*.js")]:
        names = re.findall(r'(?:from|^import) "(\.[^"]+)"', path.read_text(encoding="utf-8"), re.M)
        found[path] = {(path.parent / name).resolve() for name in names}
    return found


def test_scripts_have_no_import_cycle():
    graph = scripts()
    assert len(graph) > 35 and all(path.is_file() for needed in graph.values() for path in needed)
    TopologicalSorter(graph).prepare()


def test_elements_are_made_in_one_place():
    makers = [
        path.name
        for path in scripts()
        if re.search(r"createElement(NS)?\((?!\"canvas\")", path.read_text(encoding="utf-8"))
    ]
    assert makers == ["dom.js"]
