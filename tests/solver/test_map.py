"""Maps of first slips: every point once, from coarse to fine, against exact runs and closed forms of flats."""

import pickle
from concurrent.futures import ThreadPoolExecutor
from dataclasses import replace

import numpy as np
import pytest

from solver import NotConverged, NotFollowed, Scene, SceneError, SlipEvent, load_path, summarize
from solver.analysis import maps
from solver.analysis.friction_laws import critical_modulus
from solver.analysis.maps import REGIMES, Axis, Map, Point, Task, computed_point
from solver.analysis.maps import task as map_task
from solver.analysis.maps.grid import AROUND, RUNS
from solver.analysis.maps.point import at_slip
from solver.analysis.maps.task import computed
from solver.continuation import landing

SMALL = Scene(nodes=128, width=312.5, u_x_max=12.0, tolerance=1e-7)  # the default, an eighth as wide
FLAT = Scene(surface="flat", nodes=16, width=40.0, height=100.0, delta_bar=0.0, damping=np.inf)
PRESS, RATIO = Axis("delta_bar", 0.1, 0.4, 5), Axis("phi_ratio", 0.5, 1.5, 3, log=True)


def explored(grid, points=()):
    """{(i, j): Point} of a Map, computed here, but those given."""
    known = {(point.i, point.j): (point, None) for point in points}
    for place in grid.places():
        if place not in known:
            known[place] = computed_point(grid.task(place, known))
    return {place: point for place, (point, _) in known.items()}


@pytest.fixture(scope="module")
def grid():
    return Map(SMALL, PRESS, Axis("phi_ratio", 0.5, 1.5, 5, log=True))


@pytest.fixture(scope="module")
def explored_grid(grid):
    return explored(grid)


@pytest.mark.parametrize("counts", [(2, 2), (41, 31), (7, 2), (33, 64), (5, 400)])
def test_every_map_point_is_listed_once_and_later_ones_have_near_neighbours(counts):
    grid, known = Map(SMALL, replace(PRESS, count=counts[0]), replace(RATIO, count=counts[1])), {}
    places = grid.places()
    assert len(places) == len({*places}) == grid.size == counts[0] * counts[1]
    for place in places:
        task = grid.task(place, known)
        assert len(task.around) == (AROUND if len(known) >= RUNS else 0) and (task.i, task.j) == place
        if len(known) > 0.8 * grid.size:
            assert all(max(abs(point.i - place[0]), abs(point.j - place[1])) <= 2 for point in task.around)
        known[place] = Point(i=place[0], j=place[1]), None


def test_a_map_agrees_with_exact_runs(grid, explored_grid):
    assert sum(point.followed for point in explored_grid.values()) > 4
    for i, j in [(1, 1), (3, 3), (2, 1), (4, 3), (1, 4)]:
        point = explored_grid[i, j]
        scene = SMALL.changed(delta_bar=float(grid.x.values[i]), phi_ratio=float(grid.y.values[j]))
        frames = []
        for frame in load_path(scene):
            frames.append(frame)
            if frame.stage == "shear" and frame.slips:
                break
        exact = summarize(frames)
        assert point.U_s == pytest.approx(exact["U_s"], abs=1e-3)
        assert (point.F_s, point.A_s, point.A_0) == pytest.approx([exact[n] for n in ("F_s", "A_s", "A_0")], rel=1e-3)
        moved = (frames[-1].u[0] - frames[-2].u[0])[frames[-2].T[1] > 0.0]  # in contact
        assert point.sites == round(float(np.median(moved)) / scene.spacing)
        lost, back = exact["A_0"] - exact["A_s"], frames[-1].A - exact["A_s"]
        assert point.reattached == pytest.approx(back / lost, abs=0.05)  # the frame after a slip is some way beyond it


def test_table_of_a_map_holds_its_points_at_their_place(grid, explored_grid):
    U_s, codes = (grid.array(explored_grid.values(), of) for of in ("U_s", "regime"))
    assert U_s.shape == codes.shape == (grid.y.count, grid.x.count)
    for (i, j), point in explored_grid.items():
        assert U_s[j, i] == point.U_s and REGIMES[codes[j, i]] == point.regime
    assert np.isnan(grid.array([], "F_s")).all() and (grid.array([], "regime") == -1).all()


def test_a_plot_of_a_map_shows_the_quantity_and_the_regimes(grid, explored_grid):
    layout = grid.plot(explored_grid.values(), "F_s")
    numbers, regimes = layout
    assert [dimension.name for dimension in numbers.kdims] == ["delta_bar", "phi_ratio"]
    drawn = np.sort(numbers.dimension_values("F_s"))
    assert drawn == pytest.approx(np.sort([point.F_s for point in explored_grid.values()]))
    assert {*regimes.keys()} == {point.regime for point in explored_grid.values()}
    with pytest.raises(ValueError, match="of = 'F'; allowed: U_s, F_s"):
        grid.plot([], "F")


def test_tasks_of_a_map_survive_as_bytes(grid, explored_grid):
    known = {place: (point, None) for place, point in explored_grid.items() if place != (3, 3)}
    task = grid.task((3, 3), known)
    read = pickle.loads(pickle.dumps(task))
    assert read == task == grid.task((3, 3), {}) and hash(read) == hash(task) and read.around == task.around


def test_a_map_can_be_resumed_from_its_points(grid, explored_grid):
    there = {place: point for place, point in explored_grid.items() if place[0] != 3}
    found = explored(grid, there.values())
    assert found.keys() == explored_grid.keys() and all(found[place] == point for place, point in there.items())
    for j in range(grid.y.count):
        assert found[3, j].U_s == pytest.approx(explored_grid[3, j].U_s, abs=1e-3)


@pytest.fixture(scope="module")
def neighbours():
    """Two points at the ends of a row, with their Skeletons."""
    ends = []
    for i in (0, 2):
        point, skeleton = computed(SMALL.changed(delta_bar=0.1 + 0.02 * i))
        ends.append((replace(point, i=i), skeleton))
    return ends


def between(neighbours):
    """The Outcome of the point between two neighbours, from the Skeleton of the first."""
    values, around = (("delta_bar", 0.12), ("phi_ratio", 1.0)), tuple(point for point, _ in neighbours)
    return computed_point(Task(SMALL, values, 1, 0, True, around, neighbours[0][1]))


def test_a_map_point_among_equal_neighbours_is_followed(neighbours):
    point, skeleton = between(neighbours)
    exact, _ = computed(SMALL.changed(delta_bar=0.12))
    assert point.followed and skeleton is not None and point.kind == exact.kind
    assert point.U_s == pytest.approx(exact.U_s, abs=1e-4) and point.evaluations < 0.3 * exact.evaluations


@pytest.mark.parametrize("changed", [{"sites": 2}, {"regime": "detaches"}, {"branches": 2}])
def test_a_map_point_between_different_regimes_is_computed(neighbours, changed):
    first, (point, skeleton) = neighbours
    assert not between([first, (replace(point, **changed), skeleton)])[0].followed


def test_a_map_point_whose_slip_is_outside_the_range_of_its_neighbours_is_computed(neighbours):
    shifted = [(replace(point, U_s=point.U_s + 1.0), skeleton) for point, skeleton in neighbours]
    assert not between(shifted)[0].followed


def test_a_map_point_that_cannot_be_followed_is_computed(neighbours, monkeypatch):
    def no(*_):
        raise NotFollowed("no")

    monkeypatch.setattr(map_task, "follow", no)
    found, skeleton = between(neighbours)
    assert not found.followed and found.U_s and skeleton is not None


def broken(task):
    return task.missing


def test_a_hole_in_a_map_has_a_sentence_as_its_reason(monkeypatch):
    monkeypatch.setattr("solver.analysis.maps.grid.computed_point", broken)
    points = list(maps.explore_map(Map(SMALL, replace(PRESS, count=2), replace(RATIO, count=2)), ThreadPoolExecutor(1)))
    assert len(points) == 4
    for point in points:
        assert point.reason.startswith("unexpected error AttributeError(") and point.reason.count("\n") == 0


def test_a_run_ends_just_beyond_its_first_slip():
    frames = list(load_path(SMALL.changed(delta_bar=0.1)))
    point, skeleton = computed(SMALL.changed(delta_bar=0.1))
    assert point.evaluations < sum(frame.evaluations for frame in frames) and skeleton.sites == point.sites
    longer, _ = computed(SMALL.changed(delta_bar=0.1, u_x_max=1e3))
    assert longer == point


def test_regimes_have_their_names():
    named = {
        "never touches": {"delta_bar": -0.9},
        "smooth sliding": {"E": 2000.0, "phi_ratio": 0.05},
        "sticks": {"u_x_max": 1.0},
        "slips by one site": {},
    }
    for name, values in named.items():
        assert computed(SMALL.changed(**({"delta_bar": 0.1} | values)))[0].regime == name


def test_a_contact_lost_under_a_held_load_is_classified_as_detached():
    """No increment follows the last one, so that the numbers are of the last: within du_x, 0.1 nm, of the end."""
    scene = SMALL.changed(hold="load", delta_bar=-0.2)
    frames = []
    with pytest.raises(NotConverged, match="pulled off"):
        for frame in load_path(scene):
            frames.append(frame)
    point, _ = computed(scene)
    assert (point.regime, point.reason) == ("detaches", "") and point.U_s == frames[-1].U_x
    assert (point.F_s, point.A_s) == (frames[-1].F, frames[-1].A)


@pytest.mark.parametrize("values", [{}, {"E": 20.0, "phi_ratio": 1.5}, {"delta_bar": 0.4, "phi_ratio": 0.3}])
def test_a_computed_map_point_has_the_numbers_of_its_run(values):
    """To the last digit: nothing is interpolated where the run itself has located the slip."""
    scene = SMALL.changed(**({"delta_bar": 0.1} | values))
    point, _ = computed(scene)
    summary = summarize(list(load_path(scene)))
    assert [getattr(point, name) for name in NUMBERS] == [summary[name] for name in NUMBERS]


def test_a_contact_that_shrinks_in_its_slip_reattaches_nothing():
    frames = [frame for frame in load_path(SMALL.changed(delta_bar=0.1, u_x_max=1.0)) if frame.stage == "shear"]
    start, before, after = (replace(frames[0], A_bar=A_bar) for A_bar in (0.1, 0.05, 0.02))
    event = SlipEvent(1.0, 1e-3, -1e-4, before.A_bar)
    assert at_slip(start, before, after, event)["reattached"] == 0.0


def test_an_impossible_map_point_has_a_reason(monkeypatch):
    monkeypatch.setattr(landing, "BUDGET", 5_000)  # steps of a motion that never comes to rest, of 250,000
    axis = Axis("height", 1.0, 100.0, 2)
    point, _ = computed_point(Map(SMALL.changed(E=0.05), axis, PRESS).task((1, 0), {}))
    assert point.regime == "no result" and "use E=" in point.reason


def test_flats_have_their_closed_form():
    """The fold is the maximum of U(u) = u + pull(u) h/G, Eq. 2 summed over the lattice; there is one below E_c."""
    grid = Map(FLAT, Axis("E", 20.0, 2000.0, 3, log=True), Axis("phi_ratio", 0.05, 2.0, 3, log=True))
    a, sites = FLAT.spacing, np.arange(-8, 9)
    u = np.linspace(0.0, 0.5 * a, 200_001)
    off = (sites[:, None] * a - u) / FLAT.delta_t
    pull = -2.0 * FLAT.phi_n / FLAT.delta_t * (off * np.exp(-(off**2)) * (np.abs(off) <= FLAT.window_t)).sum(axis=0)
    for (i, j), point in explored(grid).items():
        E, ratio = float(grid.x.values[i]), float(grid.y.values[j])
        scene = FLAT.changed(E=E, phi_ratio=ratio)
        load = u + ratio * pull * scene.height * scene.width / scene.shear_modulus
        k = int(load.argmax())
        if critical_modulus(scene) <= E:
            assert point.regime == "smooth sliding" and point.U_s is None
        elif load[k] < scene.u_x_max - a:
            assert point.U_s == pytest.approx(load[k], abs=1e-4) and point.regime.startswith("slips")
            if 0.9 * critical_modulus(scene) > E:  # beyond, the fold is so flat that its load says little of its force
                assert point.F_s == pytest.approx(ratio * pull[k] * scene.width, rel=1e-3)


def test_pull_off_is_mapped_from_retractions():
    scene = SMALL.changed(path="unload", du_z=0.5, delta_bar=0.1)
    grid = Map(scene, PRESS, Axis("phi_n", 1.0, 2.0, 2))
    found = [computed_point(grid.task((0, j), {}))[0] for j in (0, 1)]
    numbers = summarize(list(load_path(scene)))
    assert found[0].L_min > found[1].L_min == numbers["L_min"]  # less adhesion first
    assert found[1].L_off == numbers["L_off"]


def test_regime_of_a_retraction_says_whether_the_surfaces_touched_and_parted():
    """The attraction of a soft layer holds beyond the highest end of a retraction."""
    scene = SMALL.changed(path="unload", du_z=0.5)
    regimes = {"never touches": {"delta_bar": -0.9}, "detaches": {"delta_bar": 0.1}, "sticks": {"E": 0.1, "phi_n": 1.0}}
    for regime, values in regimes.items():
        point, _ = computed(scene.changed(**values))
        assert (point.regime, point.reason) == (regime, "")


@pytest.mark.parametrize(
    "values",
    [("speed", 1.0, 2.0, 3), ("nodes", 64.0, 128.0, 3), ("E", 0.0, 20.0, 3), ("E", 5.0, 5.0, 3), ("E", 10.0, 20.0, 1),
     ("delta_bar", -1.0, 1.0, 5, True)],
)  # fmt: skip
def test_an_impossible_axis_is_rejected_by_name(values):
    with pytest.raises(SceneError, match=f"{values[0]}.*allowed") as refused:
        Axis(*values)
    assert pickle.loads(pickle.dumps(refused.value)).args == refused.value.args


@pytest.mark.parametrize("count", [2.0, "3", 2.5])
def test_an_axis_has_a_whole_number_of_values(count):
    with pytest.raises(
        SceneError, match=r"delta_bar = .*: allowed: 2 \.\. 400 values, a whole number; give such a COUNT"
    ):
        Axis("delta_bar", 0.0, 0.1, count)


def test_the_two_axes_differ():
    with pytest.raises(SceneError, match="two different"):
        Map(SMALL, PRESS, PRESS)


NUMBERS = "U_s", "F_s", "A_s", "A_0"
