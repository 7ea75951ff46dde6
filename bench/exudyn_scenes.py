"""The scenes in Exudyn (https://github.com/jgerstmayr/EXUDYN), served to bench/run.

It runs with the Python of the environment where Exudyn is installed. Each line of the standard input is a setting in JSON,
{"scene": "S1", "elements": 8, "steps": 3352, ...}; each answer is a line too: wall and CPU seconds of the solver, CPU seconds of
building the model, times and columns; or {"failure": message}. Sensors keep their values in memory; no file is written.
"""
import json
import math
import os
import re
import sys
import time

# The answers keep the standard output for themselves; what Exudyn prints, already when it is imported, goes to the standard error
answers = os.fdopen(os.dup(1), "w", buffering=1)
os.dup2(2, 1)
sys.exudynFast = True  # the module without range checks

import exudyn as exu
import numpy as np
from exudyn.advancedUtilities import CreateSymbolicUserFunction
from exudyn.itemInterface import (
    CoordinateConstraint, GenericJoint, LoadMassProportional, LoadTorqueVector, MarkerBodyMass, MarkerBodyPosition,
    MarkerBodyRigid, MarkerNodeCoordinate, MarkerNodePosition, NodePoint2DSlope1, NodePointGround, NodeRigidBody2D,
    ObjectANCFCable2D, ObjectGenericODE2, ObjectGround, ObjectJointRevolute2D, ObjectRigidBody2D, SensorBody, SensorNode,
    SpringDamper)

POSITION = exu.OutputVariableType.Position
COORDINATES = exu.OutputVariableType.Coordinates


class Scene:
    """A system with the helpers that the scenes share; a subclass builds it, and turns what the sensors kept into columns."""

    end = 0.0
    samples = 0

    def __init__(self, setting):
        self.container = exu.SystemContainer()
        self.mbs = self.container.AddSystem()
        self.ground = self.mbs.AddObject(ObjectGround())
        self.ground_node = self.mbs.AddNode(NodePointGround())
        self.sensors = []
        self.build(setting)
        self.mbs.Assemble()

    def hold(self, node, coordinate, velocity=None):
        """A coordinate of a node stays, or moves at a given velocity."""
        markers = [self.mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=self.ground_node, coordinate=0)),
                   self.mbs.AddMarker(MarkerNodeCoordinate(nodeNumber=node, coordinate=coordinate))]
        return self.mbs.AddObject(CoordinateConstraint(
            markerNumbers=markers, offset=velocity or 0.0, velocityLevel=velocity is not None))

    def beam(self, elements, length, axial, bending, mass, start=0.0, rigid_velocity=None):
        """A straight ANCF beam along x: rigidities, mass per length; velocities (vy at the start, spin). Nodes and elements."""
        step = length/elements
        speed, spin = rigid_velocity or (0.0, 0.0)
        nodes = [self.mbs.AddNode(NodePoint2DSlope1(
            referenceCoordinates=[start + i*step, 0, 1, 0], initialVelocities=[0, speed + spin*i*step, 0, spin]))
            for i in range(elements + 1)]
        bodies = [self.mbs.AddObject(ObjectANCFCable2D(
            length=step, massPerLength=mass, bendingStiffness=bending, axialStiffness=axial, nodeNumbers=nodes[i:i + 2]))
            for i in range(elements)]
        return nodes, bodies

    def rigid(self, centre, angle, mass, inertia, velocity=(0, 0, 0)):
        """A rigid body; its node and object."""
        node = self.mbs.AddNode(NodeRigidBody2D(
            referenceCoordinates=[centre[0], centre[1], angle], initialVelocities=list(velocity)))
        return node, self.mbs.AddObject(ObjectRigidBody2D(mass=mass, inertia=inertia, nodeNumber=node))

    def point(self, body, place):
        """A marker at a place of a body, from its centre of mass."""
        return self.mbs.AddMarker(MarkerBodyPosition(bodyNumber=body, localPosition=[place[0], place[1], 0]))

    def revolute(self, first, second):
        self.mbs.AddObject(ObjectJointRevolute2D(markerNumbers=[first, second]))

    def weigh(self, bodies):
        for body in bodies:
            marker = self.mbs.AddMarker(MarkerBodyMass(bodyNumber=body))
            self.mbs.AddLoad(LoadMassProportional(markerNumber=marker, loadVector=[0, -9.81, 0]))

    def watch_node(self, node, quantity=POSITION):
        self.sensors.append(self.mbs.AddSensor(SensorNode(
            nodeNumber=node, storeInternal=True, writeToFile=False, outputVariableType=quantity)))

    def kept(self):
        """Tables of the sensors: time, then the components."""
        return [self.mbs.GetSensorStoredData(sensor) for sensor in self.sensors]


class SliderCrank(Scene):
    """S1: the rod of 6 mm (or another diameter) of Han and Lee 1993 as an ANCF beam; the crank turns at a given speed."""

    end = 4*math.pi/150
    samples = 838
    length = 0.30

    def __init__(self, setting):
        self.end = setting.get("end", self.end)
        self.samples = setting.get("samples", self.samples)
        super().__init__(setting)

    def build(self, setting):
        crank, speed, diameter = 0.15, 150.0, setting.get("diameter", 6e-3)
        area = math.pi*diameter**2/4
        nodes, _ = self.beam(setting["elements"], self.length, 2e11*area, 2e11*math.pi*diameter**4/64, 7870*area, crank,
                             (crank*speed, -crank*speed/self.length))
        node, body = self.rigid((0, 0), 0.0, 0.1, 1e-3, (0, 0, speed))
        self.hold(node, 0)
        self.hold(node, 1)
        self.hold(node, 2, velocity=speed)
        self.revolute(self.point(body, (crank, 0)), self.mbs.AddMarker(MarkerNodePosition(nodeNumber=nodes[0])))
        self.hold(nodes[-1], 1)
        slider = np.zeros((4, 4))
        slider[0, 0] = slider[1, 1] = 0.033375
        self.mbs.AddObject(ObjectGenericODE2(nodeNumbers=[nodes[-1]], massMatrix=slider))
        for node in (nodes[0], nodes[len(nodes)//2], nodes[-1]):
            self.watch_node(node)

    def columns(self):
        start, middle, end = self.kept()
        chord, arm = end[:, 1:3] - start[:, 1:3], middle[:, 1:3] - start[:, 1:3]
        across = chord[:, 0]*arm[:, 1] - chord[:, 1]*arm[:, 0]
        return start[:, 0], {"deflection_over_length": across/np.hypot(chord[:, 0], chord[:, 1])/self.length}


def hub_angle(t):
    """Angle of the hub of S2."""
    speed, ramp = 6.0, 15.0
    if t >= ramp:
        return speed*(t - ramp/2)
    return speed/ramp*(t*t/2 + (ramp/(2*math.pi))**2*(math.cos(2*math.pi*t/ramp) - 1))


class SpinUp(Scene):
    """S2: the cantilever of Simo and Vu-Quoc 1986 on a hub whose angle is given."""

    end = 20.0
    samples = 1000
    length = 10.0

    def build(self, setting):
        nodes, bodies = self.beam(setting["elements"], self.length, 2.8e7, 1.4e4, 1.2)
        self.hold(nodes[0], 0)
        self.hold(nodes[0], 1)
        node, body = self.rigid((0, 0), 0.0, 1.0, 1.0)
        self.hold(node, 0)
        self.hold(node, 1)
        ends = [self.mbs.AddMarker(MarkerBodyRigid(bodyNumber=b, localPosition=[0, 0, 0])) for b in (body, bodies[0])]
        self.mbs.AddObject(GenericJoint(markerNumbers=ends, constrainedAxes=[0, 0, 0, 0, 0, 1]))
        driver = self.hold(node, 2)
        self.mbs.SetObjectParameter(driver, "offsetUserFunction", self.driver_function(setting, driver))
        self.watch_node(nodes[-1])

    def driver_function(self, setting, driver):
        """The angle as an expression, which Exudyn evaluates without calling Python; or as a function of Python."""
        ramp, speed = 15.0, 6.0

        def expression(mbs, t, itemNumber, lOffset):
            growing = speed/ramp*(0.5*t*t + (ramp/(2*math.pi))**2*(exu.symbolic.cos(2*math.pi/ramp*t) - 1.0))
            return exu.symbolic.IfThenElse(t < ramp, growing, speed*(t - 0.5*ramp))

        def angle(mbs, t, itemNumber, lOffset):
            return hub_angle(t)

        if setting["driver"] == "Python":
            return angle
        self.expression = CreateSymbolicUserFunction(self.mbs, expression, "offsetUserFunction", driver)  # must live as long as self
        return self.expression

    def columns(self):
        tip = self.kept()[0]
        angle = np.array([hub_angle(t) for t in tip[:, 0]])
        return tip[:, 0], {"u2_tip": -np.sin(angle)*tip[:, 1] + np.cos(angle)*tip[:, 2]}


def turned(angle, place):
    """A place in the frame of a body, in space."""
    return np.array([math.cos(angle)*place[0] - math.sin(angle)*place[1], math.sin(angle)*place[0] + math.cos(angle)*place[1]])


class Squeezer(Scene):
    """S3: Andrews' squeezing mechanism of the Test Set for IVP Solvers, as seven bodies and ten joints."""

    end = 0.03
    samples = 300

    def build(self, setting):
        beta, theta, gamma = -0.0617138900142764, 0.0, 0.455279819163070
        phi, delta, omega, epsilon = 0.222668390165886, 0.487364979543843, -0.222668390165886, 1.23054744454982
        a, b, c = np.array([-0.06934, -0.00227]), np.array([-0.03635, 0.03273]), np.array([0.014, 0.072])
        o = np.zeros(2)
        rr, zt, u = 0.007, 0.04, 0.04
        self.starts = [beta, beta + theta, gamma, phi + delta, delta, omega + epsilon, epsilon]
        # Place of the pivot, centre of mass from the pivot, mass, inertia
        data = [(o, (0.00092, 0), 0.04325, 2.194e-6),
                (turned(beta, (rr, 0)), (-0.0115, 0), 0.00365, 4.410e-7),
                (b, (0.01874, 0.01043), 0.02373, 5.255e-6),
                (a + turned(delta, (zt, 0)), (0, -(0.02 - 0.01421)), 0.00706, 5.667e-7),
                (a, (0.02308, 0.00916), 0.07050, 1.169e-5),
                (a + turned(epsilon, (0, -u)), (0.02 - 0.01421, 0), 0.00706, 5.667e-7),
                (a, (0.01228, 0.00449), 0.05498, 1.912e-5)]
        self.bodies, self.centres = [], [np.array(d[1]) for d in data]
        for angle, (pivot, centre, mass, inertia) in zip(self.starts, data):
            node, body = self.rigid(pivot + turned(angle, centre), angle, mass, inertia)
            self.bodies.append(body)
            self.watch_node(node, COORDINATES)
        for body, place in ((1, o), (3, b), (5, a), (7, a)):
            self.revolute(self.point(self.ground, place), self.on(body, (0, 0)))
        for first, place, second in ((1, (rr, 0), 2), (5, (zt, 0), 4), (7, (0, -u), 6)):
            self.revolute(self.on(first, place), self.on(second, (0, 0)))
        for body, place in ((3, (0, -0.035)), (4, (0, -0.02)), (6, (0.02, 0))):
            self.revolute(self.on(2, (-0.028, 0)), self.on(body, place))
        self.mbs.AddObject(SpringDamper(markerNumbers=[self.point(self.ground, c), self.on(3, (0.02, -0.018))],
                                        stiffness=4530.0, referenceLength=0.07785))
        motor = self.mbs.AddMarker(MarkerBodyRigid(bodyNumber=self.bodies[0], localPosition=[0, 0, 0]))
        self.mbs.AddLoad(LoadTorqueVector(markerNumber=motor, loadVector=[0, 0, 0.033]))

    def on(self, body, place):
        """A marker at a place from the pivot of body K1 to K7."""
        return self.point(self.bodies[body - 1], np.array(place) - self.centres[body - 1])

    def columns(self):
        tables = self.kept()
        k1, k2, k3, k4, k5, k6, k7 = [start + table[:, 3] for start, table in zip(self.starts, tables)]
        return tables[0][:, 0], {"beta": k1, "theta": k2 - k1, "gamma": k3, "phi": k4 - k5, "delta": k5, "omega": k6 - k7,
                                 "epsilon": k7}


class FourBars(Scene):
    """S4: a chain of 40 four-bars (IFToMM benchmark A02): uprights and couplers of 1 m and 1 kg."""

    end = 10.0
    samples = 500

    def build(self, setting):
        loops, inertia = setting.get("loops", 40), 1/12
        half, other_half = (-0.5, 0), (0.5, 0)
        uprights = [self.rigid((i, 0.5), math.pi/2, 1.0, inertia, (0.5, 0, -1))[1] for i in range(loops + 1)]
        couplers = [self.rigid((i + 0.5, 1.0), 0.0, 1.0, inertia, (1, 0, 0))[1] for i in range(loops)]
        for i, upright in enumerate(uprights):
            self.revolute(self.point(self.ground, (i, 0)), self.point(upright, half))
        for i, coupler in enumerate(couplers):
            self.revolute(self.point(uprights[i], other_half), self.point(coupler, half))
            self.revolute(self.point(uprights[i + 1], other_half), self.point(coupler, other_half))
        self.weigh(uprights + couplers)
        self.sensors.append(self.mbs.AddSensor(SensorBody(
            bodyNumber=uprights[0], localPosition=[0.5, 0, 0], storeInternal=True, writeToFile=False,
            outputVariableType=POSITION)))

    def columns(self):
        table = self.kept()[0]
        return table[:, 0], {"x_b0": table[:, 1], "y_b0": table[:, 2]}


class Chain(Scene):
    """S5: bars of 1 m and 1 kg, pinned one to the next, released along the horizontal; rigid or ANCF beams:
    those of input/chain_rigid.inp and input/chain_flexible.inp."""

    end = 1.0
    samples = 10

    def __init__(self, setting):
        self.end = setting.get("end", self.end)
        super().__init__(setting)

    def build(self, setting):
        bars, elements = setting["bars"], setting.get("elements", 0)
        young, density, width, height = 2.1e11, 7850, 0.02, 0.005
        area = width*height
        last = self.point(self.ground, (0, 0))
        bodies = []
        for i in range(bars):
            if elements:
                nodes, members = self.beam(elements, 1.0, young*area, young*area*height**2/12, density*area, float(i))
                start, end = (self.mbs.AddMarker(MarkerNodePosition(nodeNumber=nodes[k])) for k in (0, -1))
                bodies += members
            else:
                node, body = self.rigid((i + 0.5, 0), 0.0, 1.0, 1/12)
                start, end = self.point(body, (-0.5, 0)), self.point(body, (0.5, 0))
                bodies.append(body)
            self.revolute(last, start)
            last = end
        self.weigh(bodies)
        if elements:
            self.watch_node(nodes[-1])
        else:
            self.sensors.append(self.mbs.AddSensor(SensorBody(bodyNumber=body, localPosition=[0.5, 0, 0], storeInternal=True,
                                                              writeToFile=False, outputVariableType=POSITION)))

    def columns(self):
        table = self.kept()[0]
        return table[:, 0], {"x_end": table[:, 1], "y_end": table[:, 2]}


class SoftPendulum(Scene):
    """S6: a very soft rod, pinned, let go from the horizontal."""

    end = 1.1
    samples = 220

    def build(self, setting):
        nodes, bodies = self.beam(setting["elements"], 1.2, 1260.0, 8.505e-3, 9.972)
        self.hold(nodes[0], 0)
        self.hold(nodes[0], 1)
        self.weigh(bodies)
        for node in (nodes[len(nodes)//2], nodes[-1]):
            self.watch_node(node)

    def columns(self):
        middle, tip = self.kept()
        return tip[:, 0], {"x_tip": tip[:, 1], "y_tip": tip[:, 2], "x_middle": middle[:, 1], "y_middle": middle[:, 2]}


SCENES = {"S1": SliderCrank, "S2": SpinUp, "S3": Squeezer, "S4": FourBars, "S5": Chain, "S6": SoftPendulum}


def simulation_settings(scene, setting):
    settings = exu.SimulationSettings()
    motion = settings.timeIntegration
    motion.endTime = scene.end
    motion.numberOfSteps = setting["steps"]
    motion.verboseMode = 0
    motion.adaptiveStep = False
    motion.generalizedAlpha.useIndex2Constraints = setting.get("index", 3) == 2
    motion.generalizedAlpha.useNewmark = setting.get("newmark", False)
    motion.newton.modifiedNewtonJacUpdatePerStep = setting.get("newton") == "each step"
    motion.generalizedAlpha.spectralRadius = setting.get("rho", 1.0)
    motion.newton.useModifiedNewton = setting.get("newton", "modified") != "full"
    motion.newton.relativeTolerance = setting.get("tolerance", 1e-8)
    motion.newton.absoluteTolerance = setting.get("absolute", 1e-10)
    settings.linearSolver.solverType = exu.LinearSolverType.EigenSparse if setting.get("matrices") == "sparse" \
        else exu.LinearSolverType.EXUdense
    settings.linearSolver.reuseAnalyzedPattern = True
    settings.solution.file.write = False
    settings.solution.sensors.writePeriod = scene.end/scene.samples
    settings.parallel.numberOfThreads = 1
    return settings


def run(setting):
    """One run, timed around the solver alone."""
    before = time.process_time()
    scene = SCENES[setting["scene"]](setting)
    settings = simulation_settings(scene, setting)
    before = time.process_time() - before
    method = exu.DynamicSolverType.TrapezoidalIndex2 if setting.get("method") == "trapezoidal" \
        else exu.DynamicSolverType.GeneralizedAlpha
    wall, cpu = time.perf_counter(), time.process_time()
    done = scene.mbs.SolveDynamic(settings, solverType=method)
    wall, cpu = time.perf_counter() - wall, time.process_time() - cpu
    if not done:
        return {"failure": "the solver gave up"}
    times, columns = scene.columns()
    return {"wall": wall, "cpu": cpu, "before": before, "times": times.tolist(), "columns": {name: c.tolist() for name, c in columns.items()}}


def main():
    for line in sys.stdin:
        try:
            answer = run(json.loads(line))
        except Exception as error:
            message = re.sub(r"\s*\[Python file[^\]]*\]", "", str(error)).strip()
            answer = {"failure": (message.splitlines() or [repr(error)])[0]}
        answers.write(json.dumps(answer) + "\n")


if __name__ == "__main__":
    main()
