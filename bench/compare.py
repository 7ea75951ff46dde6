"""What the benchmarks measure: errors against a reference, the cheapest setting that reaches a target, tables."""

import csv
import re
import statistics
from dataclasses import dataclass, field


@dataclass
class Run:
    """One run of a program: CPU seconds of its solver, samples; or why there are none."""

    seconds: float = None
    #: seconds before the solver: reading, building
    before: float = None
    #: what the program chose itself
    chosen: str = None
    times: list = None
    columns: dict = None
    failure: str = None
    #: whether it was given up for its time
    slow: bool = False
    #: known already if the program itself compares
    error: float = None


@dataclass
class Entry:
    """A setting of a program in a scene, with all its runs."""

    scene: str
    program: str
    label: str
    setting: dict
    seconds: list = field(default_factory=list)
    before: list = field(default_factory=list)
    error: float = None
    failure: str = None

    @property
    def median(self):
        return statistics.median(self.seconds)

    def add(self, run, reference):
        """Takes a run; its error counts from the first one, as the programs repeat themselves."""
        if run.failure:
            self.failure = self.failure or run.failure
            return
        self.seconds.append(run.seconds)
        if run.before is not None:
            self.before.append(run.before)
        if run.chosen and not self.before[1:]:
            self.label = self.label.replace(" ", f" ({run.chosen}) ", 1)
        if self.error is None:
            self.error = run.error if run.error is not None else reference.error(run)


class Reference:
    """Columns of a file with the solution."""

    def __init__(self, path, columns, absolute):
        """columns: channel -> column of the file; absolute: errors are not divided by the largest value of the reference."""
        with open(path, newline="") as file:
            rows = list(csv.DictReader(file))
        self.times = [float(row["t"]) for row in rows]
        self.columns = {channel: [float(row[column]) for row in rows] for channel, column in columns.items()}
        self.absolute = absolute

    def error(self, run):
        """The largest difference over the samples, of the worst channel."""
        if len(run.times) != len(self.times) or max(abs(a - b) for a, b in zip(run.times, self.times)) > 1e-9:
            raise ValueError("the samples of a run are not those of the reference")
        errors = []
        for channel, exact in self.columns.items():
            scale = 1.0 if self.absolute else max(map(abs, exact))
            differences = [abs(a - b) for a, b in zip(run.columns[channel], exact)]
            errors.append(max(differences)/scale if all(d == d for d in differences) else float("inf"))
        return max(errors)


def candidates(entries, program, target, slack=1.6, most=4):
    """Settings of a program that reach a target and may be the cheapest one, cheapest first."""
    good = sorted((e for e in entries if e.program == program and e.error is not None and e.error <= target and e.seconds),
                  key=lambda e: e.median)
    return [e for e in good if e.median <= slack*good[0].median][:most]


def by_chance(best, entries, target):
    """Whether a finer tolerance, or more steps, of the same setting misses the target that it reaches."""
    def family(setting):
        finer = "steps" if "steps" in setting else "tolerance"
        return {k: v for k, v in setting.items() if k != finer}, finer

    same, finer = family(best.setting)
    for other in entries:
        if other.program == best.program and other.error is not None and other.error > target and family(other.setting) == (same, finer):
            less = float(other.setting[finer]) < float(best.setting[finer])
            if less == (finer == "tolerance") and other is not best:
                return True
    return False


def front(entries, program, worst=0.1):
    """Settings of a program that no other one of it beats in both error and time, fastest first, below an error that is of use."""
    chosen = []
    for entry in sorted((e for e in entries if e.program == program and e.seconds and e.error <= worst),
                        key=lambda e: (e.median, e.error)):
        if not chosen or entry.error < chosen[-1].error:
            chosen.append(entry)
    return chosen


def failures(entries):
    """Failures with one reason each: (entry, entries); reasons are the same if only numbers and names in them differ."""
    groups = {}
    for entry in entries:
        if entry.failure and not entry.seconds:
            reason = re.sub(r"'[^']*'|\d\S*", "", entry.failure)
            family = entry.setting.get("integrator", "")
            groups.setdefault((entry.program, family, reason), []).append(entry)
    return [(group[0], group) for group in groups.values()]


def number(value):
    """Three significant digits."""
    return f"{value:.2e}" if value < 1e-3 else f"{value:#.3g}"


def table(heading, rows, aligned=None):
    """A table in Markdown whose columns are padded, so that it is read as text too; aligned: l or r for each column."""
    rows = [[str(cell) for cell in row] for row in rows]
    aligned = aligned or "l"*len(heading)
    widths = [max(len(row[i]) for row in [heading] + rows) for i in range(len(heading))]

    def line(cells):
        return "| " + " | ".join(c.rjust(w) if a == "r" else c.ljust(w) for c, w, a in zip(cells, widths, aligned)) + " |"
    rule = "|" + "|".join("-"*(w + 1) + (":" if a == "r" else "-") for w, a in zip(widths, aligned)) + "|"
    return "\n".join([line(heading), rule] + [line(row) for row in rows])


def write_csv(path, entries):
    """All settings with their errors and times."""
    with open(path, "w", newline="") as file:
        writer = csv.writer(file)
        writer.writerow(["scene", "program", "setting", "error", "median_seconds", "least_seconds", "runs", "failure"])
        for e in entries:
            times = [e.median, min(e.seconds), len(e.seconds)] if e.seconds else ["", "", 0]
            writer.writerow([e.scene, e.program, e.label, "" if e.error is None else e.error, *times, e.failure or ""])
