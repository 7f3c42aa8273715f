"""The analytical methods, a module or a room for each; `springpot.theory.registry` lists them."""
