"""Examines a neutral and its targets: every check once, in an order in which none misleads another.

A target is first put into the order of the neutral, then into its unit and axes, then the motion
of the head is taken out; what is looked for after that is looked for in the target as it should
have been, so that one fault is one finding. Where most targets agree with each other against the
neutral, it is the neutral that is repaired.
"""

from __future__ import annotations

from collections.abc import Callable, Iterable

from elastomorph.doctor.examination import Examination, Settings
from elastomorph.doctor.patient import Patient
from elastomorph.errors import ElastomorphError
from elastomorph.model.mesh import Mesh
from elastomorph.rig import Rig

__all__ = ["examine", "examine_rig"]

Say = Callable[[str], None]


def examine(
    neutral: Mesh,
    targets: Iterable[tuple[str, Mesh | ElastomorphError]],
    settings: Settings | None = None,
    *,
    file: str = "",
    say: Say = lambda _: None,
) -> Examination:
    """Examine a neutral and its targets.

    Args:
        neutral: The neutral.
        targets: File and mesh of each target, or the error it could not be read for. Those without
            a name, or with that of another, are told by their number.
        settings: What is known beforehand.
        file: File of the neutral; by default where it was read from.
        say: Told what is being done.

    Raises:
        ParameterError: Vertices to align to that the neutral does not have, or a beam of no such
            order or closure.
    """
    settings = settings or Settings()
    return _examined(Patient(neutral, file or neutral.name, settings), targets, say)


def examine_rig(
    rig: Rig,
    settings: Settings | None = None,
    *,
    file: str = "",
    say: Say = lambda _: None,
) -> Examination:
    """Examine the shapes of a rig: its neutral, and the target at the end of every path.

    Args:
        rig: The rig.
        settings: What is known beforehand.
        file: What to call it; by default the file its neutral was read from.
        say: Told what is being done.

    Returns:
        The examination; its targets are called as in the rig.

    Raises:
        ParameterError: As `examine`.
    """
    meshes = {morph: path.target for morph, path in rig.morphs.items()}
    name = file or rig.neutral.name
    if name in meshes:
        name = f"{name} (rig)"
    patient = Patient(rig.neutral, name, settings or Settings())
    patient.name_of, patient.meshes = str, {name: rig.neutral, **meshes}
    return _examined(patient, meshes.items(), say)


def _examined(
    patient: Patient, targets: Iterable[tuple[str, Mesh | ElastomorphError]], say: Say
) -> Examination:
    say(f"examining {patient.file}")
    patient.examine_neutral()
    for number, (given, target) in enumerate(targets):
        name = given or f"target {number}"
        if name == patient.file or name in patient.done:
            name = f"{name} ({number})"
        say(f"comparing {name}")
        patient.put_in_order(name, target)
    patient.wind()
    patient.put_in_frame()
    for name in list(patient.framed):
        say(f"examining {name}")
        patient.examine_target(name)
    say("comparing targets")
    return patient.result()
