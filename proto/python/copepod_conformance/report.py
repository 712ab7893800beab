"""Results as a table for people, and as JUnit XML for continuous integration."""

from collections import Counter
from xml.etree import ElementTree

from copepod_conformance.suite import GROUPS


def counts(results):
    """How many of each outcome."""
    return Counter(result.outcome for result in results)


def table(subject, results, verbose=False):
    """One line per group, then everything that failed and why something was left out."""
    solver = f", solver {subject.case.solver}" if subject.case.solver else ""
    lines = [
        f"{subject.name} {subject.capabilities.get('version', '')}, {subject.role}{solver}: "
        f"{' '.join(subject.command)}",
        "",
        f"  {'':<16}{'passed':>8}{'failed':>8}{'skipped':>9}",
    ]
    for group in GROUPS:
        of_group = [result for result in results if result.check.group == group]
        if of_group:
            number = counts(of_group)
            lines.append(f"  {group:<16}{number['passed']:>8}{number['failed'] or '':>8}{number['skipped'] or '':>9}")
        for result in of_group if verbose else []:
            lines.append(f"    {result.outcome:<8} {result.check.name} ({result.seconds:.1f} s)")
    skips = Counter(result.came for result in results if result.outcome == "skipped")
    lines += ["", *(f"  skipped {number}: {reason}" for reason, number in skips.items())] if skips else []
    for result in results:
        if result.outcome == "failed":
            lines += ["", *failure_lines(result)]
    number = counts(results)
    verdict = "not conformant" if number["failed"] else "conformant"
    lines += ["", f"{verdict}: {number['passed']} passed, {number['failed']} failed, {number['skipped']} skipped"]
    return "\n".join(lines)


def failure_lines(result):
    """What was sent, what came, and what the rule demands."""
    rule = result.check.rule
    return [
        f"FAILED {result.check.group}: {result.check.name}",
        f"  sent  {result.sent or 'nothing'}",
        f"  came  {result.came}",
        f"  rule  {rule.text}",
        f"        docs/protocol.md, «{rule.section}»",
    ]


def junit(subject, results, seconds):
    """The results as JUnit XML, bytes."""
    number = counts(results)
    suite = ElementTree.Element(
        "testsuite",
        name=f"conformance of {subject.name} ({subject.role})",
        tests=str(len(results)),
        failures=str(number["failed"]),
        errors="0",
        skipped=str(number["skipped"]),
        time=f"{seconds:.3f}",
    )
    for result in results:
        about = {"classname": f"conformance.{result.check.group}", "name": result.check.name}
        case = ElementTree.SubElement(suite, "testcase", about, time=f"{result.seconds:.3f}")
        if result.outcome == "failed":
            failure = ElementTree.SubElement(case, "failure", message=_printable(result.came))
            failure.text = _printable("\n".join(failure_lines(result)))
        elif result.outcome == "skipped":
            ElementTree.SubElement(case, "skipped", message=result.came)
    ElementTree.indent(suite)
    return ElementTree.tostring(suite, encoding="utf-8", xml_declaration=True)


def _printable(text):
    """XML allows no control characters, but a component's last words may contain some."""
    return "".join(character if character.isprintable() or character in "\n\t" else "?" for character in text)
