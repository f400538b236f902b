"""Skeletons from which maps are followed: pickled small, and kept for all visitors up to so many bytes."""

import pickle
from contextlib import suppress
from io import BytesIO

import numpy as np
from cachetools import LRUCache

from app.service import metrics

CAPACITY = 200e6  # bytes: 13 maps of other scenes; a class of 30 then takes less than 1.2 GB in all
FEW = 64  # numbers of an array that is pickled as it is


class Skeletons(LRUCache):
    """Pickled Skeletons by Scene, those used last. A point of a map is run where no Skeleton nearby is kept."""

    def __init__(self, capacity=CAPACITY):
        super().__init__(capacity, len)

    def put(self, scene, skeleton):
        """Keep a pickled Skeleton, unless it is larger than all that may be kept."""
        with suppress(ValueError):
            self[scene] = skeleton


class _Pickler(pickle.Pickler):
    """Writes arrays of float64 as float32: off by 1e-6 nm, while following corrects states to 1e-5 nm."""

    def reducer_override(self, thing):
        if type(thing) is not np.ndarray or thing.dtype != np.float64 or thing.size <= FEW:
            return NotImplemented
        return _array, (thing.astype("<f4").tobytes(), thing.shape)


def _array(numbers, shape):
    """The array of float64 that `_Pickler` wrote."""
    return np.frombuffer(numbers, "<f4").astype(float).reshape(shape)


def pickled(skeleton):
    """A Skeleton as bytes for `pickle.loads`, half as many as of `pickle.dumps`."""
    file = BytesIO()
    _Pickler(file).dump(skeleton)
    return file.getvalue()


skeletons = Skeletons()
metrics.gauge("skeletons_bytes", "of the states of maps that are kept", lambda: skeletons.currsize)
