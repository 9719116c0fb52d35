"""Sources: friction at the bed, drag between the phases, rain."""
