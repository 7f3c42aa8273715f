"""How far theory may be trusted: comparison with Monte Carlo, validity maps, the atlas, the recommended method."""
