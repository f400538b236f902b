"""A skeleton on a wider patch: the nodes added are displaced by the tractions of the others."""

from dataclasses import replace

import numpy as np

from ..mechanics.contact import Contact
from .skeleton import tractions


def widened(skeleton):
    """The same Skeleton with more nodes."""
    scene = skeleton.scene
    contact = Contact(scene, skeleton.first, skeleton.nodes)
    wide = contact.wider()
    place = contact.first - wide.first
    inner = slice(place, place + contact.size)

    def spread(v, T, U_x, U_z):
        """v on the wider patch."""
        u = contact.whole(T)[:, wide.first : wide.first + wide.size] + np.array([[U_x], [U_z]])
        u[:, inner] = v[: 2 * contact.size].reshape(2, -1)
        return np.append(u.ravel(), v[2 * contact.size :])

    def of_nodes(values, fill=0):
        """(..., nodes) of the patch on the wider one."""
        before, after = place, wide.size - contact.size - place
        return np.pad(values, [(0, 0)] * (values.ndim - 1) + [(before, after)], constant_values=fill)

    def fold(old, U):
        if old is None:
            return None
        T = tractions(scene, skeleton.first, old.v[None])[0]
        along = old.along[: 2 * contact.size].reshape(2, -1)
        along = np.append(of_nodes(along).ravel(), old.along[2 * contact.size :])
        return replace(old, v=spread(old.v, T, *U), active=of_nodes(old.active), along=along)

    def branch(old):
        T = tractions(scene, skeleton.first, old.v)
        heights = old.v[:, -1] if scene.hold == "load" else np.full(len(old.v), -scene.delta)
        v = np.array([spread(*each) for each in zip(old.v, T, old.loads, heights, strict=True)])
        return replace(old, v=v, active=of_nodes(old.active), fold=fold(old.fold, (old.end, heights[-1])))

    return replace(
        skeleton,
        first=wide.first,
        branches=tuple(map(branch, skeleton.branches)),
        jumps=tuple(fold(jump, (0.0, -jump.load)) for jump in skeleton.jumps),
        contact=skeleton.contact and widened(skeleton.contact),
    )
