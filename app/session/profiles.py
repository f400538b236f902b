"""Measured profiles in an address: a small one as text, a larger one by a name that this server knows for a while."""

import base64
import hashlib
import zlib

import numpy as np
from cachetools import LRUCache

from solver import Profile, ProfileError
from solver.scene import LIMITS

LONGEST = 1500  # characters: what an address takes, and mail and chat pass on
LEVELS = 32767  # of the heights on either side of zero
MOST = int(LIMITS["nodes"].high)  # heights
KEPT = 32  # profiles


class Profiles:
    """Profiles by the text that stands for them, those used last."""

    def __init__(self):
        self._known, self._texts = LRUCache(KEPT), LRUCache(KEPT)

    def text_of(self, profile):
        """What brings a Profile back: length (nm), height per level (nm), its heights packed; a name if that is long.

        Heights are given to 1/65534 of the largest. Here they come back exactly, as long as the profile is known.
        """
        text = self._texts.get(profile)
        if text is None:
            text = _packed(profile)
            if len(text) > LONGEST:
                text = "known-" + hashlib.sha256(profile.heights).hexdigest()[:12]
            self._texts[profile] = text
        self._known[text] = profile
        return text

    def profile_of(self, text):
        """The Profile of such a text; raises ProfileError."""
        profile = self._known.get(text)
        if profile is None and text.startswith("known-"):
            raise ProfileError("this server no longer has it; choose the file again")
        return profile or _unpacked(text)


known = Profiles()


def _unpacked(text):
    try:
        length, level, packed = text.split("*")
        body = zlib.decompressobj().decompress(base64.urlsafe_b64decode(packed), 2 * MOST)
        heights = float(level) * np.cumsum(np.frombuffer(body, "<i2"), dtype="<i2")
        return Profile(float(length), heights, ("read from an address, heights to 1/65534 of the largest.",))
    except (ValueError, TypeError, zlib.error) as error:  # ProfileError among them
        reason = error if isinstance(error, ProfileError) else "it cannot be read"
        raise ProfileError(f"{reason}; choose the file again") from None


def _packed(profile):
    level = max(float(np.abs(profile.z).max()), 1e-9) / LEVELS
    heights = np.rint(profile.z / level).astype("<i2")
    steps = np.diff(heights, prepend=np.int16(0)).astype("<i2")  # modulo 65536, undone by the sum
    packed = base64.urlsafe_b64encode(zlib.compress(steps.tobytes(), 9)).decode()
    return f"{profile.length:.12g}*{level:.9g}*{packed}"
