"""What a picture of a voyage shows: ships and their styles, instants, part of the chart, duties, labels.

Nothing is drawn here, and nothing is known of matplotlib: `plotting` draws.
"""

from __future__ import annotations

import math
from collections.abc import Sequence
from dataclasses import dataclass
from itertools import pairwise
from typing import Final, Literal

import numpy as np

from ..frames import FloatArray
from ..ships import ShipId
from ..waterway import Obstacle
from .conduct import KEEPING_FACTOR, KEEPING_OFFSET, is_met
from .domain_meetings import outline, surge_of
from .frame import Frame, ShipFrame
from .hulls import Track, track
from .metrics import guiding_frames, safety_indices
from .scenario import Scenario

# The first three as in the paper, blue, green and red, in tones that colour-blind readers tell apart.
COLOURS: Final = ("#0072B2", "#009E73", "#CC3311", "#8E44AD", "#E69F00", "#333333", "#56B4E9", "#A0522D")
DASHES: Final = ((), (4.0, 3.0), (5.5, 2.0, 1.0, 2.0), (1.5, 1.2), (7.0, 1.5, 1.0, 1.5, 1.0, 1.5))
PAGE: Final = 7.2  # width of a figure [in]
NARROW: Final = 6.0  # ratio of the extents from which the shorter one is stretched
SQUARE: Final = 0.9  # ratio to which a nearly square part is widened
BESIDE: Final = 5.0  # lengths of a ship within which it passes an obstacle closely
LEAST_VIEW: Final = 300.0  # extent that is shown at least [m]
_LEAD: Final = 6.0  # of the first instant before the closest approach, in hull lengths sailed
_REACHED: Final = 5.0  # excess over the least distance that counts as the closest approach [m]
_NO_ROOM: Final = 1e3  # cost of a label over another one, or outside
_ANGLES: Final = np.tile(np.arange(12) * math.pi / 6.0, 5)
_WAYS: Final = np.column_stack([np.cos(_ANGLES), np.sin(_ANGLES)])  # around an anchor
_DISTANCES: Final = np.repeat([3.0, 8.0, 14.0, 22.0, 32.0], 12)[:, None]  # from it [pt]


@dataclass(frozen=True, slots=True)
class Style:
    """How the lines of a ship look."""

    colour: str
    dashes: tuple[float, ...]  # on and off, in line widths; none: solid


def style(number: int) -> Style:
    """Style of the nth ship or run; the first forty differ."""
    return Style(COLOURS[number % len(COLOURS)], DASHES[number % len(DASHES)])


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Sailed:
    """A ship of a voyage as it is drawn."""

    track: Track
    style: Style
    speed: float  # nominal [m/s]
    surges: FloatArray  # (K, 2), times [s] and speeds through the water [m/s]

    @property
    def id(self) -> ShipId:
        """Of the ship."""
        return self.track.ship.id

    @property
    def name(self) -> str:
        """As it is written in a picture."""
        return self.id.replace("_", " ")

    def at(self, time: float) -> FloatArray:
        """Pose (1, 3) at an instant; nothing (0, 3) where the ship was not under way."""
        times = np.array([time])
        under_way = (self.track.times[0] <= times) & (times <= self.track.times[-1])
        return self.track.at(times[under_way])

    def domain(self, time: float) -> FloatArray:
        """Corners of the safety domain at an instant, (n, 2); none where the ship was not under way."""
        pose = self.at(time)
        if not len(pose):
            return np.empty((0, 2))
        return outline(self.track.ship, pose[0], float(np.interp(time, *self.surges.T)))

    def between(self, begin: float, end: float) -> FloatArray:
        """Poses (K, 3) from one instant to another, both included."""
        rows = self.track.times
        times = np.union1d(np.clip([begin, end], rows[0], rows[-1]), rows)
        return self.track.at(times[(times >= begin) & (times <= end)])


@dataclass(frozen=True, slots=True, kw_only=True)
class View:
    """Part of the chart that is shown, and how much north (above 1) or east (below 1) is stretched."""

    west: float  # [m]
    east: float  # [m]
    south: float  # [m]
    north: float  # [m]
    stretch: float

    @property
    def shape(self) -> float:
        """Height over width on paper."""
        return self.stretch * (self.north - self.south) / (self.east - self.west)

    def holds(self, point: FloatArray) -> bool:
        """Whether a point, north and east, is shown."""
        return bool(self.south <= point[0] <= self.north and self.west <= point[1] <= self.east)


@dataclass(frozen=True, slots=True, kw_only=True, eq=False)
class Scene:
    """A voyage, the instants at which it is shown, and the part of the chart."""

    scenario: Scenario
    frames: Sequence[Frame]
    ships: tuple[Sailed, ...]  # that were under way
    times: tuple[float, ...]
    view: View


@dataclass(frozen=True, slots=True, kw_only=True)
class Duty:
    """A ship gives way to another, by which article."""

    obliged: ShipId
    other: ShipId
    regulation: str
    article: str


def scene(scenario: Scenario, frames: Sequence[Frame], times: Sequence[float] | None = None) -> Scene:
    """Choose what to show of a voyage; instants by `moments` unless given."""
    ships = sailed(scenario, frames)
    chosen = moments(frames, ships) if times is None else tuple(sorted(set(times)))
    shown = points(scenario, frames, ships, chosen)
    return Scene(scenario=scenario, frames=frames, ships=ships, times=chosen, view=framed(scenario, shown))


def sailed(scenario: Scenario, frames: Sequence[Frame]) -> tuple[Sailed, ...]:
    """Ships that were under way, in the order of the scenario, which also gives them their styles."""
    under_way = {id_ for frame in frames for id_ in frame.ships}
    lines = guiding_frames(scenario)
    return tuple(
        Sailed(
            track=track(plan.ship, lines[plan.ship.id], frames),
            style=style(number),
            speed=plan.speed,
            surges=_surges(frames, plan.ship.id),
        )
        for number, plan in enumerate(scenario.ships)
        if plan.ship.id in under_way
    )


def _surges(frames: Sequence[Frame], id_: ShipId) -> FloatArray:
    rows = [(frame.time, surge_of(frame.ships[id_])) for frame in frames if id_ in frame.ships]
    return np.array(rows, dtype=np.float64).reshape(-1, 2)


def moments(frames: Sequence[Frame], ships: Sequence[Sailed], count: int = 4) -> tuple[float, ...]:
    """Instants that tell a voyage: first action, closest approach, the end of all encounters, and between.

    The first is put off until the ships are near one another, so that their hulls can be seen.
    """
    if len(frames) <= count:
        return tuple(frame.time for frame in frames)
    nearest = _closest_approaches(frames)
    if not nearest:
        chosen = np.linspace(0, len(frames) - 1, count + 1)[:-1].round().astype(int)
        return tuple(frames[index].time for index in chosen)
    closest = min(nearest, key=lambda index: (nearest[index], index))
    act = (i for i, frame in enumerate(frames[:closest]) if any(map(_acts, frame.ships.values())))
    period = (frames[-1].time - frames[0].time) / (len(frames) - 1)
    slowness = max(ship.track.ship.hull.length / ship.speed for ship in ships)
    lead = max(2, round(_LEAD * slowness / period))
    begin = max(next(act, 0), closest - lead)
    end = min(len(frames) - 1, max(*nearest, closest + (closest - begin) // 2 + 1))
    chosen_ = [begin, closest, end] if begin < closest else [closest, end]
    while len(chosen_) < count:
        gap, before = max((after - before, before) for before, after in pairwise(sorted(set(chosen_))))
        if gap < 2:
            break
        chosen_.append(before + gap // 2)
    return tuple(frames[index].time for index in sorted(set(chosen_)))


def _acts(ship: ShipFrame) -> bool:
    return abs(ship.offset) > KEEPING_OFFSET or ship.speed_factor < KEEPING_FACTOR


def _closest_approaches(frames: Sequence[Frame]) -> dict[int, float]:
    """Frames in which pairs that met came closest, and the least distance in each [m]."""
    found: dict[int, float] = {}
    for pair in _met(frames):
        apart = {
            index: math.dist(*((frame.ships[id_].pose.x, frame.ships[id_].pose.y) for id_ in pair))
            for index, frame in enumerate(frames)
            if frame.ships.keys() >= set(pair)
        }
        if apart:
            least = min(apart.values())
            first = next(index for index, distance in apart.items() if distance <= least + _REACHED)
            found[first] = min(least, found.get(first, math.inf))
    return found


def _met(frames: Sequence[Frame]) -> set[tuple[ShipId, ShipId]]:
    return {each.pair for frame in frames for each in frame.settlements if is_met(each)}


def points(
    scenario: Scenario, frames: Sequence[Frame], ships: Sequence[Sailed], times: Sequence[float]
) -> FloatArray:
    """Points (n, 2), north and east, that a view has to hold: what ships with encounters do at these times.

    Obstacles that such a ship passes closely belong to it, whenever that is.  Where no ships met, it is all
    ships; where none were under way, it is where they start.
    """
    involved = {id_ for pair in _met(frames) for id_ in pair}
    found = [np.empty((0, 2))]
    for ship in ships:
        if ship.id in involved or not involved:
            poses = np.vstack([ship.at(time) for time in times] or [np.empty((0, 3))])
            found += [ship.domain(time) for time in times]
            found.append(np.vstack([bow_arrow(ship, pose) for pose in poses] or [np.empty((0, 2))]))
            found.append(ship.between(min(times, default=0.0), max(times, default=0.0))[:, :2])
            found += _passed(ship, scenario.waters.obstacles)
    if not any(map(len, found)):
        found = [np.array([[plan.start.x, plan.start.y] for plan in scenario.ships])]
    return np.vstack(found)


def _passed(ship: Sailed, obstacles: Sequence[Obstacle]) -> list[FloatArray]:
    """Corners (2, 2) about each obstacle that a ship passes within `BESIDE` lengths."""
    sailed, near = ship.track.at(ship.track.times), BESIDE * ship.track.ship.hull.length
    return [
        np.array([[each.x - each.radius, each.y - each.radius], [each.x + each.radius, each.y + each.radius]])
        for each in obstacles
        if np.hypot(sailed[:, 0] - each.x, sailed[:, 1] - each.y).min() <= near + each.radius
    ]


def bow_arrow(ship: Sailed, pose: FloatArray) -> FloatArray:
    """Points (3, 2) of the arrow from the bow, half a hull long, that shows the direction of travel."""
    ahead = ship.track.ship.hull.length * np.array([math.cos(pose[2]), math.sin(pose[2])])
    return np.asarray(pose[:2] + np.array([[0.5], [0.6], [1.0]]) * ahead)


def framed(scenario: Scenario, shown: FloatArray, ratio: float = 3.0) -> View:
    """Frame points so that the banks beside them are seen; stretch what is narrow to this ratio (Fig. 7)."""
    low, high = shown.min(axis=0), shown.max(axis=0)
    growth = (LEAST_VIEW - float((high - low).max())) / 2.0
    low, high = low - max(growth, 0.0), high + max(growth, 0.0)
    extent = high - low
    if extent.max() < 2.0 * extent.min():  # nearly square: make it so
        short = (SQUARE * extent.max() - extent).clip(0.0) / 2.0
        low, high = low - short, high + short
    width = max((waterway.width for waterway in scenario.waters.waterways), default=0.0)
    margin = max(min(0.65 * width, 0.15 * float(extent.max())), 50.0)
    (south, west), (north, east) = low - margin, high + margin
    tall, broad = north - south, east - west
    stretch = 1.0
    if extent.max() > NARROW * max(extent.min(), margin / NARROW):
        tallness = max(2.0, round(max(broad / tall, tall / broad) / ratio))
        stretch = tallness if broad > tall else 1.0 / tallness
    return View(west=west, east=east, south=south, north=north, stretch=stretch)


def panel_size(view: View, columns: int, rows: int, most: float) -> tuple[float, float]:
    """Width and height [in] of a chart, so that the figure is as wide as the page and not too high."""
    width, height = (PAGE - 0.8) / columns - 0.1, (most - 1.0) / rows - 0.3
    return min(width, height / view.shape), min(height, width * view.shape)


def page_size(view: View, columns: int, rows: int, most: float) -> tuple[float, float]:
    """Width and height [in] of a figure of charts, with room for names and legend."""
    width, height = panel_size(view, columns, rows, most)
    return max(4.6, columns * (width + 0.1) + 0.8), rows * (height + 0.3) + 1.0


def grid(count: int, view: View, most: float) -> tuple[int, int]:
    """Columns and rows for so many charts: as few columns as make them largest."""
    count = max(count, 1)
    grids = [(columns, math.ceil(count / columns)) for columns in range(1, count + 1)]
    return max(grids, key=lambda grid: (round(panel_size(view, grid[0], grid[1], most)[0], 6), -grid[0]))


def duties(frames: Sequence[Frame], time: float) -> tuple[Duty, ...]:
    """Who gives way to whom at an instant; where no rule decided, both, by `no common rule`."""
    frame = frame_at(frames, time)
    found = []
    for settlement in frame.settlements if frame else ():
        citation = settlement.one.citation
        regulation, article = (citation.regulation, citation.article) if citation else ("", "")
        obliged = settlement.one.give_way
        if settlement.fallback:
            obliged, regulation, article = settlement.pair, "", "no common rule"
        for id_ in obliged:
            other = settlement.pair[0] if settlement.pair[1] == id_ else settlement.pair[1]
            found.append(Duty(obliged=id_, other=other, regulation=regulation, article=article))
    return tuple(found)


def frame_at(frames: Sequence[Frame], time: float) -> Frame | None:
    """Last frame that does not lie after an instant."""
    return next((frame for frame in reversed(frames) if frame.time <= time), None)


def signal(
    frames: Sequence[Frame],
    id_: ShipId,
    of: Literal["offset", "path_y", "speed_factor"],
    *,
    commands: bool = False,
) -> FloatArray:
    """Table (K, 2) of time and a field of a ship; a ship that has just arrived is commanded no more."""
    rows = [
        (frame.time, getattr(frame.ships[id_], of))
        for frame in frames
        if id_ in frame.ships and not (commands and id_ in frame.arrived)
    ]
    return np.array(rows, dtype=np.float64).reshape(-1, 2)


def safety_series(scenario: Scenario, frames: Sequence[Frame]) -> dict[ShipId, FloatArray]:
    """Tables (K, 2) of time and safety index, of ships that were not always alone."""
    ships = {plan.ship.id: plan.ship for plan in scenario.ships}
    lines = guiding_frames(scenario)
    rows: dict[ShipId, list[tuple[float, float]]] = {}
    for frame in frames:
        poses = {id_: ship.pose for id_, ship in frame.ships.items()}
        for id_, index in safety_indices(poses, ships, lines).items():
            if index is not None:
                rows.setdefault(id_, []).append((frame.time, index))
    return {id_: np.array(each) for id_, each in rows.items()}


@dataclass(frozen=True, slots=True, kw_only=True)
class Label:
    """A text beside a point of the chart."""

    text: str
    north: float  # [m]
    east: float  # [m]
    colour: str
    keep: bool  # written even where there is no room


def place(
    anchors: FloatArray, sizes: FloatArray, keep: Sequence[bool], busy: FloatArray, box: FloatArray
) -> list[FloatArray | None]:
    """Centres of labels, each beside its anchor, clear of one another and of busy points; None: no room.

    Everything is in points of the paper.  `anchors` and `sizes` are (n, 2), across and up; `busy` is (m, 3)
    with a weight in its last column; `box` is (2, 2), the corners that no label may leave.
    """
    taken = np.empty((0, 2, 2))  # low and high corners
    centres: list[FloatArray | None] = [None] * len(anchors)
    for n in sorted(range(len(anchors)), key=lambda n: not keep[n]):
        options = anchors[n] + _WAYS * (sizes[n] / 2.0 + _DISTANCES)
        low, high = options - sizes[n] / 2.0, options + sizes[n] / 2.0
        inside = np.all((busy[:, :2] > low[:, None] - 1.0) & (busy[:, :2] < high[:, None] + 1.0), axis=2)
        too_far = (not keep[n]) & (_DISTANCES[:, 0] > 14.0)
        overlaps = np.all((taken[:, 0] < high[:, None]) & (taken[:, 1] > low[:, None]), axis=2)
        outside = np.any((low < box[0]) | (high > box[1]), axis=1)
        cost = (
            0.1 * _DISTANCES[:, 0]
            + inside @ busy[:, 2]
            + _NO_ROOM * (overlaps.sum(axis=1) + outside + too_far)
        )
        best = int(np.argmin(cost.round(6)))
        if keep[n] or cost[best] < _NO_ROOM:
            centres[n] = options[best]
            taken = np.concatenate([taken, [[low[best], high[best]]]])
    return centres
