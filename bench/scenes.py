"""The scenes: what is compared with what, the settings that are tried, and the decks of limber with a setting in them."""

from dataclasses import dataclass
from pathlib import Path

from limber import with_channels, with_options

ROOT = Path(__file__).resolve().parent.parent
ANGLES = ["beta", "theta", "gamma", "phi", "delta", "omega", "epsilon"]


@dataclass
class Scene:
    name: str
    title: str
    #: file with the solution, from the root of the checkout; channel -> its column; whether errors are not made relative
    reference: str
    columns: dict
    absolute: bool
    targets: list
    #: setting -> deck
    deck: callable
    #: models that limber is tried with: name -> options of *BEAM
    models: dict
    #: tolerances of limber
    tolerances: list
    #: settings of Exudyn
    peer: list
    #: tolerances of the solution by hand
    limit: list

    def limber_settings(self, integrators, quick):
        """Integrators by models by tolerances, coarse ones first. Quick: each second tolerance, the models of the quick list."""
        models = {name: m for name, m in self.models.items() if not quick or m.get("quick")}
        return [{"integrator": integrator, "model": name, "tolerance": tolerance}
                for integrator in integrators for name in models for tolerance in self.tolerances[::3 if quick else 1]]

    def peer_settings(self, quick):
        """The ladder of the peer; quick: what is marked."""
        return [{k: v for k, v in s.items() if k != "quick"} | {"scene": self.name} for s in self.peer
                if not quick or s.get("quick")]


def tolerances(first, last, between=(5, 2)):
    """Tolerances 10^-first to 10^-last, with some multiples of the next one between."""
    values = []
    for exponent in range(first, last):
        values += [f"1e-{exponent}"] + [f"{factor}e-{exponent + 1}" for factor in between]
    return values + [f"1e-{last}"]


#: multiples between the powers of ten where the targets of a scene lie
FINE = (8, 6, 5, 4, 3, 2)


def integration(setting):
    """Options of *DYNAMICS: tolerance and integrator; ALPHA:1 is ALPHA with the spectral radius 1."""
    integrator, _, radius = setting["integrator"].partition(":")
    options = {"TOLERANCE": setting["tolerance"], "INTEGRATOR": integrator}
    return options | {"SPECTRAL RADIUS": radius} if radius else options


def limber_label(setting):
    model = f", {setting['model']}" if setting["model"] else ""
    return f"{setting['integrator']} {setting['tolerance']}{model}"


def peer_label(setting):
    words = []
    if "elements" in setting:
        words.append(f"{setting['elements']} elements")
    words.append(f"{setting['steps']} steps")
    words.append("trapezoidal, index 2" if setting.get("method") == "trapezoidal" else f"generalised alpha {setting['rho']:g}")
    words.append(f"{setting['newton']} Newton {setting['tolerance']:g}")
    if setting.get("absolute"):
        words.append(f"absolute {setting['absolute']:g}")
    words.append(setting["matrices"])
    return ", ".join(words)


def exact(functions, strains, quick=False):
    """An exact beam with so many functions of the angle and of the strain."""
    return f"{functions}+{strains} functions", {"FUNCTIONS": functions, "STRAIN FUNCTIONS": strains, "quick": quick}


def input_deck(name, channels, scene_models):
    """A deck of input/ with the options of a setting, and only the channels that are compared."""
    text = (ROOT/"input"/name).read_text()

    def deck(setting):
        changed = text
        if scene_models:
            options = {k: v for k, v in scene_models[setting["model"]].items() if k != "quick"}
            changed = with_options(changed, "BEAM", options)
        changed = with_options(changed, "DYNAMICS", integration(setting))
        return with_channels(changed, channels)
    return deck


def slider_crank():
    models = dict([exact(1, 0, quick=True), exact(2, 0), exact(3, 0), exact(4, 0), exact(5, 0, quick=True), exact(5, 1), exact(6, 1),
                   exact(7, 1), exact(7, 2), exact(7, 3, quick=True), exact(8, 3), exact(9, 3)])
    peer = [dict(elements=e, steps=838*n, rho=1.0, newton="modified", tolerance=t, matrices=m, quick=q)
            for e, n, t, m, q in [
                (2, 1, 1e-3, "dense", False), (4, 1, 1e-3, "dense", True), (4, 1, 1e-4, "dense", False), (6, 2, 1e-3, "dense", False),
                (4, 3, 1e-3, "dense", False), (6, 3, 1e-3, "dense", True), (6, 3, 1e-4, "dense", False), (8, 3, 1e-3, "dense", False),
                (8, 4, 1e-3, "dense", True), (12, 20, 1e-3, "sparse", False), (12, 30, 1e-3, "sparse", False),
                (12, 40, 1e-3, "sparse", False), (16, 30, 1e-3, "sparse", False), (16, 40, 1e-3, "sparse", True)]]
    return Scene("S1", "slider-crank of Han and Lee, rod of 6 mm: deflection of its middle", "tests/reference/slider_crank_6mm.csv",
                 {"deflection_over_length": "w_mid_over_L"}, False, [1e-2, 1e-3, 1e-4],
                 input_deck("slider_crank_exact.inp", ["deflection_over_length = deflection(rod.middle)/length(rod)"], models),
                 models, ["3e-2", "2e-2"] + tolerances(2, 3, FINE)[:-1] + tolerances(3, 6), peer, [])


def spin_up():
    models = dict([exact(3, 1, quick=True), exact(4, 1), exact(5, 1), exact(6, 1), exact(7, 1, quick=True), exact(7, 2), exact(8, 2)])
    peer = [dict(elements=e, steps=1000*n, rho=rho, newton="full", tolerance=t, absolute=a, matrices="dense", driver="expression",
                 quick=e == 4 and n == 2 and rho == 0.9)
            for e in (3, 4, 5) for n in (1, 2, 3, 4) for rho in (0.6, 0.9) for t, a in ((1e-2, 1e-10), (1e-6, 1e-6))]
    return Scene("S2", "spin-up of a cantilever, Simo and Vu-Quoc: deflection of the tip", "tests/reference/spin_up_beam.csv",
                 {"u2_tip": "u2_tip"}, False, [1e-2, 1e-3, 1e-4],
                 input_deck("spin_up.inp", ["u2_tip = u2(beam.end)"], models), models, tolerances(2, 7), peer, [])


def squeezer():
    peer = [dict(method="trapezoidal", steps=n, newton=newton, tolerance=t, matrices="dense",
                 quick=newton == "modified" and t == 1e-8 and n in (1200, 2400, 12000))
            for n in (300, 600, 1200, 1800, 2400, 4800, 9600, 12000, 18000) for newton in ("modified", "full") for t in (1e-10, 1e-8, 1e-6)]
    peer += [dict(method="trapezoidal", steps=n, newton="modified", tolerance=1e-10, matrices="dense") for n in (24000, 30000)]
    channels = ["beta = angle(k1), theta = angle(k2) - angle(k1), gamma = angle(k3), phi = angle(k4) - angle(k5)",
                "delta = angle(k5), omega = angle(k6) - angle(k7), epsilon = angle(k7)"]
    columns = {name: name.capitalize() if name in ("theta", "phi", "omega") else name for name in ANGLES}
    return Scene("S3", "Andrews' squeezer: the worst of seven angles, absolute", "tests/reference/andrews_squeezer.csv", columns, True,
                 [1e-4, 1e-6], input_deck("andrews_squeezer.inp", channels, {}), {"": {"quick": True}},
                 tolerances(2, 5)[:-1] + tolerances(5, 6, FINE)[:-1] + tolerances(6, 7)[:-1] + tolerances(7, 8, FINE)[:-1]
                 + tolerances(8, 11), peer, tolerances(2, 9))


def four_bars():
    peer = [dict(steps=n, rho=0.9, newton=newton, tolerance=t, matrices="sparse", quick=n == 1500 and newton == "full" and t == 1e-3)
            for n, newton, t in [(1000, "full", 1e-3), (1500, "full", 1e-3), (1500, "modified", 1e-4), (3000, "full", 1e-3),
                                 (4000, "full", 1e-3), (4500, "full", 1e-3), (4500, "modified", 1e-5), (4500, "full", 1e-5),
                                 (10000, "full", 1e-3), (14000, "full", 1e-3), (14000, "modified", 1e-6), (14000, "full", 1e-6)]]
    return Scene("S4", "chain of 40 four-bars, 10 s through folded positions: position of B0", "bench/reference/four_bar_chain_40.csv",
                 {"x_b0": "x_b0", "y_b0": "y_b0"}, False, [1e-2, 1e-3, 1e-4], four_bar_deck, {"": {"quick": True}}, tolerances(2, 9), peer, [])


def four_bar_deck(setting, loops=40):
    """Uprights of 1 m and 1 kg on the ground, couplers between their upper ends; all uprights turn with -1 rad/s."""
    lines = ["*HEADING", f" Chain of {loops} four-bars (IFToMM benchmark A02): every half turn passes a folded position",
             "*GRAVITY", "*GROUND"]
    lines += [f" a{i}, {i}, 0" for i in range(loops + 1)]
    for i in range(loops + 1):
        lines += [f"*RIGID BODY, NAME=upright{i}, MASS=1, INERTIA=1/12, X={i}, Y=0.5, ANGLE=pi/2, VX=0.5, SPIN=-1",
                  " a, -0.5, 0", " b, 0.5, 0"]
    for i in range(loops):
        lines += [f"*RIGID BODY, NAME=coupler{i}, MASS=1, INERTIA=1/12, X={i} + 0.5, Y=1, VX=1", " a, -0.5, 0", " b, 0.5, 0"]
    for i in range(loops + 1):
        lines += [f"*JOINT, NAME=bearing{i}, TYPE=REVOLUTE", f" upright{i}.a, ground.a{i}"]
    for i in range(loops):
        lines += [f"*JOINT, NAME=left{i}, TYPE=REVOLUTE", f" coupler{i}.a, upright{i}.b",
                  f"*JOINT, NAME=right{i}, TYPE=REVOLUTE", f" coupler{i}.b, upright{i + 1}.b"]
    lines += ["*DYNAMICS, END=10, OUTPUTS=500", "*OUTPUT", " x_b0 = x(upright0.b), y_b0 = y(upright0.b)"]
    return with_options("\n".join(lines) + "\n", "DYNAMICS", integration(setting))


SCENES = {scene.name: scene for scene in (slider_crank(), spin_up(), squeezer(), four_bars())}
