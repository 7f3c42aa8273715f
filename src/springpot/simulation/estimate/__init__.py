"""From rows of sums to values, errors and bounds."""
