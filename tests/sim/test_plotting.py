"""Pictures of voyages: what they show, what is written, and that nothing else is touched."""

from __future__ import annotations

import subprocess
import sys
from collections.abc import Callable, Sequence
from dataclasses import replace
from pathlib import Path

import matplotlib as mpl
import numpy as np
import pytest
from matplotlib.axes import Axes
from matplotlib.colors import to_hex
from matplotlib.figure import Figure
from matplotlib.lines import Line2D
from matplotlib.text import Text

from ccas_core.regions import Region
from ccas_core.ships import ShipId
from ccas_core.sim import plotting
from ccas_core.sim.chart import COLOURS, duties, moments, place, sailed, style
from ccas_core.sim.frame import Frame
from ccas_core.sim.metrics import guiding_frames, safety_indices
from ccas_core.sim.scenario import Scenario
from ccas_core.verdict import Kind
from ccas_core.waterway import Leg, Obstacle, Towards

from . import EAST, NORTH, WEST, A, B, C, always, plan, scenario, settlement, voyage, waters

Voyage = tuple[Scenario, list[Frame]]
SOUTH = Leg("river", Towards.START)
PICTURES: tuple[Callable[[Scenario, Sequence[Frame]], Figure], ...] = (
    plotting.paths,
    plotting.snapshots,
    plotting.signals,
    plotting.safety_index,
    plotting.fleet,
)


@pytest.fixture(scope="module")
def crossing() -> Voyage:
    """Ship a slows down for ship b; they come closest when b is past the junction."""
    of = scenario(plan(A, EAST, 900.0), plan(B, NORTH, 900.0))
    slow = [(0.0, 1.0)] * 8 + [(0.0, 0.3)] * 6 + [(0.0, 1.0)]
    return of, voyage(
        of, {A: slow, B: [(0.0, 1.0)]}, always(settlement(Kind.GIVE_WAY, Kind.STAND_ON)), periods=40
    )


@pytest.fixture(scope="module")
def head_on() -> Voyage:
    of = scenario(plan(A, EAST, 900.0, 20.0), plan(B, WEST, 900.0, -20.0))
    return of, voyage(
        of,
        {A: [(20.0, 1.0)], B: [(-20.0, 1.0)] * 6 + [(20.0, 1.0)]},
        always(settlement(Kind.STAND_ON, Kind.GIVE_WAY)),
    )


@pytest.fixture(scope="module")
def fifty() -> Voyage:
    legs = (EAST, WEST, NORTH, SOUTH)
    plans = [plan(ShipId(f"ship_{n:02}"), legs[n % 4], 2500.0 - 90.0 * n, 3.0 * n - 75.0) for n in range(50)]
    of = scenario(*plans)
    return of, voyage(of, {each.ship.id: [(3.0 * n - 75.0, 1.0)] for n, each in enumerate(plans)}, periods=12)


def shown(figure: Figure) -> list[Axes]:
    return [axes for axes in figure.axes if axes.get_visible()]


def texts(of: Figure | Axes) -> list[str]:
    return [text.get_text() for text in of.findobj(Text) if isinstance(text, Text) and text.get_text()]


def drawn(axes: Axes, colour: str) -> list[Line2D]:
    return [line for line in axes.lines if to_hex(str(line.get_color())).upper() == colour]


def table(line: Line2D) -> np.ndarray:
    return np.asarray(line.get_xydata(), dtype=np.float64)


def test_paths_show_tracks_hulls_and_safety_areas_at_four_instants(crossing: Voyage) -> None:
    figure = plotting.paths(*crossing, title="two ships")

    (axes,) = shown(figure)
    track = drawn(axes, COLOURS[0])[0]
    hulls = [patch for patch in axes.patches if patch.get_fill() and patch.get_zorder() == 5.0]
    areas = [patch for patch in axes.patches if not patch.get_fill()]
    assert axes.get_title(loc="left") == "two ships"
    assert (axes.get_xlabel(), axes.get_ylabel()) == ("east [m]", "north [m]")
    assert axes.get_aspect() == 1.0
    assert len(hulls) == len(areas) == 8
    assert np.allclose(table(track)[:, 1], 0.0)  # ship a sails east, along north = 0
    assert {"a", "b", "safety area"} <= {text.get_text() for text in figure.legends[0].get_texts()}


def test_narrow_paths_are_stretched_and_say_so(head_on: Voyage) -> None:
    (axes,) = shown(plotting.paths(*head_on))

    assert float(axes.get_aspect()) >= 2.0
    assert "stretched" in axes.get_ylabel()
    assert "stretched" not in axes.get_xlabel()


def test_paths_show_ships_at_the_instants_asked_for(crossing: Voyage) -> None:
    (axes,) = shown(plotting.paths(*crossing, times=[130.0]))

    assert sum(text == "a, 130 s" for text in texts(axes)) == 1
    assert len([patch for patch in axes.patches if not patch.get_fill()]) == 2


def test_regions_are_named_and_obstacles_drawn(crossing: Voyage) -> None:
    of, frames = crossing
    square = np.array([[-400.0, -400.0], [-400.0, 400.0], [400.0, 400.0], [400.0, -400.0]])
    there = replace(
        of.waters,
        regions=(Region(id="rhine", ruleset="ccnr", polygon=square),),
        obstacles=(Obstacle(id="pier", x=50.0, y=60.0, radius=15.0),),
    )

    figure = plotting.paths(replace(of, waters=there), frames)

    assert {"ccnr", "obstacle"} <= set(texts(figure))


@pytest.mark.parametrize(("aside", "seen"), [(30.0, True), (3000.0, False)])
def test_an_obstacle_that_a_ship_passes_is_in_the_picture(crossing: Voyage, aside: float, seen: bool) -> None:
    of, frames = crossing
    later = frames[30].ships[A].pose
    pier = Obstacle(id="pier", x=later.x + aside, y=later.y, radius=15.0)
    with_pier = replace(of, waters=replace(of.waters, obstacles=(pier,)))

    (axes,) = shown(plotting.paths(with_pier, frames, times=[20.0]))

    (west, east), (south, north) = axes.get_xlim(), axes.get_ylim()
    assert bool(west < pier.y < east and south < pier.x < north) is seen


def test_moments_tell_first_action_and_closest_approach(crossing: Voyage) -> None:
    of, frames = crossing

    found = moments(frames, sailed(of, frames))

    apart = {
        frame.time: np.hypot(
            frame.ships[A].pose.x - frame.ships[B].pose.x, frame.ships[A].pose.y - frame.ships[B].pose.y
        )
        for frame in frames
    }
    assert len(found) == 4
    assert found[0] == 160.0  # the command of frame 8
    assert any(apart[time] <= min(apart.values()) + 5.0 for time in found[1:-1])


def test_snapshots_have_a_panel_an_instant_and_name_the_article(crossing: Voyage) -> None:
    figure = plotting.snapshots(*crossing, times=(100.0, 200.0, 300.0))

    panels = shown(figure)
    assert [panel.get_title(loc="left") for panel in panels] == ["(a) 100 s", "(b) 200 s", "(c) 300 s"]
    assert len({(panel.get_xlim(), panel.get_ylim()) for panel in panels}) == 1
    assert all({"a", "b", "6.04"} <= set(texts(panel)) for panel in panels)


def test_arrow_leads_from_the_ship_that_gives_way(crossing: Voyage) -> None:
    of, frames = crossing

    panel = shown(plotting.snapshots(of, frames, times=(100.0,)))[0]

    arrow = table(max(drawn(panel, "#000000"), key=lambda line: len(table(line))))
    a, b = (frames[5].ships[id_].pose for id_ in (A, B))
    assert np.hypot(*(arrow[0] - [a.y, a.x])) < np.hypot(*(arrow[0] - [b.y, b.x]))
    assert np.hypot(*(arrow[-1] - [b.y, b.x])) < np.hypot(*(arrow[-1] - [a.y, a.x]))
    assert [(duty.obliged, duty.other) for duty in duties(frames, 100.0)] == [(A, B)]


def test_both_ships_are_obliged_where_their_views_do_not_fit(crossing: Voyage) -> None:
    _, frames = crossing
    apart = [replace(frames[0], settlements=(settlement(Kind.STAND_ON, Kind.STAND_ON),))]

    found = duties(apart, 0.0)

    assert [(duty.obliged, duty.article) for duty in found] == [(A, "no common rule"), (B, "no common rule")]


def test_signals_share_time_and_show_every_ship(head_on: Voyage) -> None:
    of, frames = head_on

    upper, middle, lower = shown(plotting.signals(of, frames))

    assert upper.get_shared_x_axes().joined(upper, lower)
    assert "[m]" in upper.get_ylabel()
    assert "[m]" in middle.get_ylabel()
    assert "u^s" in lower.get_ylabel()
    assert lower.get_xlabel() == "time [s]"
    sailing = [frame.ships[B].offset for frame in frames if B in frame.ships and B not in frame.arrived]
    assert np.allclose(table(drawn(upper, COLOURS[1])[0])[:, 1], sailing)
    assert np.ptp(upper.get_ylim()) >= plotting.LEAST_OFFSETS


def test_a_ship_that_has_just_arrived_is_commanded_no_more(head_on: Voyage) -> None:
    of, frames = head_on
    last = next(frame for frame in reversed(frames) if A in frame.ships)
    gone = replace(last, index=last.index + 1, time=last.time + 20.0, arrived={A: last.time + 10.0})

    upper, *_ = shown(plotting.signals(of, [*frames[: last.index + 1], gone]))

    assert table(drawn(upper, COLOURS[0])[0])[-1, 0] == last.time
    assert table(drawn(upper, COLOURS[1])[0])[-1, 0] == gone.time


def test_safety_index_is_that_of_the_metrics(crossing: Voyage) -> None:
    of, frames = crossing
    ships = {each.ship.id: each.ship for each in of.ships}
    poses = {id_: ship.pose for id_, ship in frames[10].ships.items()}

    (axes,) = shown(plotting.safety_index(of, frames))

    line = drawn(axes, COLOURS[0])[0]
    assert table(line)[10, 1] == safety_indices(poses, ships, guiding_frames(of))[A]
    assert str(line.get_label()) == f"a: min {table(line)[:, 1].min():.1f} m"
    assert any(np.allclose(table(each)[:, 1], 0.0) for each in drawn(axes, "#000000"))
    assert axes.get_ylim()[0] < 0.0


def test_fleet_composes_instants_index_offset_and_speed(crossing: Voyage) -> None:
    figure = plotting.fleet(*crossing)

    titles = [axes.get_title(loc="left")[:3] for axes in shown(figure)]
    assert sorted(titles) == ["(a)", "(b)", "(c)", "(d)", "(e)", "(f)", "(g)"]


def test_residuals_are_drawn_for_each_number_of_iterations(crossing: Voyage) -> None:
    _, frames = crossing
    rough = [
        replace(frame, ships={id_: replace(ship, residuals=(9.0, 0.5)) for id_, ship in frame.ships.items()})
        for frame in frames
    ]

    (axes,) = shown(plotting.residuals({2: rough, 1: frames}))

    one, two = axes.lines
    assert axes.get_yscale() == "log"
    assert [one.get_label(), two.get_label()] == ["1 iteration", "2 iterations"]
    assert set(table(one)[:, 1]) == {plotting.LEAST_RESIDUAL}  # by hand: no difference at all
    assert set(table(two)[:, 1]) == {0.5}
    assert len(table(two)) == len(frames)


@pytest.mark.parametrize(("count", "columns"), [(1, 1), (3, 1), (9, 3)])
def test_compared_runs_have_one_view(head_on: Voyage, count: int, columns: int) -> None:
    panels = shown(plotting.compare([(f"run {n}", *head_on) for n in range(count)]))

    assert len(panels) == count
    assert len({(panel.get_xlim(), panel.get_ylim()) for panel in panels}) == 1
    assert panels[-1].get_title(loc="left").endswith(f"run {count - 1}")
    assert len({round(panel.get_position().x0, 3) for panel in panels}) == columns


def test_nothing_to_compare_and_no_residuals_give_a_figure() -> None:
    assert shown(plotting.compare([])) == []
    assert len(shown(plotting.residuals({}))) == 1
    assert len(shown(plotting.residuals({3: []}))) == 1


@pytest.mark.parametrize("picture", PICTURES)
@pytest.mark.parametrize("count", [0, 1, 2])
def test_few_frames_can_be_drawn(
    picture: Callable[[Scenario, Sequence[Frame]], Figure], count: int, crossing: Voyage, tmp_path: Path
) -> None:
    of, frames = crossing

    picture(of, frames[:count]).savefig(tmp_path / "picture.png", dpi=30)


@pytest.mark.parametrize("picture", PICTURES)
def test_one_ship_can_be_drawn(picture: Callable[..., Figure], tmp_path: Path) -> None:
    of = scenario(plan(A, EAST, 500.0))

    picture(of, voyage(of, {A: [(0.0, 1.0)]})).savefig(tmp_path / "picture.png", dpi=30)


@pytest.mark.parametrize("picture", PICTURES)
def test_of_many_ships_few_are_named(picture: Callable[..., Figure], fifty: Voyage) -> None:
    written = texts(picture(*fifty))

    assert sum(text.startswith("ship ") for text in written) <= plotting.LOWEST


@pytest.mark.parametrize("picture", PICTURES)
def test_letters_are_never_small(picture: Callable[..., Figure], crossing: Voyage) -> None:
    figure = picture(*crossing)

    sizes = [
        text.get_fontsize() for text in figure.findobj(Text) if isinstance(text, Text) and text.get_text()
    ]
    assert min(float(size) for size in sizes) >= 8.0


def test_a_run_is_drawn_into_four_files_with_the_same_bytes_each_time(
    crossing: Voyage, tmp_path: Path
) -> None:
    written = plotting.draw_run(*crossing, tmp_path / "run")
    again = plotting.draw_run(*crossing, tmp_path / "again")

    assert [file.name for file in written] == [
        "paths.png",
        "signals.png",
        "safety_index.png",
        "snapshots.png",
    ]
    for file, other in zip(written, again, strict=True):
        data = file.read_bytes()
        assert data.startswith(b"\x89PNG\r\n\x1a\n")
        assert len(data) > 10_000
        assert data == other.read_bytes()
        assert b"Software" not in data
        assert b"tIME" not in data


def test_settings_of_matplotlib_and_pyplot_are_left_alone(crossing: Voyage, tmp_path: Path) -> None:
    before = mpl.rcParams.copy()
    had_pyplot = "matplotlib.pyplot" in sys.modules

    plotting.draw_run(*crossing, tmp_path)

    assert mpl.rcParams.copy() == before
    assert ("matplotlib.pyplot" in sys.modules) == had_pyplot


def test_matplotlib_is_not_loaded_until_something_is_drawn() -> None:
    program = "import sys, ccas_core.sim.plotting; sys.exit('matplotlib' in sys.modules)"

    assert subprocess.run([sys.executable, "-c", program], check=False).returncode == 0


def test_first_three_ships_are_blue_green_and_red_with_lines_of_their_own() -> None:
    channels = [tuple(int(style(n).colour[i : i + 2], 16) for i in (1, 3, 5)) for n in range(3)]

    assert [int(np.argmax(each)) for each in channels] == [2, 1, 0]
    assert len({style(n) for n in range(40)}) == 40
    assert len({style(n).dashes for n in range(3)}) == 3


def test_labels_keep_clear_of_one_another_and_inside() -> None:
    anchors = np.full((6, 2), 50.0)
    sizes = np.full((6, 2), (30.0, 10.0))
    box = np.array([[0.0, 0.0], [200.0, 200.0]])

    centres = place(anchors, sizes, [False] * 6, np.empty((0, 3)), box)

    placed = [centre for centre in centres if centre is not None]
    assert len(placed) >= 4
    for n, one in enumerate(placed):
        assert np.all(one - sizes[n] / 2.0 >= 0.0)
        assert all(np.any(np.abs(one - other) >= (30.0, 10.0)) for other in placed[n + 1 :])


def test_a_label_to_keep_is_written_even_where_there_is_no_room() -> None:
    tiny = np.array([[0.0, 0.0], [5.0, 5.0]])

    kept, dropped = place(np.zeros((2, 2)), np.full((2, 2), 10.0), [True, False], np.empty((0, 3)), tiny)

    assert kept is not None
    assert dropped is None


def test_a_ship_that_was_never_under_way_is_left_out(crossing: Voyage) -> None:
    of, frames = crossing
    late = scenario(*of.ships, plan(C, SOUTH, 900.0), on=waters())

    figure = plotting.paths(late, frames)

    assert "c" not in {text.get_text() for text in figure.legends[0].get_texts()}
