"""A deck that is open, and its motion so far."""

import collections.abc
import ctypes
import os
import warnings

import numpy

from ._library import CHANNELS, COORDINATES, INPUTS, SCALARS, Error, library
from ._results import Channel, make_results


def open(deck, settings=None, **parameters):
    """Opens a deck, a file. Values of parameters in place of those of the deck: speed=150, or settings={"speed": 150}."""
    return Run(library.limber_open(os.fsencode(deck), _settings(settings, parameters)), str(deck))


def open_text(text, name="deck", settings=None, **parameters):
    """Opens a deck that is a text. `name` is for messages; files that it names are relative to the folder of that name."""
    return Run(library.limber_open_text(text.encode(), os.fsencode(name), _settings(settings, parameters)), str(name))


def run(deck, settings=None, **parameters):
    """Runs a deck, a file, to its end. Gives its samples, as `Run.samples`; what limber warns of are Python's warnings."""
    with open(deck, settings, **parameters) as own:
        try:
            own.finish()
        except Error as error:
            error.results = own.samples()
            raise
        if own.warnings:
            warnings.warn(own.warnings.rstrip(), stacklevel=2)
        return own.samples()


def _settings(settings, parameters):
    """Lines name=value."""
    return "\n".join(f"{name}={float(value)!r}" for name, value in {**(settings or {}), **parameters}.items()).encode()


class Inputs(collections.abc.Mapping):
    """Controls of TYPE=INPUT of a run: inputs["u"] = 3.0 counts from the next sample of the control on."""

    def __init__(self, run):
        self._run = run
        self._values = dict.fromkeys(run._names(INPUTS))

    def __getitem__(self, name):
        """The value that was set; None: none was, and the line of the deck counts."""
        return self._values[name]

    def __setitem__(self, name, value):
        self._run._check(library.limber_set_input(self._run._open(), name.encode(), float(value)))
        self._values[name] = float(value)

    def __iter__(self):
        return iter(self._values)

    def __len__(self):
        return len(self._values)


class Run:
    """A deck that is open, and its motion so far; made by `limber.open`. Closed by `close`, or behind a `with`."""

    def __init__(self, handle, name):
        self.name = name
        self._handle = handle
        if library.limber_status(handle):
            error = Error(self._error(), library.limber_status(handle))
            self.close()
            raise error
        #: Names of the channels of the deck, of its scalars, and of the coordinates of its bodies
        self.channels = self._names(CHANNELS)
        self.scalars = self._names(SCALARS)
        self.coordinates = self._names(COORDINATES)
        self.inputs = Inputs(self)
        #: Units and meanings of the channels, by name
        self.units = dict(zip(self.channels, self._texts(library.limber_unit, CHANNELS)))
        self.meanings = dict(zip(self.channels, self._texts(library.limber_meaning, CHANNELS)))
        self.time_unit = library.limber_time_unit(handle).decode()

    def advance(self, time):
        """Goes on to a time, or to the end of the run if that comes first."""
        self._check(library.limber_advance(self._open(), time))
        return self

    def finish(self):
        """Goes on to the end."""
        self._check(library.limber_finish(self._open()))
        return self

    @property
    def time(self):
        """Time that the run has come to."""
        return library.limber_time(self._open())

    @property
    def end(self):
        """Its last time."""
        return library.limber_end_time(self._open())

    @property
    def is_complete(self):
        return bool(library.limber_is_complete(self._open()))

    @property
    def warnings(self):
        """Warnings of the deck, and of the motion once it is complete; empty if there are none."""
        return library.limber_warnings(self._open()).decode()

    def values(self):
        """All channels at the time of the run, by name."""
        room = numpy.zeros(len(self.channels))
        self._check(library.limber_values(self._open(), room.ctypes.data))
        return dict(zip(self.channels, room.tolist()))

    def __getitem__(self, channel):
        """A channel at the time of the run."""
        return self.values()[channel]

    def state(self):
        """Coordinates and their rates at the time of the run, by the names of `coordinates`."""
        q, v = numpy.zeros(len(self.coordinates)), numpy.zeros(len(self.coordinates))
        library.limber_state(self._open(), q.ctypes.data, v.ctypes.data)
        return q, v

    def samples(self):
        """The samples of the deck up to the time of the run, each channel with its unit; of a complete run its scalars too.

        An xarray Dataset if xarray is there, else `limber.Results`.
        """
        handle = self._open()
        count, width = library.limber_sample_count(handle), len(self.channels)
        times, values = numpy.zeros(count), numpy.zeros((count, width))
        library.limber_samples(handle, times.ctypes.data, values.ctypes.data)
        channels = {name: Channel(values[:, i].copy(), self.units[name], self.meanings[name])
                    for i, name in enumerate(self.channels)}
        if self.is_complete and self.scalars:
            room = numpy.zeros(len(self.scalars))
            library.limber_scalars(handle, room.ctypes.data)
            units = self._texts(library.limber_unit, SCALARS)
            for name, value, unit in zip(self.scalars, room, units):
                channels.setdefault(name, Channel(value, unit, "scalar of the run"))
        attrs = {"source": self.name, "limber_version": library.limber_version().decode(), "warnings": self.warnings,
                 "complete": int(self.is_complete)}
        return make_results(Channel(times, self.time_unit, "time"), channels, attrs)

    def save(self):
        """The state, to go back to by `restore`: bytes."""
        size = library.limber_save(self._open(), None, 0)
        if not size:
            raise Error(self._error(), library.limber_status(self._handle))
        room = ctypes.create_string_buffer(size)
        library.limber_save(self._handle, room, size)
        return room.raw

    def restore(self, state):
        """Goes to a saved state, of this run or of another one of the same deck with the same parameters."""
        self._check(library.limber_restore(self._open(), state, len(state)))
        return self

    def close(self):
        """Frees all that belongs to the run; it cannot be used any more."""
        library.limber_close(self._handle)
        self._handle = None

    def __enter__(self):
        return self

    def __exit__(self, *_):
        self.close()

    def __del__(self):
        if getattr(self, "_handle", None):
            self.close()

    def __repr__(self):
        if not self._handle:
            return f"<limber.Run {self.name}: closed>"
        return f"<limber.Run {self.name}: {len(self.channels)} channels, time {self.time:g} of {self.end:g} {self.time_unit}>"

    def _open(self):
        if not self._handle:
            raise ValueError(f"{self.name}: the run is closed")
        return self._handle

    def _check(self, status):
        if status:
            raise Error(self._error(), status)

    def _error(self):
        return library.limber_error(self._handle).decode(errors="replace")

    def _names(self, list_of):
        return self._texts(library.limber_name, list_of)

    def _texts(self, function, list_of):
        return [function(self._handle, list_of, i).decode() for i in range(library.limber_count(self._handle, list_of))]
