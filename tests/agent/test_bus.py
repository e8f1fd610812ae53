"""The bus: who hears what, and when; loss and delay that repeat themselves."""

from __future__ import annotations

from ccas_core.agent.bus import Bus
from ccas_core.agent.messages import Gossip, Message
from ccas_core.ships import ShipId

from . import A, B, C


def word(sender: ShipId, period: int = 0) -> Message:
    return Gossip(sender, period, {}, frozenset())


def heard(
    bus: Bus, senders: tuple[ShipId, ...] = (A, B, C), count: int = 40
) -> list[tuple[float, ShipId, ShipId, int]]:
    """Who hears whose message when, if each sends so many, a second apart."""
    found = []
    for n in range(count):
        for sender in senders:
            bus.post(float(n), word(sender, n))
    while (when := bus.next_arrival()) is not None:
        for receiver, messages in bus.collect(when).items():
            found += [(when, receiver, message.sender, message.period) for message in messages]
    return found


def bus(loss: float = 0.0, delay: float = 0.0, seed: int = 0, members: tuple[ShipId, ...] = (A, B, C)) -> Bus:
    made = Bus(loss=loss, delay=delay, seed=seed)
    made.join(members)
    return made


def test_message_reaches_all_others_at_once_and_never_its_sender() -> None:
    on = bus()
    on.post(3.0, word(A))

    assert on.next_arrival() == 3.0
    assert on.collect(3.0) == {B: [word(A)], C: [word(A)]}
    assert on.collect(3.0) == {}
    assert on.next_arrival() is None


def test_nobody_ever_hears_himself() -> None:
    assert all(receiver != sender for _, receiver, sender, _ in heard(bus(loss=0.2, delay=5.0, seed=3)))


def test_messages_of_one_instant_arrive_in_the_order_in_which_they_were_sent() -> None:
    on = bus()
    for n in (2, 0, 1):
        on.post(1.0, word(A, n))

    assert [message.period for message in on.collect(1.0)[B]] == [2, 0, 1]


def test_nothing_arrives_before_its_time() -> None:
    on = bus(delay=10.0, seed=1)
    on.post(5.0, word(A))
    when = on.next_arrival()

    assert when is not None
    assert 5.0 < when <= 15.0
    assert on.collect(when - 1e-6) == {}
    assert on.collect(when)


def test_same_seed_has_the_same_fates_and_another_seed_has_others() -> None:
    one, same, other = (heard(bus(loss=0.3, delay=2.0, seed=seed)) for seed in (5, 5, 6))

    assert one == same
    assert one != other


def test_fate_of_a_message_does_not_depend_on_what_others_send() -> None:
    alone = heard(bus(loss=0.3, delay=2.0, seed=5), senders=(A,))
    among = heard(bus(loss=0.3, delay=2.0, seed=5))

    assert [each for each in among if each[2] == A] == alone


def test_share_of_lost_messages_is_about_the_given_one() -> None:
    found = heard(bus(loss=0.3, seed=2), count=500)

    assert abs(len(found) / (3 * 2 * 500) - 0.7) < 0.03


def test_delays_stay_below_the_greatest_one_and_vary() -> None:
    waits = [when - sent for when, _, _, sent in heard(bus(delay=2.0, seed=2))]

    assert 0.0 <= min(waits) < 0.2
    assert 1.8 < max(waits) <= 2.0


def test_ship_that_has_left_hears_nothing_and_what_was_under_way_to_it_is_dropped() -> None:
    on = bus()
    on.post(0.0, word(A))
    on.join((A, C))
    on.post(0.0, word(A, 1))

    assert set(on.collect(0.0)) == {C}
