"""How much of the coupling overlaps the bulk update: the gain of the early reply.

Once the fluid has replied with the loads of step n, two things happen at the same time: its bulk update of step n, and
the round trip over coupler, bodies and messages until the kinematics of step n + 1 arrive. What is left of the round
trip after the bulk update is what the fluid waits for.
"""

from dataclasses import dataclass
from statistics import median


@dataclass(frozen=True)
class Step:
    """Nanoseconds of one step."""

    bulk: int  # the fluid's bulk update, after its reply
    round_trip: int  # from the fluid's reply until the coupler asked about the next step
    hidden: int  # the part of the round trip during which the bulk update ran
    waited: int  # the fluid, for the next request, after its bulk update


def steps(timelines):
    """A Step for every step that the coupler and the fluid's rank 0 recorded whole."""
    fluid = next((each for each in timelines if (each.process, each.rank) == ("fluid", 0)), None)
    coupler = next((each for each in timelines if each.process == "coupler"), None)
    if fluid is None or coupler is None:
        return []
    advancing = _by_step(fluid, "advancing")
    exchanging = _by_step(fluid, "exchanging")
    waiting = {phase.begin_ns: phase for phase in fluid.phases if phase.name == "waiting"}
    asks = _by_step(coupler, "wait for fluid")
    found = []
    for step, bulk in sorted(advancing.items()):
        if step not in exchanging or step not in asks or step + 1 not in asks:
            continue
        # The coupler may have the loads before the fluid, on the same core, returns from sending them.
        replied = min(exchanging[step].end_ns, asks[step].end_ns)
        asked = asks[step + 1].begin_ns
        wait = waiting.get(bulk.end_ns)
        found.append(
            Step(
                bulk.end_ns - bulk.begin_ns,
                asked - replied,
                max(0, min(asked, bulk.end_ns) - max(replied, bulk.begin_ns)),
                wait.end_ns - wait.begin_ns if wait else 0,
            )
        )
    return found


def _by_step(timeline, name):
    """First phase of this name in each step."""
    found: dict = {}
    for phase in timeline.phases:
        if phase.name == name and phase.step >= 0:
            found.setdefault(phase.step, phase)
    return found


def figures(timelines):
    """Steps, medians in µs, shares of the round trip and of the steps that were hidden; empty without steps."""
    found = steps(timelines)
    if not found:
        return {}
    round_trip = sum(step.round_trip for step in found)
    return {
        "steps": len(found),
        "bulk_us": median(step.bulk for step in found) * 1e-3,
        "round_trip_us": median(step.round_trip for step in found) * 1e-3,
        "waited_us": median(step.waited for step in found) * 1e-3,
        "hidden": sum(step.hidden for step in found) / round_trip if round_trip > 0 else 1.0,
        "hidden_steps": sum(step.hidden >= step.round_trip for step in found) / len(found),
    }


def text(figures):
    """The figures as a sentence or two."""
    return (
        f"{figures['steps']} steps; medians: bulk update {figures['bulk_us']:.0f} us, round trip over coupler and "
        f"bodies {figures['round_trip_us']:.0f} us, wait of the fluid {figures['waited_us']:.0f} us\n"
        f"hidden by the bulk update: {100 * figures['hidden']:.1f} % of the round trip; all of it in "
        f"{100 * figures['hidden_steps']:.1f} % of the steps"
    )
