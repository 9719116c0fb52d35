"""Scenes: physics without numerics, their references, files and the built-in ones."""
