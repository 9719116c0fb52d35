"""Terrain: elevation rasters and release areas in; rasters, scores and maps out."""
