"""One sentence for each error: what is wrong in a command, and what would be right."""

from __future__ import annotations

import os
from collections.abc import Sequence
from typing import get_args

from cyclopts import (
    CoercionError,
    CycloptsError,
    MissingArgumentError,
    RepeatArgumentError,
    Token,
    UnknownCommandError,
    UnknownOptionError,
    UnusedCliTokensError,
)

from springpot.cli.commands import app
from springpot.cli.flags import in_flags
from springpot.machine.faults import listed, nearest

_PAIRS = {"--window": "two times, START and END", "--springpot": "two numbers, ORDER and K_ALPHA"}


def one_sentence(error: BaseException) -> str:
    return " ".join(str(error).split()) or type(error).__name__


def usage(error: CycloptsError) -> str:
    """The sentence for an error in the words of a command."""
    command = " ".join(["springpot", *(error.command_chain or ())])
    match error:
        case UnknownCommandError(unused_tokens=[word, *_]):
            names = [name for name in app if not name.startswith("-")]
            return f"there is no command {word!r}{_meant(word, names) or f': the commands are {listed(names)}.'}"
        case UnknownOptionError(token=token):
            word = token.keyword or token.value
            names = [name for argument in error.argument_collection for name in argument.names]
            word = " ".join(word.split())
            return f"there is no flag {word}{_meant(word, names) or f': {command} --help lists all flags.'}"
        case UnusedCliTokensError(unused_tokens=[word, *_]):
            return _too_many(word, error, command)
        case CoercionError(token=Token(keyword=None, value=word), argument=argument) if is_file(argument):
            return _too_many(word, error, command)
        case MissingArgumentError(argument=argument) if argument is not None:
            name = error.keyword or argument.name
            return f"{name} needs {_PAIRS.get(name, f'a value: {command} --help says which')}."
        case RepeatArgumentError(token=token):
            return f"{token.keyword} must be given only once."
        case CoercionError(token=Token() as token):
            return _unfit(error, token)
    error.verbose = False
    return one_sentence(error)


def _too_many(word: str, error: CycloptsError, command: str) -> str:
    """A word that neither a flag nor the command takes, a file of a system apart."""
    words = [*(error.root_input_tokens or ())]
    before = words[: words.index(word)] if word in words else []
    flag = next((each for each in reversed(before) if each.startswith("--")), "")
    right = f"{flag} takes {_PAIRS[flag]}" if flag in _PAIRS else f"{command} --help shows what it takes"
    return f"{word!r} is one word too many: {right}."


def is_file(argument: object) -> bool:
    """Whether an argument is the file of a system."""
    return getattr(argument, "name", "").lstrip("-").lower() == "file"


def _unfit(error: CoercionError, token: Token) -> str:
    """The sentence for a value of the wrong type."""
    name = token.keyword or (error.argument.name.lstrip("-").upper() if error.argument else "the word")
    if error.target_type is bool:
        return f"{name} is a switch: it takes no value such as {token.value!r}."
    chosen = [repr(word) for word in get_args(error.target_type) if isinstance(word, str | int)]
    if chosen:
        wanted = listed(chosen, "or")
    elif name in _PAIRS:
        wanted = _PAIRS[name]
    else:
        wanted = "a whole number" if error.target_type is int else "a number"
    return f"{name} must be {wanted}, not {token.value!r}."


def _meant(word: str, names: Sequence[str]) -> str:
    """A question, if one of the names is close; compared without hyphens, which all flags have."""
    plain = {name.lstrip("-"): name for name in names}
    close = nearest(word.lstrip("-"), plain)
    return f"; did you mean {plain[close]}?" if close else ""


def of_the_system(error: OSError) -> str:
    """The sentence for an OSError, without its number; errors of the library are sentences already."""
    if error.strerror is None:
        sentence = one_sentence(error)
        return in_flags(sentence) if isinstance(error, TimeoutError) else sentence  # of max_time; others name files
    place = "reading or writing" if error.filename is None else repr(os.fspath(error.filename))
    return f"{place} failed: {error.strerror}."
