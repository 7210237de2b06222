"""Time left: what a stage takes is known from others of its kind, else from how slow all are."""

from __future__ import annotations

from elastomorph.capturing.work.progress import Progress


class Clock:
    now = 0.0

    def __call__(self) -> float:
        return self.now


def test_nothing_is_said_of_the_rest_before_anything_was_measured() -> None:
    said: list[str] = []
    say = Progress(said.append, {"a": 100}, Clock()).begun("a")
    say("working", 0.0)
    assert said == ["working"]


def test_stages_of_a_kind_take_as_long_as_those_that_are_done() -> None:
    said: list[str] = []
    clock = Clock()
    expected = {"cameras/a": 10.0, "cameras/b": 20.0, "poses/b": 100.0}
    progress = Progress(said.append, expected, clock)
    progress.done("cameras/a", 30.0)
    say = progress.begun("cameras/b")
    say("working", 0.0)  # 60 s for the second, 300 s for what is slower as all was
    assert said[-1] == "working · about 6 min left"
    clock.now = 30.0
    say("working", 0.5)  # the rest of it as its first half; slower by (30 + 30) / (10 + 10)
    assert said[-1] == "working · about 6 min left"
    clock.now = 60.0
    progress.done("cameras/b", 60.0)
    say = progress.begun("poses/b")
    say("tracking", 0.0)
    assert said[-1] == "tracking · about 5 min left"
    clock.now += 90.0
    say("tracking", 0.9)
    assert said[-1] == "tracking · about 10 s left"


def test_what_an_earlier_run_made_is_known() -> None:
    said: list[str] = []
    progress = Progress(said.append, {"poses/a": 1.0, "poses/b": 1.0}, Clock())
    progress.done("poses/a", 7200.0, anew=False)
    progress.begun("poses/b")("tracking", 0.0)
    assert said == ["tracking · about 2.0 h left"]
