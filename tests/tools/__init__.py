"""What the developers of fvkit run from a checkout, and no user needs: the long forms of some tests."""
