"""What generated code calls beside its blocks: compiled functions at an address, so that one loop runs every kernel; copies."""

from collections.abc import Callable
from typing import Any, ClassVar

import attrs


def intrinsic(name: str, count: int, signature: Any, code: Callable[..., Any]) -> Any:
    """Return a function of ``count`` arguments for numba, whose instructions ``code`` writes where it is called."""
    from numba import extending

    space = {"answer": (signature, code)}
    exec(f"def {name}(typing_context, {', '.join(f'a{k}' for k in range(count))}):\n    return answer", space)
    return extending.intrinsic(space[name])


@attrs.frozen
class Call:
    """A function ``name(address, ...)`` that calls the compiled function at an address, whose arguments are not looked at again.

    Parameters
    ----------
    name : name of the function.
    signature : its types, without the address.
    """

    name: str
    signature: Any

    def text(self) -> str:
        """The content, for the key of the cache."""
        return f"# {self.name} at an address: {self.signature}"

    def compiled(self) -> Any:
        """The function for numba; it is compiled where it is called."""
        from numba import int64

        own = self.signature
        return intrinsic(self.name, 1 + len(own.args), own.return_type(int64, *own.args), self._code)

    def _code(self, context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        from numba.core import cgutils

        convention, result, own = context.call_conv, signature.return_type, signature.args[1:]
        kind = convention.get_function_type(result, own).as_pointer()
        status, value = convention.call_function(builder, builder.inttoptr(arguments[0], kind), result, own, arguments[1:])
        with cgutils.if_unlikely(builder, status.is_error):
            convention.return_status_propagate(builder, status)
        return value


@attrs.frozen
class Move:
    """A function ``move(dst, at, src, first, count)`` that copies numbers from ``src[first:]`` to ``dst[at:]``, or none.

    Both are contiguous and do not overlap. A loop of few would be unrolled before it could be vectorised, and slices take long
    to compile.
    """

    name: ClassVar[str] = "move"

    def text(self) -> str:
        """The content, for the key of the cache."""
        return "# move copies numbers"

    def compiled(self) -> Any:
        """The function for numba; it is compiled where it is called."""
        from numba import extending, types

        def move(typing_context: Any, dst: Any, at: Any, src: Any, first: Any, count: Any) -> Any:
            return types.void(dst, types.int64, src, types.int64, types.int64), self._code

        return extending.intrinsic(move)

    def _code(self, context: Any, builder: Any, signature: Any, arguments: Any) -> Any:
        from numba.core import cgutils

        places = [builder.gep(context.make_array(kind)(context, builder, array).data, [index])
                  for kind, array, index in zip(signature.args[:4:2], arguments[:4:2], arguments[1:4:2], strict=True)]
        count = arguments[4]
        some = builder.select(builder.icmp_signed(">", count, count.type(0)), count, count.type(0))
        copy: Any = cgutils.raw_memcpy
        copy(builder, *places, some, 8, align=8)
        return context.get_dummy_value()


def address(function: Any) -> int:
    """Return where the code of a function begins that numba has compiled for one signature."""
    (made,) = function.overloads.values()
    return int(made.library.get_pointer_to_function(made.fndesc.llvm_func_name))
