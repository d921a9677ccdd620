"""Arrays of points, from whatever holds one."""

from __future__ import annotations

from typing import TYPE_CHECKING, Any

if TYPE_CHECKING:
    from numpy.typing import NDArray


def as_points(name: str, values: Any, width: int = 3) -> NDArray[Any]:
    """Returns an (N, width) array of float32 or float64 in C order.

    Arrays of these types in this order are taken as they are. Others are copied, and so are lists. What offers DLPack, as
    tensors of PyTorch and JAX do, is read where it is. Points that are NaN have distances that are NaN.
    """
    import numpy as np

    if not isinstance(values, np.ndarray) and hasattr(values, "__dlpack__"):
        values = np.from_dlpack(values)
    array = np.asarray(values)
    if array.dtype.kind not in "fiub":
        raise TypeError(f"{name}: expected numbers, not an array of {array.dtype}")
    if array.dtype not in (np.float32, np.float64):
        array = array.astype(np.float32 if array.dtype == np.float16 else np.float64)
    if array.ndim == 1 and array.size == 0:
        array = array.reshape(0, width)
    if array.ndim != 2 or array.shape[1] != width:
        raise ValueError(f"{name}: expected shape (N, {width}), not {array.shape}")
    if not array.dtype.isnative:
        array = array.astype(array.dtype.newbyteorder("="))
    return np.require(array, requirements=["C", "A"])
