"""How Numba compiles the kernel: some of its own steps are left out, which takes half off the time.

Functions that are called from compiled code only are copied into their callers, so machine code of their own is never
run: it is not made (:class:`WithoutMachineCode`), and they are optimized only so far that the caller can be.  Numba
optimizes all code twice, first to bring the counting of references into one place; the kernel counts none, so once is
enough.  It looks for closures, lists of types, branches that never run, expressions of whole arrays and so on, of which
the kernel has none.  And Python need not look for unused objects meanwhile: nearly all that is made is kept.
"""

from __future__ import annotations

import contextlib
import gc
from collections.abc import Iterator
from typing import Any

from llvmlite.binding.newpassmanagers import create_new_module_pass_manager
from numba._dynfunc import make_function
from numba.core.codegen import JITCodeLibrary
from numba.core.compiler import Compiler
from numba.core.compiler_machinery import register_pass
from numba.core.typed_passes import InlineOverloads, NativeLowering, NopythonRewrites
from numba.core.untyped_passes import (
    DeadBranchPrune,
    FindLiterallyCalls,
    InlineClosureLikes,
    InlineInlinables,
    LiteralPropagationSubPipelinePass,
    LiteralUnroll,
    MakeFunctionToJitFunction,
    RewriteDynamicRaises,
    RewriteSemanticConstants,
    WithLifting,
)

# LLVM takes half of an AVX-512 processor's vectors unless it is asked; on processors without them this says nothing.
_WHOLE_VECTORS = '"prefer-vector-width"="512"'


class _OptimizedOnce(JITCodeLibrary):  # type: ignore[misc]
    def add_ir_module(self, ir_module: Any) -> None:
        for function in ir_module.functions:
            if not function.is_declaration:
                set.add(function.attributes, _WHOLE_VECTORS)  # its own `add` knows flags only, no pairs
        super().add_ir_module(ir_module)

    def _optimize_functions(self, module: Any) -> None:
        module.data_layout = self._codegen._data_layout
        manager, builder = self._codegen._function_pass_manager()
        for function in module.functions:
            if not function.is_declaration:
                manager.run(function, builder)

    def _optimize_final_module(self) -> None:
        manager, builder = self._codegen._module_pass_manager()
        manager.run(self._final_module, builder)


class _Intermediate(_OptimizedOnce):
    """Code that callers link in; it never becomes machine code."""

    def _optimize_functions(self, module: Any) -> None:
        module.data_layout = self._codegen._data_layout

    def _optimize_final_module(self) -> None:
        """What is called copied in, and what that leaves to do more than once: the rest is for the caller."""
        manager = create_new_module_pass_manager()
        manager.add_always_inliner_pass()
        manager.add_sroa_pass()
        manager.add_simplify_cfg_pass()
        manager.add_new_gvn_pass()
        manager.add_instruction_combine_pass()
        manager.add_simplify_cfg_pass()
        manager.add_global_dead_code_eliminate_pass()
        manager.run(self._final_module, self._codegen._pass_builder())

    def _finalize_final_module(self) -> None:
        self._finalized = True


@register_pass(mutates_CFG=True, analysis_only=False)
class _Lowering(NativeLowering):  # type: ignore[misc]
    _name = "lowering_optimized_once"

    def run_pass(self, state: Any) -> bool:
        state.library = _OptimizedOnce(state.targetctx.codegen(), state.func_id.func_qualname)
        state.library.enable_object_caching()
        changed: bool = super().run_pass(state)
        return changed


@register_pass(mutates_CFG=True, analysis_only=False)
class _LoweringForCallers(NativeLowering):  # type: ignore[misc]
    """As Numba's, up to the code that callers need."""

    _name = "lowering_without_machine_code"

    def run_pass(self, state: Any) -> bool:
        name = state.func_id.func_qualname
        state.library = _Intermediate(state.targetctx.codegen(), name)
        state.flags.no_compile = True
        changed: bool = super().run_pass(state)
        code = state.cr
        # Numba tells the overloads of a function apart by such an object; without a wrapper none of them can be called
        never_called = make_function(
            code.fndesc.lookup_module(), name, f"{name}, inside compiled code", 0, code.env, (state.library,)
        )
        state.targetctx.insert_user_function(never_called, code.fndesc, [state.library])
        state["cr"] = code._replace(cfunc=never_called)
        return changed


@contextlib.contextmanager
def _nothing_collected() -> Iterator[None]:
    """Without the search for unused objects, in all threads: it goes through all that Numba keeps, again and again."""
    was_on = gc.isenabled()
    gc.disable()
    try:
        yield
    finally:
        if was_on:
            gc.enable()


class OptimizedOnce(Compiler):  # type: ignore[misc]
    """Numba's compiler, for ``pipeline_class`` of a function that Python calls."""

    lowering: type[NativeLowering] = _Lowering
    left_out: tuple[type, ...] = (
        DeadBranchPrune, FindLiterallyCalls, InlineClosureLikes, InlineInlinables, InlineOverloads,
        LiteralPropagationSubPipelinePass, LiteralUnroll, MakeFunctionToJitFunction, NopythonRewrites,
        RewriteDynamicRaises, RewriteSemanticConstants, WithLifting,
    )  # fmt: skip

    def compile_extra(self, function: Any) -> Any:
        with _nothing_collected():
            return super().compile_extra(function)

    def define_pipelines(self) -> list[Any]:
        managers: list[Any] = super().define_pipelines()
        for manager in managers:
            manager.passes = [
                (self.lowering if kind is NativeLowering else kind, said)
                for kind, said in manager.passes
                if kind not in self.left_out
            ]
            manager.finalize()
        return managers


class WithoutMachineCode(OptimizedOnce):
    """The same, of a function that only compiled code calls."""

    lowering = _LoweringForCallers


class OfUser(WithoutMachineCode):
    """The same, of a user's function, in which anything may stand that Numba can compile."""

    left_out = ()
