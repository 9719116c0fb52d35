"""Commands of `fvkit` on granular scenes, a file for each."""
