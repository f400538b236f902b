"""Uploaded profiles, by the names that identify them in an address."""

import hashlib

from cachetools import LRUCache

from solver import ProfileError

KEPT = 32  # profiles in the cache, the latest used


class Profiles:
    """The profiles of this server, by name."""

    def __init__(self):
        self._kept = LRUCache(KEPT)

    def name_of(self, profile):
        """Keep a Profile, and return its name."""
        name = hashlib.sha256(profile.heights + f" {profile.length!r}".encode()).hexdigest()[:12]
        self._kept[name] = profile
        return name

    def profile_of(self, name):
        """Return the Profile of a name; raises ProfileError."""
        profile = self._kept.get(name)
        if profile is None:
            raise ProfileError("this server does not have the profile of this address. Choose the file again")
        return profile


uploaded = Profiles()
