"""Observers of granular flows: the front of a flow, and maps of the hazard."""
