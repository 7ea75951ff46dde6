"""Runs of limber: a deck with some options exchanged, CPU seconds of the time loop, and the channels of the results."""

import re
import subprocess

from compare import Run


class Limber:
    """The program, with a folder for decks and results."""

    def __init__(self, program, folder, limit):
        """program: path of limber; folder: a Path; limit: seconds after which a run is given up."""
        self.program = str(program)
        self.folder = folder
        self.limit = limit

    def version(self):
        """Version and commit."""
        answer = subprocess.run([self.program, "--version"], capture_output=True, text=True, check=True)
        return answer.stdout.splitlines()[0].removeprefix("limber ")

    def run(self, deck, channels):
        """One run of a deck given as text."""
        (self.folder / "deck.inp").write_text(deck)
        command = [self.program, "run", "deck.inp", "-o", "deck.h5", "--force"]
        try:
            answer = subprocess.run(command, cwd=self.folder, capture_output=True, text=True, timeout=self.limit)
        except subprocess.TimeoutExpired:
            return Run(failure=f"not finished after {self.limit:g} s", slow=True)
        if answer.returncode:
            return Run(failure=one_line(answer.stderr))
        seconds, before = re.search(r"(\S+) s CPU in the time loop; (\S+) s before it", answer.stdout).groups()
        chosen = re.search(r"^ +(\w+), chosen", answer.stdout, re.MULTILINE)
        times, columns = self.export(channels)
        return Run(seconds=float(seconds), before=float(before), chosen=chosen and chosen.group(1), times=times, columns=columns)

    def export(self, channels):
        """Times and channels of the last run."""
        answer = subprocess.run([self.program, "export", "deck.h5", *channels], cwd=self.folder, capture_output=True, text=True,
                                check=True)
        rows = [[float(word) for word in line.split()] for line in answer.stdout.splitlines() if not line.startswith("#")]
        times, *columns = map(list, zip(*rows))
        return times, dict(zip(channels, columns))


def one_line(message):
    """The first sentence of a message of limber, without the name of the deck."""
    return re.split(r"\. (?=[A-Z])|\n", re.sub(r"^(limber: |error: |deck\.inp: )+", "", message.strip()))[0]


def with_options(deck, block, options):
    """A deck in which a block, the only one of its keyword, has other values of its options; None takes an option away."""
    start = deck.index(f"\n*{block},") + 1
    head = re.match(r"\*[^\n]*(?:\n[ \t]+[A-Z ]+=[^\n]*)*", deck[start:]).group(0)
    changed = head
    for name, value in options.items():
        changed = re.sub(rf",\s*{name}\s*=\s*[^,\n]+", "", changed)
        if value is not None:
            changed = changed.rstrip().rstrip(",") + f",\n  {name}={value}"
    return deck[:start] + changed + deck[start + len(head):]


def with_channels(deck, lines):
    """A deck whose *OUTPUT, the last block, has these lines."""
    return deck[:deck.index("\n*OUTPUT") + 1] + "*OUTPUT\n" + "".join(f" {line}\n" for line in lines)
