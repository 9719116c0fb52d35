"""Output: solutions, file formats and plots."""
