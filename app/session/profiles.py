"""Measured profiles in an address: a small one as text, a larger one by a name that this server knows for a while."""

import base64
import hashlib
import zlib
from collections import OrderedDict
from threading import Lock

import numpy as np

from solver import Profile, ProfileError
from solver.scene import LIMITS

LONGEST = 1500  # characters: what an address takes, and mail and chat pass on
LEVELS = 32767  # of the heights on either side of zero
MOST = int(LIMITS["nodes"].high)  # heights
KEPT = 32  # profiles
_known, _texts, _lock = OrderedDict(), {}, Lock()  # {text: Profile}, {Profile: text}


def text_of(profile):
    """What brings a Profile back: length (nm), height per level (nm) and its heights, packed; a name if that is long.

    Heights are given to 1/65534 of their range. This server gives them back exactly, as long as it knows the profile.
    """
    with _lock:
        if profile not in _texts:
            text = _packed(profile)
            if len(text) > LONGEST:
                text = "known-" + hashlib.sha256(profile.heights).hexdigest()[:12]
            _texts[profile], _known[text] = text, profile
            if len(_known) > KEPT:
                _texts.pop(_known.popitem(last=False)[1], None)
        return _texts[profile]


def profile_from(text):
    """The Profile of such a text; raises ProfileError."""
    with _lock:
        if text in _known:
            _known.move_to_end(text)
            return _known[text]
    if text.startswith("known-"):
        raise ProfileError("this server no longer has it; choose the file again")
    try:
        length, level, packed = text.split("*")
        body = zlib.decompressobj().decompress(base64.urlsafe_b64decode(packed), 2 * MOST)
        heights = float(level) * np.cumsum(np.frombuffer(body, "<i2"), dtype="<i2")
        return Profile(float(length), heights, ("read from an address, heights to 1/65534 of their range.",))
    except (ValueError, TypeError, zlib.error) as error:  # ProfileError among them
        reason = error if isinstance(error, ProfileError) else "it cannot be read"
        raise ProfileError(f"{reason}; choose the file again") from None


def _packed(profile):
    level = max(float(np.abs(profile.z).max()), 1e-9) / LEVELS
    heights = np.rint(profile.z / level).astype("<i2")
    steps = np.diff(heights, prepend=np.int16(0)).astype("<i2")  # modulo 65536, undone by the sum
    packed = base64.urlsafe_b64encode(zlib.compress(steps.tobytes(), 9)).decode()
    return f"{profile.length:.12g}*{level:.9g}*{packed}"
