"""Kernels on the CPU, started in the calling thread without the work that Warp does for every launch.

On the CPU Warp 1.19 calls a kernel as a function of its bounds and of its arguments, one after another in memory. Warp
records one launch, which loads the kernel; of later ones only the arguments are laid out anew.
"""

import ctypes
from collections.abc import Callable, Sequence
from copy import copy
from functools import cache
from typing import Any, NamedTuple
from weakref import ref

import numpy as np
import warp as wp

from metrics.kernels.making import MAKING
from metrics.kernels.starting import start_warp

Dim = int | tuple[int, ...]
NUMBERS = (int, float)


def on_cpu(kernel: wp.Kernel, dim: int, inputs: Sequence[Any]) -> None:
    """Run a kernel, also on the host's own contiguous arrays. Raises TypeError for inputs of another kind."""
    if dim:
        host_launch(kernel, dim, inputs).launch()


def host_launch(kernel: wp.Kernel, dim: Dim, inputs: Sequence[Any]) -> "HostLaunch":
    """A launch that is ready to be started.

    inputs: Warp's arrays on the CPU and structures, the host's contiguous arrays (vectors have an axis more, matrices
    two), numbers. Raises TypeError for one of another kind than the kernel takes; a generic one takes that of its first
    launch.
    """
    loaded = _LOADED.get(kernel)
    if loaded is None:
        with MAKING:
            loaded = _LOADED.get(kernel) or Loaded(kernel, dim, inputs)
            loaded.arguments(inputs)  # what cannot be launched sets no kinds
            _LOADED[kernel] = loaded
    return HostLaunch(loaded, dim, inputs)


class HostLaunch:
    """A launch of a kernel, its bounds and its arguments, which can be laid out again for other inputs.

    inputs: what it holds until it lets go of them, since its arguments need their memory.
    """

    __slots__ = ("_known", "arguments", "bounds", "inputs", "of")

    def __init__(self, of: "Loaded", dim: Dim, inputs: Sequence[Any]) -> None:
        self.of, self.bounds, self.arguments = of, of.bounds(dim), of.arguments(inputs)
        self._known = list[Any]()
        self.inputs: Sequence[Any] = tuple(inputs)

    @property
    def kernel(self) -> wp.Kernel:
        """What is launched."""
        return self.of.kernel

    def launch(self) -> None:
        """Run it in the calling thread."""
        self.of.function(ctypes.byref(self.bounds), ctypes.byref(self.arguments))

    def only(self, rows: range, dim: Callable[[int], Dim]) -> None:
        """Have it take these rows, of which the first one is its first input. dim: of so many."""
        self.arguments._0, self.bounds = rows.start, self.of.bounds(dim(len(rows)))

    def let_go(self) -> None:
        """Hold no inputs, but know them again. What `renew` has set since is known already."""
        self._known = self._known or [_known(value) for value in self.inputs]
        self.inputs = ()

    def renew(self, inputs: Sequence[Any]) -> None:
        """Give one that has let go other inputs of the same kinds, or the first of them, where they are others.

        Raises TypeError as `host_launch` does; then it is of no use any more.
        """
        of, known, arguments = self.of, self._known, self.arguments
        for k, value in enumerate(inputs):
            last = known[k]
            if last is None or last() is not value:
                setattr(arguments, of.names[k], of.formed(k, value))
                known[k] = _known(value)
        self.inputs = inputs

    def with_last(self, inputs: Sequence[Any]) -> "HostLaunch":
        """Another one with other inputs in the place of the last ones. It holds only these."""
        other = copy(self)
        other.arguments, other.inputs = type(self.arguments).from_buffer_copy(self.arguments), inputs
        for k, array in enumerate(inputs, len(self.inputs) - len(inputs)):
            setattr(other.arguments, self.of.names[k], self.of.formed(k, array))
        return other

    def take_over(self, other: "HostLaunch", count: int) -> None:
        """Have the first arguments of another launch of the same kernel, so many."""
        fields, names = type(self.arguments), self.of.names
        end = getattr(fields, names[count]).offset if count < len(names) else ctypes.sizeof(fields)
        ctypes.memmove(ctypes.byref(self.arguments), ctypes.byref(other.arguments), end)


def _known(value: Any) -> Any:
    """What tells whether an input is this array, which it does not hold; None for others, whose values may change."""
    return ref(value) if isinstance(value, np.ndarray | wp.array) else None


class Loaded:
    """A kernel, and what all its launches share."""

    def __init__(self, kernel: wp.Kernel, dim: Dim, inputs: Sequence[Any]) -> None:
        start_warp()
        command = wp.launch(kernel, dim=dim, inputs=list(inputs), device="cpu", record_cmd=True)
        self.kernel, self.function = kernel, command.hooks.forward
        self.address: Any = ctypes.cast(self.function, ctypes.c_void_p).value
        self._kinds = [_kind(*each) for each in zip(kernel.adj.args, inputs, strict=True)]
        self._forms = [type(value) for value in command.params[1:]]
        self.names = [f"_{k}" for k in range(len(self._forms))]
        fields = list(zip(self.names, self._forms, strict=True))
        self._structure: Any = type("Arguments", (ctypes.Structure,), {"_fields_": fields})
        # The arrays of the first launch are not held.
        command.params, command.fwd_args = command.params[:1], None
        self._command, self._bounds = command, dict[Dim, Any]()

    def bounds(self, dim: Dim) -> Any:
        """How many threads a launch has; kernels only read it, and it is kept: where it is in memory may be noted."""
        if dim not in self._bounds:
            with MAKING:
                if dim not in self._bounds:
                    self._command.set_dim(dim)
                    self._bounds[dim] = self._command.bounds
        return self._bounds[dim]

    def arguments(self, inputs: Sequence[Any]) -> Any:
        """Inputs as the kernel takes them."""
        return self._structure(*[_formed(*each) for each in zip(inputs, self._kinds, self._forms, strict=True)])

    def formed(self, k: int, value: Any) -> Any:
        """An input as the kernel takes it."""
        return _formed(value, self._kinds[k], self._forms[k])


_LOADED: dict[wp.Kernel, Loaded] = {}


class Kind(NamedTuple):
    """Of an array, Warp's type and dimensions, and NumPy's numbers (None for structures) and its further axes."""

    dtype: Any
    ndim: int
    number: Any
    inner: tuple[int, ...]


def _kind(argument: Any, first: Any) -> Kind | None:
    """What a kernel takes for an argument; None if it is no array. first: its value in the first launch."""
    declared: Any = argument.type
    if not isinstance(declared, wp.array):
        return None
    dtype = first.dtype if declared.dtype is Any else declared.dtype
    return Kind(dtype, declared.ndim, *as_numbers(dtype))


@cache
def as_numbers(dtype: Any) -> tuple[Any, tuple[int, ...]]:
    """NumPy's numbers of Warp's type, None for a structure, and the axes more that vectors and matrices have."""
    to_numpy: Any = wp.dtype_to_numpy
    try:
        return np.dtype(to_numpy(getattr(dtype, "_wp_scalar_type_", dtype))), tuple(getattr(dtype, "_shape_", ()))
    except TypeError:
        return None, ()


def _formed(value: Any, kind: Kind | None, form: Any) -> Any:
    """A value as a field of some form takes it. Raises TypeError for an array of another kind than the field's."""
    array: Any = value
    if kind is None:
        if isinstance(value, NUMBERS):
            return value
        if isinstance(value, np.generic):
            return value.item()
        return array.__ctype__() if hasattr(value, "__ctype__") else value
    if isinstance(value, np.ndarray):
        shape, inner = value.shape[: kind.ndim], value.shape[kind.ndim :]
        # NumPy says that None is float64.
        alike = kind.number is not None and value.dtype == kind.number
        if alike and len(shape) == kind.ndim and inner == kind.inner and value.flags.c_contiguous:
            return form(data=value.ctypes.data, ndim=kind.ndim, shape=shape, strides=value.strides[: kind.ndim])
    elif isinstance(value, wp.array) and value.dtype == kind.dtype and value.ndim == kind.ndim:
        return array.__ctype__()
    numbers = "" if kind.number is None else f", or {kind.number} with axes {kind.inner} more"
    raise TypeError(
        f"{value!r}: the kernel takes {kind.dtype.__name__} of {kind.ndim} dimensions{numbers}, in one piece"
    )
