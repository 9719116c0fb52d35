"""Stages of schemes: pointwise code at faces and in cells."""
