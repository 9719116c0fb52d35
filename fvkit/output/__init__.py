"""Output: solutions, their files and their pictures."""
