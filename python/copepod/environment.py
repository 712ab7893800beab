"""Simulations as environments for reinforcement learning, in Gymnasium's conventions (1.x), installed or not."""

import importlib.util
import os
from collections.abc import Callable, Sequence
from concurrent.futures import ThreadPoolExecutor
from typing import Any

import numpy

from copepod.errors import Error, RunError
from copepod.running import AnyCase, Settings
from copepod.simulation import Simulation

_Base: Any = importlib.import_module("gymnasium").Env if importlib.util.find_spec("gymnasium") else object
_Step = tuple[Any, float, bool, bool, dict[str, Any]]


class Environment(_Base):
    """One swimmer, or whatever a case has, as an environment. A subclass defines what an agent sees and does:

        class Swimmer(copepod.Environment):
            def observe(self): return self.sim.bodies.position_m[:, 2]
            def act(self, action): self.sim.actuators[0] = 1e-9 * action
            def reward(self, before, after): return after.mean() - before.mean()

    `reset` returns to a snapshot: the same seed and actions give the same bits. Where Gymnasium is installed this is
    one of its `Env`; `observation_space` and `action_space` are the subclass's to set.
    """

    def __init__(
        self, case: AnyCase, *, steps_per_action: int, actions_per_episode: int = 0, set: Settings = (), ranks: int = 1
    ) -> None:
        """
        @param steps_per_action     steps of the simulation
        @param actions_per_episode  after which an episode is truncated; 0: never
        @param set, ranks           as of `Simulation`
        @throws CaseError for a bad case
        """
        self.sim = Simulation(case, set=set, ranks=ranks)
        self.steps_per_action = steps_per_action
        self.actions_per_episode = actions_per_episode
        self.np_random = numpy.random.default_rng()
        self._start = self.sim.snapshot()
        self._actions = -1  # no episode so far
        self._seen: Any = None

    def observe(self) -> Any:
        """What the agent sees now."""
        raise NotImplementedError

    def act(self, action: Any) -> None:
        """Sets what an action changes, before the steps are taken."""
        raise NotImplementedError

    def reward(self, before: Any, after: Any) -> float:
        """Reward of an action, from the observations before and after."""
        raise NotImplementedError

    def is_over(self) -> bool:
        """Whether an episode ends here by itself."""
        return False

    def begin(self, options: dict[str, Any]) -> None:
        """What differs from one episode to the next, by `np_random` and the options of `reset`. Default: nothing."""

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Begins an episode. @return observation, and an empty info"""
        if seed is not None:
            self.np_random = numpy.random.default_rng(seed)
        self.sim.restore(self._start)
        self._actions = 0
        self.begin(options or {})
        self._seen = self.observe()
        return self._seen, {}

    def step(self, action: Any) -> _Step:
        """Takes an action. A simulation that diverges truncates its episode, with the reason in info.

        @return observation, reward, terminated, truncated, info
        """
        if self._actions < 0:
            raise Error("this episode is over, or has not begun (step needs one). Call reset first.", 64)
        try:
            self.act(action)
            self.sim.step(self.steps_per_action)
        except RunError as failure:
            self._actions = -1
            return self._seen, 0.0, False, True, {"reason": str(failure)}
        self._actions += 1
        before, self._seen = self._seen, self.observe()
        terminated = bool(self.is_over())
        truncated = self._actions == self.actions_per_episode
        if terminated or truncated:
            self._actions = -1
        return self._seen, float(self.reward(before, self._seen)), terminated, truncated, {}

    def close(self) -> None:
        """Frees the simulation."""
        self.sim.close()


class ParallelEnvironment(Environment):
    """Several agents in one simulation, in PettingZoo's parallel convention, installed or not: observations, actions
    and rewards are dictionaries by agent, and `agents` is empty once the episode, which all share, is over.

    A subclass defines `possible_agents`, and `observe`, `act` and `rewards` with such dictionaries;
    `observation_space(agent)` and `action_space(agent)` are its to define, too.
    """

    possible_agents: Sequence[Any] = ()  #: all of them
    agents: Sequence[Any] = ()  #: those whose episode is not over

    def rewards(self, before: Any, after: Any) -> dict[Any, float]:
        """Reward of each agent, from the observations before and after."""
        raise NotImplementedError

    def reward(self, before: Any, after: Any) -> float:
        self._rewards = self.rewards(before, after)
        return 0.0

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[Any, Any]]:
        """Begins an episode. @return observations, and an empty info for each agent"""
        seen, _ = super().reset(seed=seed, options=options)
        self.agents = list(self.possible_agents)
        return seen, {agent: {} for agent in self.agents}

    def step(self, actions: Any) -> tuple[Any, Any, Any, Any, dict[Any, Any]]:
        """@return observations, rewards, terminations, truncations and infos, each by agent"""
        self._rewards = dict.fromkeys(self.agents, 0.0)
        seen, _, terminated, truncated, info = super().step(actions)
        terminations, truncations = (dict.fromkeys(self.agents, end) for end in (terminated, truncated))
        infos = {agent: dict(info) for agent in self.agents}
        self.agents = [] if terminated or truncated else self.agents
        return seen, self._rewards, terminations, truncations, infos


class Environments:
    """Several environments that share the cores; one that has ended is reset by the next `step`, which ignores its
    action (Gymnasium's AutoresetMode.NEXT_STEP)."""

    def __init__(self, make: Sequence[Callable[[], Environment]]) -> None:
        """@param make  makes each of them; they are opened at once"""
        self._pool = ThreadPoolExecutor(len(os.sched_getaffinity(0)))
        self.environments = list(self._pool.map(lambda one: one(), make))
        self.num_envs = len(self.environments)
        self._ended = [True] * self.num_envs

    def reset(self, *, seed: int | None = None, options: dict[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Begins an episode in all: the first has the seed, the next one more, and so on."""

        def begin(number: int) -> tuple[Any, dict[str, Any]]:
            own = None if seed is None else seed + number
            return self.environments[number].reset(seed=own, options=options)

        seen, _ = zip(*self._pool.map(begin, range(self.num_envs)), strict=True)
        self._ended = [False] * self.num_envs
        return numpy.array(seen), {}

    def step(self, actions: Sequence[Any]) -> tuple[Any, Any, Any, Any, dict[str, Any]]:
        """One action each. @return arrays of observations, rewards, terminated, truncated; `reason` in info has texts
        of those that diverged"""

        def one(number: int) -> _Step:
            if not self._ended[number]:
                return self.environments[number].step(actions[number])
            seen, info = self.environments[number].reset()
            return seen, 0.0, False, False, info

        seen, rewards, terminated, truncated, infos = zip(*self._pool.map(one, range(self.num_envs)), strict=True)
        self._ended = [ended or cut for ended, cut in zip(terminated, truncated, strict=True)]
        reasons = {number: info["reason"] for number, info in enumerate(infos) if info}
        info = {"reason": reasons} if reasons else {}
        return numpy.array(seen), numpy.array(rewards), numpy.array(terminated), numpy.array(truncated), info

    def close(self) -> None:
        """Frees all simulations."""
        for environment in self.environments:
            environment.close()
        self._pool.shutdown()
