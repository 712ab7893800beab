"""How much of the coupling overlaps the bulk update: the gain of the early reply.

Once the fluid has replied with the loads of step n, two things happen at the same time: its bulk update of step n, and
the round trip over coupler, bodies and messages until the kinematics of step n + 1 arrive. What is left of the round
trip after the bulk update is what the fluid waits for.
"""

from operator import ge
from statistics import median


def _steps(timelines):
    """Nanoseconds of each step that the coupler and the rank 0 of the fluid recorded whole: the bulk update after the
    reply; the round trip, from the reply until the coupler asked about the next step; the part of that during which the
    bulk update ran; how long the fluid waited for the next request, after its bulk update."""
    fluid = next((each for each in timelines if (each.process, each.rank) == ("fluid", 0)), None)
    coupler = next((each for each in timelines if each.process == "coupler"), None)
    if fluid is None or coupler is None:
        return
    exchanging, asks = _by_step(fluid, "exchanging"), _by_step(coupler, "wait for fluid")
    waits = {phase.begin_ns: phase.end_ns - phase.begin_ns for phase in fluid.phases if phase.name == "waiting"}
    for step, bulk in sorted(_by_step(fluid, "advancing").items()):
        if step in exchanging and step in asks and step + 1 in asks:
            # The coupler may have the loads before the fluid, on the same core, returns from sending them.
            replied = min(exchanging[step].end_ns, asks[step].end_ns)
            asked = asks[step + 1].begin_ns
            hidden = max(0, min(asked, bulk.end_ns) - max(replied, bulk.begin_ns))
            yield bulk.end_ns - bulk.begin_ns, asked - replied, hidden, waits.get(bulk.end_ns, 0)


def _by_step(timeline, name):
    """First phase of this name in each step."""
    found: dict = {}
    for phase in timeline.phases:
        if phase.name == name and phase.step >= 0:
            found.setdefault(phase.step, phase)
    return found


def figures(timelines):
    """Steps, medians in µs, shares of the round trip and of the steps that were hidden; empty without steps."""
    found = list(_steps(timelines))
    if not found:
        return {}
    bulk, round_trip, hidden, waited = zip(*found)
    return {
        "steps": len(found),
        "bulk_us": median(bulk) * 1e-3,
        "round_trip_us": median(round_trip) * 1e-3,
        "waited_us": median(waited) * 1e-3,
        "hidden": sum(hidden) / sum(round_trip) if sum(round_trip) > 0 else 1.0,
        "hidden_steps": sum(map(ge, hidden, round_trip)) / len(found),
    }


def text(figures):
    """The figures as a sentence or two."""
    return (
        f"{figures['steps']} steps; medians: bulk update {figures['bulk_us']:.0f} us, round trip over coupler and "
        f"bodies {figures['round_trip_us']:.0f} us, wait of the fluid {figures['waited_us']:.0f} us\n"
        f"hidden by the bulk update: {100 * figures['hidden']:.1f} % of the round trip; all of it in "
        f"{100 * figures['hidden_steps']:.1f} % of the steps"
    )
