"""Samples of a run: an xarray Dataset where xarray is there, else an object with the same access by name."""

import numpy

try:
    import xarray
except ImportError:
    xarray = None


class Channel(numpy.ndarray):
    """Numbers with a unit: `units`, and `long_name`, one line that says what they are. `values` is the plain array."""

    units = ""
    long_name = ""

    def __new__(cls, values, units="", long_name=""):
        self = numpy.asarray(values, dtype=float).view(cls)
        self.units = units
        self.long_name = long_name
        return self

    def __array_finalize__(self, other):
        self.units = getattr(other, "units", "")
        self.long_name = getattr(other, "long_name", "")

    @property
    def values(self):
        return self.view(numpy.ndarray)

    @property
    def attrs(self):
        return {"units": self.units, "long_name": self.long_name}


class Results:
    """Samples without xarray: results["x"] is a `Channel`, results.time the times; attrs as of a Dataset."""

    def __init__(self, time, channels, attrs):
        self.time = time
        self.channels = channels
        self.attrs = attrs

    def __getitem__(self, name):
        return self.time if name == "time" else self.channels[name]

    def __contains__(self, name):
        return name == "time" or name in self.channels

    def __iter__(self):
        return iter(self.channels)

    def __len__(self):
        return len(self.channels)

    def keys(self):
        return self.channels.keys()

    def __repr__(self):
        first, last = (self.time[0], self.time[-1]) if len(self.time) else (0, 0)
        lines = [f"<limber.Results> {len(self.time)} samples, time {first:g} to {last:g} {self.time.units}"]
        width = max((len(name) for name in self.channels), default=0)
        for name, channel in self.channels.items():
            shown = f"{channel.min():.6g} to {channel.max():.6g}" if channel.ndim and len(channel) else f"{channel}"
            lines.append(f"    {name:<{width}}  {shown} {channel.units}")
        return "\n".join(lines)


def make_results(time, channels, attrs):
    """Results of Channels: time, and a dictionary of what depends on it, or (of no dimension) is a scalar of the run."""
    if xarray is None:
        return Results(time, channels, attrs)
    variables = {
        name: (("time",) if channel.ndim else (), channel.values, channel.attrs) for name, channel in channels.items()}
    return xarray.Dataset(variables, {"time": ("time", time.values, time.attrs)}, attrs)


def read(path):
    """Samples of a results file that `limber run` has written, as `limber.run` gives them; needs h5py."""
    import h5py

    def channel(dataset):
        return Channel(dataset[()], text(dataset.attrs.get("units", "")), text(dataset.attrs.get("long_name", "")))

    def text(value):
        return value.decode() if isinstance(value, bytes) else str(value)

    with h5py.File(path) as file:
        if text(file.attrs.get("format", "")) != "limber-history":
            raise ValueError(f"{path}: not a results file of limber")
        channels = {name: channel(dataset) for name, dataset in file["channels"].items()}
        attrs = {"source": str(path), "limber_version": text(file.attrs["limber_version"]),
                 "complete": int(file["run"].attrs["complete"])}
        return make_results(channel(file["time"]), channels, attrs)
