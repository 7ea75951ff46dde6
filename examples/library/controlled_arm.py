"""A controller in Python lifts an arm: it sees the angle each 10 ms and sets the torque of the motor."""

import math
import pathlib

import limber

deck = pathlib.Path(__file__).with_name("controlled_arm.inp")
wanted, period = math.pi / 4, 0.01

with limber.open(deck, reach=0.9) as run:
    integral = 0.0
    for step in range(round(run.end / period)):
        now = run.values()
        error = wanted - now["angle_arm"]
        if abs(error) < 0.3:
            integral += period * error
        run.inputs["u"] = 60 * error + 100 * integral - 12 * now["spin_arm"]
        run.advance((step + 1) * period)
    results = run.samples()

print(results)
print(f"angle at the end: {float(results['angle_arm'][-1]):.4f} rad, wanted {wanted:.4f}")
