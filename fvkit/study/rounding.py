"""What counts as rounding in a report."""

#: Errors below this have no order, and make no curve worth drawing.
ROUNDING = 1e-13
