"""Pinned runs: up to four stay in view behind the run on screen, to compare with."""
