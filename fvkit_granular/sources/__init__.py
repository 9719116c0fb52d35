"""Sources: basal friction, drag between the phases, rain and infiltration."""
