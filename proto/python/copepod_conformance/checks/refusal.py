"""The check that many groups are made of: a request with one thing wrong is refused."""

from copepod_conformance.protocol import SETUP, content


def refused(name, spoil, text):
    """A check that sends the request `name` after `spoil(its content)`; `text` says what is wrong with it."""

    def run(trial):
        trial.reach("greeted" if name == SETUP[trial.role] else "configured")
        request = trial.make(name)
        spoil(content(request))
        trial.send(request)
        trial.sent[-1] += f" with {text}"
        trial.expect_failure(65)

    return run
