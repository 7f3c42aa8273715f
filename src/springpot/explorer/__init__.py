"""The page in the browser: sliders, the moving mass, theory and Monte Carlo side by side, with the library's kernel.

`springpot.explorer.commands` opens it; `server` serves the browser, one `session` computes for one tab, `protocol`
defines the messages of a tab; `gathering`, `motion` and `answers` compute the numbers.
"""

from springpot.machine.installed import need

need("page", "the page in the browser")
