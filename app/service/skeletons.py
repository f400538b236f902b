"""Cache of the Skeletons from which maps are predicted, pickled in single precision, for all visitors."""

import pickle
from io import BytesIO

import numpy as np

from app.service import metrics
from app.service.cache import Cache

CAPACITY = 200e6  # bytes: 13 maps of different scenes; a class of 30 then needs less than 1.2 GB
FEW = 64  # largest size of an array that keeps double precision


class _Pickler(pickle.Pickler):
    """Writes float64 arrays as float32: an error of 1e-6 nm, while following corrects states to 1e-5 nm."""

    def reducer_override(self, thing):
        if type(thing) is not np.ndarray or thing.dtype != np.float64 or thing.size <= FEW:
            return NotImplemented
        return _array, (thing.astype("<f4").tobytes(), thing.shape)


def _array(numbers, shape):
    """Restore a float64 array that `_Pickler` wrote."""
    return np.frombuffer(numbers, "<f4").astype(float).reshape(shape)


def pickled(skeleton):
    """Return a Skeleton as bytes for `pickle.loads`, half the size of `pickle.dumps`."""
    file = BytesIO()
    _Pickler(file).dump(skeleton)
    return file.getvalue()


skeletons = Cache(CAPACITY)  # by Scene; without one nearby, a point of a map needs a full run
metrics.gauge("skeletons_bytes", "bytes of the states of maps in the cache", lambda: skeletons.currsize)
