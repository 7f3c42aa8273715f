"""The page in the browser: sliders, the moving mass, theory and Monte Carlo side by side, fed by the real kernel.

`springpot.explorer.commands` opens it; `server` answers the browser, one `session` computes for one tab, `protocol`
says what a tab may ask for; `gathering`, `motion` and `answers` are the numbers.
"""
