"""Methods for systems of parts."""
