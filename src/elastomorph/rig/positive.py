"""Bends turned so that their weights are positive.

b_k(t)·D_k is the same as (-b_k(t))·(-D_k), but not to every program: Blender, for one, holds the
weights of imported morph targets between 0 and 1, and plays a path whose bends have the weights
t² - t of a beam as a straight line. With t - t² it plays the path.
"""

from __future__ import annotations

from dataclasses import replace

import numpy as np

from elastomorph.model.bend_curve import BendCurve
from elastomorph.model.morph import Morph
from elastomorph.rig.rig import Rig


def with_positive_weights(rig: Rig) -> Rig:
    """The same rig, each bend turned to where its curve is farther above 0 than below.

    Curves of both signs, such as those of several scanned in-betweens, keep a smaller negative
    part.
    """
    morphs = {name: turned_positive(morph) for name, morph in rig.morphs.items()}
    if all(morphs[name] is morph for name, morph in rig.morphs.items()):
        return rig
    sliders = rig.sliders
    return Rig(rig.neutral, morphs, correctives=sliders.correctives, groups=sliders.groups)


def turned_positive(morph: Morph) -> Morph:
    """The same path, each bend turned to where its curve is farther above 0 than below."""
    values = [curve(curve.times_within(65)) for curve in morph.bend_curves]
    signs = np.array([-1.0 if -own.min() > own.max() else 1.0 for own in values])
    if (signs > 0).all():
        return morph
    curves = tuple(
        curve if sign > 0 else BendCurve(curve.breaks, 0.0 - curve.coefficients)
        for curve, sign in zip(morph.bend_curves, signs, strict=True)
    )
    return replace(morph, bends=signs[:, None, None] * morph.bends, bend_curves=curves)
