"""limber: dynamics of planar flexible multibody systems.

    import limber
    results = limber.run("pendulum.inp")            # the whole run; an xarray Dataset if xarray is there
    results["x"]                                    # a channel, with its unit

    with limber.open("arm.inp", reach=0.9) as run:  # step by step
        while not run.is_complete:
            run.inputs["u"] = -20 * run["angle"]
            run.advance(run.time + 0.01)
        results = run.samples()

Values of parameters take the place of those of the deck, as `--set` of the program does. doc/library.md has more.
"""

from ._library import Error, version
from ._results import Channel, Results, read
from ._run import Run, open, open_text, run

__version__ = version()
__all__ = ["Channel", "Error", "Results", "Run", "open", "open_text", "read", "run", "version"]
