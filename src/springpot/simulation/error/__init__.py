"""Runs to a tolerance (rtol): levels, budget, decision."""
