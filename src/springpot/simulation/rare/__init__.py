"""Rare events: splitting of paths, which keeps those that come near to the event and branches them."""
