"""Object files by Numba: what it makes of a function before any machine code, and LLVM's passes for a target.

Numba reads, types and lowers the function, which takes most of the time.  What it then has is no machine code, and does
not depend on this processor (:class:`springpot.simulation.kernel.numba_passes.WithoutMachineCode`); so one form serves
all targets, this machine's too, and objects of a release have the bits of what is compiled here.  LLVM's levels of
optimization 1 to 3 make no difference, in time or in bits: everything is written as vectors; loops over lanes in
observers need 2.
"""

from __future__ import annotations

import importlib
from collections.abc import Callable, Mapping
from typing import Any

import llvmlite.binding as llvm
from numba import __version__, cfunc, njit, types
from numba.core.compiler_lock import global_compiler_lock

from springpot.simulation.kernel.kept import SYMBOL, Code
from springpot.simulation.kernel.lanes import FAST, LINKED, QUICK
from springpot.simulation.kernel.targets import Target

LEVEL = 3
# of what is called by its address only, for a Numba that is not known
_ALONE: dict[str, Any] = {"no_cpython_wrapper": True, "no_cfunc_wrapper": True, **FAST}
_IN_LLVM = {
    types.int64: "i64", types.uint64: "i64", types.int32: "i32", types.uint32: "i32",
    types.float64: "double", types.float32: "float",
}  # fmt: skip


IF_UNTESTED = () if QUICK else (Exception,)  # what another Numba may raise: then it compiles as any callback


def object_of_entry(module: str, name: str, arguments: tuple[str, ...], goal: Target) -> bytes:
    """An object file of a function of a module, whose arguments are said in words."""
    return object_of(getattr(importlib.import_module(module), name), signature_of(arguments), goal)


def entry_alone(module: str, name: str, arguments: tuple[str, ...]) -> Code:
    """The same, by what all versions of Numba have."""
    return alone(getattr(importlib.import_module(module), name), signature_of(arguments))


def alone(function: Callable[..., None], signature: Any) -> Code:
    """A function as Numba compiles any callback, for this process; what it raises is said on stderr."""
    code = cfunc(signature, **FAST)(function)
    return Code(code.address, f"compiled by Numba {__version__} for this process alone", code)


def signature_of(arguments: tuple[str, ...]) -> Any:
    """Numba's signature of a function that returns nothing."""
    kinds = [
        types.CPointer(getattr(types, each[:-1])) if each.endswith("*") else getattr(types, each) for each in arguments
    ]
    return types.void(*kinds)


def object_of(
    function: Callable[..., None], signature: Any, goal: Target, flags: Mapping[str, Any] | None = None
) -> bytes:
    """An object file with the function under the name SYMBOL, called as C calls it.

    Raises
    ------
    numba.core.errors.NumbaError
        If Numba cannot compile it.
    """
    made = njit(signature, **(flags or (LINKED if QUICK else _ALONE)))(function)
    (code,) = made.overloads.values()
    with global_compiler_lock:
        code.library._ensure_finalized()
    return _emitted(str(code.library._final_module), code.fndesc.llvm_func_name, signature, goal)


def _emitted(text: str, inner: str, signature: Any, goal: Target) -> bytes:
    llvm.initialize_all_targets()
    llvm.initialize_all_asmprinters()
    relocation, distance = goal.distance
    machine = llvm.Target.from_triple(goal.triple).create_target_machine(
        cpu=goal.cpu, features=goal.features, opt=LEVEL, reloc=relocation, codemodel=distance
    )
    module, outside = llvm.parse_assembly(text), llvm.parse_assembly(_as_c_calls_it(inner, signature))
    for each in (module, outside):
        each.triple, each.data_layout = goal.triple, str(machine.target_data)
    module.link_in(outside)
    own = [each for each in (*module.functions, *module.global_variables) if not each.is_declaration]
    for number, each in enumerate(each for each in own if each.name != SYMBOL):
        each.linkage, each.name = "internal", f"{SYMBOL}_{number}"  # Numba's names differ from process to process
    module.name = SYMBOL
    tuning = llvm.create_pipeline_tuning_options(LEVEL)
    tuning.loop_vectorization, tuning.slp_vectorization = True, False
    builder = llvm.create_pass_builder(machine, tuning)
    builder.getModulePassManager().run(module, builder)
    module.verify()
    return bytes(machine.emit_object(module))


def _as_c_calls_it(inner: str, signature: Any) -> str:
    """Numba's own functions have two places more, for what they return and raise.

    It has the attribute that they have (:mod:`springpot.simulation.kernel.numba_passes`), since it takes them in.
    """
    kinds = [_IN_LLVM.get(kind, "ptr") for kind in signature.args]
    takes = ", ".join(f"{kind} %{number}" for number, kind in enumerate(kinds))
    return f"""
        define void @{SYMBOL}({takes}) "prefer-vector-width"="512" {{
          %returned = alloca ptr
          %raised = alloca ptr
          call i32 @"{inner}"({", ".join(["ptr %returned", "ptr %raised", *filter(None, [takes])])})
          ret void
        }}
        declare i32 @"{inner}"({", ".join(["ptr", "ptr", *kinds])})
    """
