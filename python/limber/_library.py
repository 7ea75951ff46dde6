"""Finds liblimber.so and declares its functions (include/limber.h)."""

import ctypes
import os
import pathlib

CHANNELS, SCALARS, COORDINATES, INPUTS = range(4)


class Error(Exception):
    """An error of limber. A deck with errors: all of them, each with file:line:column.

    status: 2, the deck or the call cannot be used; 3, the run could not go on.
    results: what `limber.run` had computed before; else None.
    """

    def __init__(self, message, status, results=None):
        super().__init__(message)
        self.status = status
        self.results = results


def _load():
    """The library: LIMBER_LIBRARY if that is set; beside this file; above it, as installed; where the system looks."""
    here = pathlib.Path(__file__).resolve().parent
    name = "liblimber.so.0"
    if os.environ.get("LIMBER_LIBRARY"):
        return ctypes.CDLL(os.environ["LIMBER_LIBRARY"])
    for folder in (here, *here.parents[:5]):
        if (folder / name).exists():
            return ctypes.CDLL(str(folder / name))
    try:
        return ctypes.CDLL(name)
    except OSError as error:
        raise ImportError(
            f"{name} is not found beside {here}, above it, or where the system looks ({error}); "
            "set LIMBER_LIBRARY to its path") from error


def _declare(library):
    """Types of arguments and results; without them ctypes takes integers."""
    text, number, run, pointer = ctypes.c_char_p, ctypes.c_double, ctypes.c_void_p, ctypes.c_void_p
    integer, size = ctypes.c_int, ctypes.c_size_t
    functions = {
        "version": (text,),
        "open": (run, text, text),
        "open_text": (run, text, text, text),
        "close": (None, run),
        "status": (integer, run),
        "error": (text, run),
        "warnings": (text, run),
        "advance": (integer, run, number),
        "finish": (integer, run),
        "time": (number, run),
        "end_time": (number, run),
        "time_unit": (text, run),
        "is_complete": (integer, run),
        "count": (integer, run, integer),
        "name": (text, run, integer, integer),
        "unit": (text, run, integer, integer),
        "meaning": (text, run, integer, integer),
        "values": (integer, run, pointer),
        "sample_count": (integer, run),
        "samples": (None, run, pointer, pointer),
        "scalars": (None, run, pointer),
        "state": (None, run, pointer, pointer),
        "set_input": (integer, run, text, number),
        "save": (size, run, pointer, size),
        "restore": (integer, run, pointer, size),
    }
    for name, (result, *arguments) in functions.items():
        function = getattr(library, "limber_" + name)
        function.restype = result
        function.argtypes = arguments
    return library


library = _declare(_load())


def version():
    """Version of limber."""
    return library.limber_version().decode()
