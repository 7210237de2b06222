"""Order of packets: lost, late, twice, past midnight and from the start again."""

from __future__ import annotations

import random

from hypothesis import given
from hypothesis import strategies as st

from elastomorph.live.packets import encode
from elastomorph.live.session import MOST_PHONES, Phone, Phones, PhoneStatus, Session
from streams import packet

DAY = 86_400 * 60


def phone() -> Phone:
    return Phone(0, "one", "iPhone", "10.0.0.2")


def standing(one: Phone, now: float = 0.0) -> PhoneStatus:
    return one.standing(now, True)


def test_in_order_nothing_is_odd() -> None:
    one = phone()
    orders = [one.take(packet(frame), frame / 60)[0] for frame in range(100)]
    assert set(orders) == {"new"}
    found = standing(one, 99 / 60)
    assert (found.packets, found.missing, found.late, found.twice) == (100, 0, 0, 0)
    assert abs(found.rate - 60) < 0.5


def test_every_second_number_is_a_rate_and_no_loss() -> None:
    """At 30 frames a second a phone that counts sixtieths leaves out every second number."""
    one = phone()
    for frame in range(0, 200, 2):
        one.take(packet(frame), frame / 60)
    assert standing(one).missing <= 1


@given(st.integers(0, 10_000), st.floats(0, 0.1), st.floats(0, 0.1))
def test_lost_late_and_twice_are_counted(seed: int, lost: float, shuffled: float) -> None:
    """Of a stream that was damaged on purpose, the counts are those of the damage."""
    chance = random.Random(seed)
    frames = list(range(400))
    gone = {frame for frame in frames[40:-1] if chance.random() < lost}
    left = [frame for frame in frames if frame not in gone]
    place, late = 40, 0
    while place < len(left) - 2:
        if chance.random() < shuffled:
            left[place], left[place + 1] = left[place + 1], left[place]
            place, late = place + 1, late + 1
        place += 1
    one = phone()
    newest = -1
    for place, frame in enumerate(left):
        order, _ = one.take(packet(frame), place / 60)
        assert order == ("new" if frame > newest else "late")
        newest = max(newest, frame)
        assert one.packet is not None
        assert one.packet.frame == newest
    found = standing(one)
    assert found.missing == len(gone)
    assert found.late == late
    assert one.take(packet(left[5]), len(left) / 60)[0] in ("twice", "apart")


def test_a_packet_that_comes_again() -> None:
    one = phone()
    orders = [one.take(packet(frame), 0.1)[0] for frame in (5, 5, 6, 7, 6, 5)]
    assert orders == ["new", "twice", "new", "new", "twice", "twice"]
    assert standing(one).twice == 3


def test_midnight_is_only_another_frame() -> None:
    one = phone()
    places = [one.take(packet(frame % DAY), frame / 60)[1] for frame in range(DAY - 3, DAY + 4)]
    assert places == list(range(DAY - 3, DAY + 4))
    found = standing(one)
    assert (found.missing, found.late) == (0, 0)


def test_a_pause_is_no_loss_and_a_stream_may_begin_anew() -> None:
    one = phone()
    for frame in (100, 101, 102):
        one.take(packet(frame), frame / 60)
    assert one.take(packet(102 + 60 * 60), 70.0)[0] == "new"  # a minute later
    assert standing(one).missing == 0
    assert one.take(packet(10), 72.0)[0] == "again"
    assert one.take(packet(11), 72.1)[0] == "new"
    orders = [one.take(packet(12 + n, rate=(24, 1)), 72.2 + n / 24)[0] for n in range(8)]
    assert orders == ["apart"] * 6 + ["again", "new"]  # of another rate, at once


def test_another_stream_under_its_id_is_left_out() -> None:
    """Else one who sends under the id of a phone would make a file of every packet."""
    one = phone()
    leaps = [0, 500_000, 90_000, 4_000_000, 7_000]
    orders = []
    for n in range(200):
        orders.append(one.take(packet(1000 + n), n / 60)[0])
        orders.append(one.take(packet(leaps[n % 5] + n), n / 60 + 0.005)[0])
    assert orders == ["new", "apart"] * 200
    assert standing(one, 200 / 60).text().endswith("200 of another stream by its id")


def test_the_first_is_shown_and_others_are_known() -> None:
    phones = Phones()
    for name in ("left", "right"):
        phones.of(packet(1, subject=name, device=name), "10.0.0.3", 0.0)
    assert phones.shown is not None
    assert phones.shown.subject == "left"
    assert [one.subject for one in phones.known()] == ["left", "right"]
    assert phones.choose(1)
    assert phones.shown.subject == "right"
    assert not phones.choose(7)


def test_the_one_wanted_is_waited_for() -> None:
    now = 0.0
    session = Session(["jawOpen"], subject="right", clock=lambda: now)
    session.take(encode(packet(1, subject="left", device="left")), "10.0.0.3")
    assert session.newest(0, 0) is None
    assert session.status().text() == "no packets of 'right' yet · also sending: left"
    now = 2.0
    assert session.status().text() == "no packets of 'right' yet"
    session.take(encode(packet(16, subject="right", device="right")), "10.0.0.4")
    pose = session.newest(0, 0)
    assert pose is not None
    assert pose.weights == [0.25]


def test_only_so_many_are_kept_apart() -> None:
    """A flood under ever new names takes no memory."""
    session = Session(["jawOpen"])
    for number in range(10 * MOST_PHONES):
        session.take(encode(packet(1, device=str(number), subject=f"p{number}")), "10.0.0.5")
    found = session.status()
    assert len(found.phones) == MOST_PHONES
    assert found.beyond == 9 * MOST_PHONES
    assert f"{9 * MOST_PHONES} packets of further phones" in found.text()


def test_those_who_are_gone_give_way() -> None:
    """Strangers who sent once do not keep a phone out for ever."""
    now = 0.0
    session = Session(["jawOpen"], subject="wanted", clock=lambda: now)
    for number in range(MOST_PHONES):
        session.take(encode(packet(1, device=str(number), subject="p")), "10.0.0.5")
    session.take(encode(packet(1, device="late")), "10.0.0.6")
    assert session.status().beyond == 1
    session.take(encode(packet(1, device="w", subject="wanted")), "10.0.0.6")
    now = 11.0
    session.take(encode(packet(1, device="late")), "10.0.0.6")
    phones = session.status().phones
    assert [phone.number for phone in phones] == [*range(2, MOST_PHONES), 8, 9]
    assert session.status().shown == phones[-2]
