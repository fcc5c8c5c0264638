"""The reference implementation computes on one thread with whatever NumPy uses."""


def threads() -> int:
    """How many threads a kernel may use."""
    return 1


def set_threads(threads: int) -> None:
    """Accepted and without effect: NumPy has its own threads."""


def simd() -> str:
    """The vector width that kernels run on."""
    return "numpy"


def set_simd(width: str) -> None:
    """Accepted and without effect: NumPy chooses its own width."""
    if width not in ("scalar", "avx2", "widest"):
        raise ValueError("width must be 'scalar', 'avx2' or 'widest'")
