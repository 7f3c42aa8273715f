"""The ``springpot`` command: parses, calls the library, prints.  No physics here.

`commands` and `designing` have a function for each command, `flags` what they share, `tables` what they print, and
`messages` the one sentence of each failure.

Exit codes: 0 done, 1 failed while running, 2 bad usage or bad input, 130 interrupted; other than 0, one sentence on
stderr says why.  Stdout then stays empty, except that ``doctor`` prints its findings even where its self-check fails,
and ``simulate --rtol`` and ``compare`` print their results also if ``rtol`` was not reached.
"""

from __future__ import annotations

import os
import sys
from collections.abc import Sequence

from cyclopts import CycloptsError

from springpot.cli.commands import app
from springpot.cli.flags import in_flags
from springpot.cli.messages import of_the_system, one_sentence, usage
from springpot.cli.terminal import warnings_as_sentences
from springpot.machine.bar import say
from springpot.machine.faults import FileError
from springpot.machine.installed import MissingExtraError

__all__ = ["main"]


def _flush() -> None:
    if sys.stdout is not None:
        sys.stdout.flush()


def _drop_output() -> None:
    """Discard output that cannot be written, so that it is not tried again when the process ends."""
    try:
        _flush()
    except OSError:
        os.dup2(os.open(os.devnull, os.O_WRONLY), sys.stdout.fileno())


def main(arguments: Sequence[str] | None = None) -> int:
    """Run the command line and return its exit code.

    Parameters
    ----------
    arguments : sequence of str, optional
        The words after ``springpot``; those of this process if not given.

    Returns
    -------
    int
        0 done, 1 failed while running, 2 bad usage or bad input, 130 interrupted.

    Examples
    --------
    >>> main(["--version"])  # doctest: +ELLIPSIS
    0...
    0
    """
    try:
        with warnings_as_sentences():
            code = app(
                sys.argv[1:] if arguments is None else list(arguments),
                exit_on_error=False,
                print_error=False,
                result_action="return_value",
            )
        _flush()
    except CycloptsError as error:
        say(usage(error))
        return 2
    except (TypeError, ValueError) as error:
        say(one_sentence(error) if isinstance(error, FileError) else in_flags(one_sentence(error)))
        return 2
    except KeyboardInterrupt:
        say("interrupted.")
        return 130
    except BrokenPipeError:  # the reader went away (springpot ... | head): nobody is left to tell
        _drop_output()
        return 1
    except FileNotFoundError as error:  # a file to be read: bad input
        say(f"There is no file {os.fspath(error.filename)!r}." if error.filename is not None else one_sentence(error))
        return 2
    except MissingExtraError as error:
        say(str(error))
        return 1
    except OSError as error:
        _drop_output()
        say(of_the_system(error))
        return 1
    except MemoryError:
        say("there is not enough memory for this: use fewer --paths.")
        return 1
    except Exception as error:
        say(f"{type(error).__name__}: {one_sentence(error)}")
        return 1
    return int(code or 0)
