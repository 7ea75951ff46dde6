"""The Python package: check_python.py ROOT LIMBER WORK, with the package on PYTHONPATH. 77: there is no numpy."""

import pathlib
import subprocess
import sys
import warnings

try:
    import numpy
except ImportError:
    sys.exit(77)

root, program, work = pathlib.Path(sys.argv[1]), sys.argv[2], pathlib.Path(sys.argv[3])
decks = root / "input"


def check(right, what):
    if not right:
        raise AssertionError(what)


def raises(kind, part, call):
    try:
        call()
    except kind as error:
        check(part in str(error), f"'{part}' is not in: {error}")
        return error
    raise AssertionError(f"no error: {part}")


def check_package():
    import limber

    # A run, its names and units
    results = limber.run(decks / "pendulum.inp")
    check(len(results["time"]) == 201 and float(results["time"][-1]) == 10.0, "times")
    check(results["x"].attrs["units"] == "m" and results["pull_x"].attrs["units"] == "N", "units of channels")
    check(results["time"].attrs["units"] == "s", "unit of time")
    check("pull_y" in str(results), "what is printed names the channels")
    check(results.attrs["complete"] == 1 and results.attrs["limber_version"] == limber.__version__, "attributes")

    # Parameters, scalars and warnings
    with warnings.catch_warnings(record=True) as caught:
        warnings.simplefilter("always")
        slow, fast = limber.run(decks / "sweep_speed.inp", speed=150), limber.run(decks / "sweep_speed.inp", {"speed": 200})
    check(any("warning" in str(one.message) for one in caught), "warnings of a run")
    check(float(fast["time"][-1]) == float(slow["time"][-1]) * 150 / 200 or float(fast["time"][-1]) < float(slow["time"][-1]),
          "a parameter counts")
    check(slow["largest"].ndim == 0 and float(slow["largest"]) == numpy.max(numpy.asarray(slow["deflection"])), "a scalar")

    # Errors
    error = raises(limber.Error, "no_such.inp", lambda: limber.run("no_such.inp"))
    check(error.status == 2 and error.results is None, "status of a deck that is not there")
    raises(limber.Error, "wrong:1:24", lambda: limber.open_text("*POINT MASS, NAME=bob, MAS=1\n*DYNAMICS, END=1\n", "wrong"))
    raises(limber.Error, "has no parameter 'length'", lambda: limber.run(decks / "pendulum.inp", length=2))
    text = (decks / "pendulum.inp").read_text().replace("END=10", "END=10, MAXIMUM STEPS=60")
    deck = work / "short.inp"
    deck.write_text(text)
    error = raises(limber.Error, "MAXIMUM STEPS=60 are used up", lambda: limber.run(deck))
    check(error.status == 3 and 1 < len(error.results["time"]) < 201, "what was computed before stays")

    # Steps: the bits of the whole run; a state; several runs at once
    whole = numpy.asarray(results["x"])
    with limber.open(decks / "pendulum.inp") as run, limber.open(decks / "pendulum.inp") as other:
        check(run.time == 0.0 and run.end == 10.0 and not run.is_complete and run["x"] == 1.0, "the start")
        run.advance(0.123)
        place = run.save()
        check(run.time == 0.123 and abs(run["x"] ** 2 + run["y"] ** 2 - 1) < 1e-12, "a time within a step")
        q, v = run.state()
        check(run.coordinates[:2] == ["bob.x", "bob.y"] and q[0] == run["x"] and v[1] < 0, "coordinates")
        run.advance(5.0)
        check(run["x"] == whole[100] and len(run.samples()["time"]) == 101, "a time of a sample")
        run.finish()
        check(run.is_complete and numpy.array_equal(run.samples()["x"], whole), "bits in pieces")
        other.restore(place).finish()
        check(numpy.array_equal(other.samples()["x"], whole[3:]), "bits from a state in another run")
        check(run.units["y"] == "m" and run.meanings["y"], "units and meanings")
    raises(ValueError, "closed", lambda: run.time)
    raises(ValueError, "closed", lambda: run.inputs.__setitem__("u", 1.0))

    # A controller
    deck = root / "examples" / "library" / "controlled_arm.inp"
    with limber.open(deck) as run:
        check(list(run.inputs) == ["u"] and run.inputs["u"] is None, "inputs")
        run.inputs["u"] = 5.0
        run.finish()
        check(run.inputs["u"] == 5.0 and run["output_u"] == 5.0, "an input")
        raises(limber.Error, "no *CONTROL, TYPE=INPUT with the name 'w'", lambda: run.inputs.__setitem__("w", 1.0))

    # A results file
    path = work / "pendulum_python.h5"
    subprocess.run([program, "run", decks / "pendulum.inp", "-o", path, "--force", "--quiet"], check=True)
    try:
        import h5py  # noqa: F401
    except ImportError:
        return results
    file = limber.read(path)
    check(numpy.array_equal(file["x"], whole) and file["x"].attrs == results["x"].attrs, "a results file")
    return results


def forget_package():
    for name in [name for name in sys.modules if name.split(".")[0] == "limber"]:
        del sys.modules[name]


try:
    import xarray
except ImportError:
    xarray = None
if xarray is not None:
    check(isinstance(check_package(), xarray.Dataset), "a Dataset where xarray is there")
    forget_package()
sys.modules["xarray"] = None
small = check_package()
check(small["x"].units == "m" and list(small)[0] == "x" and small.time.units == "s", "access without xarray")
check(small["x"].values.max() == 1.0 and "time" in small and len(small) == 4, "numbers without xarray")

example = root / "examples" / "library" / "controlled_arm.py"
output = subprocess.run([sys.executable, "-B", example], check=True, capture_output=True, text=True).stdout
last = float(output.strip().rsplit("\n", 1)[-1].split(":")[1].split("rad")[0])
check(abs(last - 0.7854) < 0.01, output)
