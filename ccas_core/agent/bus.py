"""An in-process bus: a message goes to all who hear its sender, in the same order in every run.

Loss and delay are seeded: the fate of a message depends on the seed, the sender, the receiver
and the sender's count of messages, and on nothing else.
"""

from __future__ import annotations

import heapq
import zlib
from collections.abc import Iterable, Mapping
from dataclasses import dataclass, field

import numpy as np

from ..ships import ShipId
from .messages import Message


@dataclass(slots=True)
class Bus:
    """Carries messages in simulated time.

    Parameters
    ----------
    loss
        Probability that a message does not reach a receiver, in [0, 1).
    delay
        Greatest delay [s]; each is drawn uniformly.
    seed
        Seed of the fates.
    """

    loss: float = 0.0
    delay: float = 0.0
    seed: int = 0
    _hearers: dict[ShipId, tuple[ShipId, ...]] = field(default_factory=dict, init=False)
    _times: list[float] = field(default_factory=list, init=False)  # of arrival, a heap
    _due: dict[float, list[tuple[ShipId, Message]]] = field(
        default_factory=dict, init=False
    )  # in the order sent
    _counts: dict[ShipId, int] = field(default_factory=dict, init=False)

    def join(
        self, members: Iterable[ShipId], neighbours: Mapping[ShipId, Iterable[ShipId]] | None = None
    ) -> None:
        """Say who is on the bus from now on, and who hears whom: all, or the neighbours of each.

        Messages to those who are not on the bus are dropped.
        """
        ships = sorted(members)
        if neighbours is None:
            self._hearers = {ship: tuple(other for other in ships if other != ship) for ship in ships}
        else:
            self._hearers = {ship: tuple(sorted(neighbours[ship])) for ship in ships}

    def post(self, now: float, message: Message) -> None:
        """Send a message to all who hear its sender."""
        count = self._counts.get(message.sender, 0)
        self._counts[message.sender] = count + 1
        for receiver in self._hearers.get(message.sender, ()):
            lost, delay = self._fate(message.sender, receiver, count)
            if not lost:
                when = now + delay
                if when not in self._due:
                    heapq.heappush(self._times, when)
                    self._due[when] = []
                self._due[when].append((receiver, message))

    def collect(self, now: float) -> dict[ShipId, list[Message]]:
        """Take what has arrived by now, by receiver, in order of arrival."""
        arrived: dict[ShipId, list[Message]] = {}
        while self._times and self._times[0] <= now:
            for receiver, message in self._due.pop(heapq.heappop(self._times)):
                if receiver in self._hearers:
                    arrived.setdefault(receiver, []).append(message)
        return arrived

    def next_arrival(self) -> float | None:
        """Time of the next arrival [s]; None if nothing is on its way."""
        return self._times[0] if self._times else None

    def _fate(self, sender: ShipId, receiver: ShipId, count: int) -> tuple[bool, float]:
        if self.loss == 0.0 and self.delay == 0.0:
            return False, 0.0
        entropy = [self.seed, zlib.crc32(sender.encode()), zlib.crc32(receiver.encode()), count]
        chance, wait = np.random.default_rng(entropy).random(2)
        return bool(chance < self.loss), float(wait) * self.delay
