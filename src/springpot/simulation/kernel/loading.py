"""Object files, loaded into this process by llvmlite."""

from __future__ import annotations

import struct
import sys
from dataclasses import dataclass
from functools import cache
from typing import Any

import llvmlite.binding as llvm

SYMBOL = "springpot"  # the name of the function in its object file


class MissingSymbolError(RuntimeError):
    """Machine code needs a function that this process does not have."""


@dataclass(frozen=True, eq=False)
class Code:
    """Machine code in memory, for as long as this object lives.

    Attributes
    ----------
    address : int
        Of the function.
    how : str
        Where it comes from, in words.
    held : object
        What owns the memory.
    """

    address: int
    how: str
    held: Any


def loaded(content: bytes, how: str) -> Code:
    """The function of an object file.

    Raises
    ------
    MissingSymbolError
        If it needs functions that this process does not have; LLVM would end the process.
    """
    llvm.initialize_native_target()
    llvm.initialize_native_asmprinter()
    machine = llvm.Target.from_default_triple().create_target_machine()
    engine = llvm.create_mcjit_compiler(llvm.parse_assembly(""), machine)
    if missing := sorted(name for name in needed(content) if not _found(name)):
        raise MissingSymbolError(f"it needs {', '.join(missing)}, which this process does not have")
    engine.add_object_file(llvm.object_file.ObjectFileRef.from_data(content))
    engine.finalize_object()
    return Code(engine.get_function_address(SYMBOL), how, engine)


@cache
def _found(symbol: str) -> bool:
    if sys.platform == "linux":
        for library in ("libc.so.6", "libm.so.6"):  # Python itself may be linked with none of it
            try:
                llvm.load_library_permanently(library)
            except RuntimeError:
                continue
    return llvm.address_of_symbol(symbol) is not None


def needed(content: bytes) -> set[str]:
    """Functions that an object in the form ELF does not hold itself; of another form none is found."""
    if content[:6] != b"\x7fELF\x02\x01":
        return set()
    sections = {
        section.name(): section.data() for section in llvm.object_file.ObjectFileRef.from_data(content).sections()
    }
    names = sections[b".strtab"]
    found = set()
    for name, _, _, section, _, _ in struct.iter_unpack("<IBBHQQ", sections[b".symtab"]):
        if name and section == 0:
            found.add(names[name : names.index(b"\0", name)].decode())
    return found
