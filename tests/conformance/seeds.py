"""The unharmed reference over many seeds: a kit that cries wolf is no use. `python -m
tests.conformance.seeds 1000`
"""

import sys

from refimpl.conformance import cases, judge_all, reference
from refimpl.conformance.verify import verify


def false_alarms(seeds):
    """Messages of all cases that the reference does not pass.   ->  list of str, number of verdicts
    """
    messages, verdicts = [], 0
    for seed in seeds:
        for outcome in judge_all(reference(), cases(seed=seed, profile="small")):
            verdicts += 1
            if outcome.status != "passed":
                messages.append(f"seed {seed}: {outcome.message}")
    return messages, verdicts


def false_alarms_of_the_instruments(seeds):
    """The same for the second derivation and the gradient instruments."""
    return [f"seed {seed}: {failure}" for seed in seeds for found in verify(seed=seed)
            for failure in found.failures]


if __name__ == "__main__":
    count = int(sys.argv[1]) if len(sys.argv) > 1 else 1000
    wrong, verdicts = false_alarms(range(count))
    print(f"{count} seeds, {verdicts} verdicts, {len(wrong)} false alarms", *wrong[:20], sep="\n")
    slow = max(1, count // 50)
    wrong = false_alarms_of_the_instruments(range(slow))
    print(f"{slow} seeds of the second derivation and the instruments, {len(wrong)} false alarms",
          *wrong[:20], sep="\n")
