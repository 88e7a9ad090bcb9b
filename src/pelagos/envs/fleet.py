"""Many copies of a task as one Gymnasium `VectorEnv`: a step of all of them is one kernel."""

from __future__ import annotations

import ctypes
from collections.abc import Mapping
from typing import Any, Final, Literal

import drjit as dr
import gymnasium
import numpy as np
from gymnasium.vector import AutoresetMode, VectorEnv
from numpy.typing import NDArray

from pelagos import jit
from pelagos.envs import program as codes
from pelagos.envs.program import Autoreset, Program
from pelagos.envs.task import Task
from pelagos.errors import CommandError, LookupFailed
from pelagos.jit import Array
from pelagos.sim.seed import seed_of

MODES: Final = {
    "same_step": AutoresetMode.SAME_STEP,
    "next_step": AutoresetMode.NEXT_STEP,
    "disabled": AutoresetMode.DISABLED,
}
_OPTIONS: Final = ("reset_mask",)


class FleetEnv(VectorEnv[Any, Any, Any]):
    """`n` copies of a task.

    Observations are `(n, k)` float32, named by `names`; actions `(n, m)` float32 between -1 and 1. `info` has each
    metric of the task `(n,)`; where episodes end with `same_step`, `final_obs` `(n, k)` with the mask `_final_obs`, and
    the same metrics as `final_info`; `not_finite` `(n,)` where a copy's state broke: its episode is terminated, with
    reward 0 and the last good state; `clipped` `(n,)` where an action was out of range.

    Attributes:
        task: what is to be done.
        arrays: what it gives, `numpy` or `torch`.
        names: of an observation's numbers.
        size: how many they are.
        actions: numbers of an action.
        metrics: names of the task's.
        clipped: how many actions have been out of range so far.
        not_finite: how many episodes ended because a state was not finite.
    """

    def __init__(
        self,
        task: Task,
        n: int = 1,
        *,
        seed: int = 0,
        environment: int = 0,
        autoreset: Autoreset = "same_step",
        arrays: Literal["numpy", "torch"] = "numpy",
        out_of_range: Literal["clip", "refuse"] = "clip",
    ) -> None:
        """Compile a task for `n` copies.

        Args:
            task: see `envs.task.Task`.
            n: copies.
            seed: of every random stream.
            environment: index of the first copy; copy i is byte for byte a fleet of one with `environment=i`.
            autoreset: which of Gymnasium's three modes.
            arrays: what `reset` and `step` give: NumPy, or torch tensors that share the kernel's memory.
            out_of_range: actions beyond -1 .. 1 are clipped and counted, or refused.

        Raises:
            CommandError, LookupFailed: an argument that cannot be, or a task that contradicts itself.
        """
        if isinstance(n, bool) or not isinstance(n, int | np.integer) or n < 1:
            raise CommandError(f"n is the number of copies, a whole number from 1 on; given {n!r}")
        for what, given, known in (
            ("autoreset mode", autoreset, MODES),
            ("kind of arrays", arrays, ("numpy", "torch")),
            ("way with actions out of range", out_of_range, ("clip", "refuse")),
        ):
            if given not in known:
                raise LookupFailed(what, str(given), known)
        if arrays == "torch":
            _torch()
        self.task, self.num_envs, self.names = task, int(n), tuple(task.observations)
        self._seed = seed_of(seed)
        self._first, self.arrays, self._out_of_range = seed_of(environment), arrays, out_of_range
        self.program = Program(task, self.num_envs, seed=self._seed, environment=self._first, autoreset=autoreset)
        self.size, self.actions, self.metrics = self.program.size, self.program.actions, self.program.metrics
        self.autoreset, self.autoreset_mode = autoreset, MODES[autoreset]
        self.metadata = {"autoreset_mode": self.autoreset_mode, "render_modes": []}
        self._space()
        self._inbox = Inbox(self.num_envs * self.program.actions)
        self._keeps: tuple[Array, Array] | None = None
        self._all = dr.opaque(jit.Bool, True, self.num_envs)
        self.clipped = self.not_finite = 0

    def _space(self) -> None:
        most, box = np.float32(codes.LARGEST), gymnasium.spaces.Box
        self.single_observation_space = box(-most, most, (self.program.size,), np.float32)
        self.single_action_space = box(np.float32(-1), np.float32(1), (self.program.actions,), np.float32)
        self.observation_space = gymnasium.vector.utils.batch_space(self.single_observation_space, self.num_envs)
        self.action_space = gymnasium.vector.utils.batch_space(self.single_action_space, self.num_envs)

    # the three verbs

    def reset(self, *, seed: int | None = None, options: Mapping[str, Any] | None = None) -> tuple[Any, dict[str, Any]]:
        """Begin the next episode of every copy, or of those in `options={"reset_mask": (n,) bool}`.

        With a seed, random streams are those of the seed, and every copy begins with its episode number 0.
        """
        mask, options = None, dict(options or {})
        for name in options:
            if name not in _OPTIONS:
                raise LookupFailed("option of reset", name, _OPTIONS)
        if options.get("reset_mask") is not None:
            mask = self._mask(options["reset_mask"])
        if seed is not None:
            if mask is not None:
                raise CommandError("a seed is that of all copies; leave out reset_mask")
            super().reset(seed=seed)
            self._seed = seed_of(seed)
            self.program.name(self._seed, self._first)
        if seed is not None or self._keeps is None:
            self._keeps = self._nothing()
        where = self._all if mask is None else jit.Bool(mask)
        packed, counters, obs = self.program.begin(*self._keeps, where)
        self._keeps = packed, counters
        dr.sync_thread()
        return self._out(obs, (self.num_envs, self.program.size)), {}

    def step(self, actions: Any) -> tuple[Any, Any, Any, Any, dict[str, Any]]:
        """One decision of all copies: observations, rewards, terminated, truncated, info."""
        if self._keeps is None:
            raise CommandError("the first call is reset()")
        given = self._inbox.put(actions, (self.num_envs, self.program.actions))
        if self._out_of_range == "refuse":
            self._refuse()
        packed, counters, out = self.program.step(*self._keeps, given)
        self._keeps = packed, counters
        dr.sync_thread()
        return self._told(out)

    def close_extras(self, **kwargs: Any) -> None:
        """Let go of the copies' states."""
        self._keeps = None

    @property
    def state(self) -> dict[str, NDArray[np.float64]]:
        """The true states: `position` `(n, 3)` world NWU [m], `attitude` `(n, 4)` (w, x, y, z), `velocity` and
        `angular_velocity` `(n, 3)` body FLU, and what the task remembers, `(n,)` by name.
        """
        from pelagos.math.frames import flip_quaternion_np, flip_yz_np

        if self._keeps is None:
            raise CommandError("the first call is reset()")
        rows = np.array(self._keeps[0]).reshape(-1, self.num_envs)
        found = {"position": flip_yz_np(rows[0:3].T), "attitude": flip_quaternion_np(rows[3:7].T)}
        found |= {"velocity": flip_yz_np(rows[7:10].T), "angular_velocity": flip_yz_np(rows[10:13].T)}
        kept = rows[len(rows) - len(self.program.names) :]
        return found | dict(zip(self.program.names, kept, strict=True))

    @property
    def first_environment(self) -> int:
        """Index of the first copy."""
        return self._first

    @property
    def episode(self) -> NDArray[np.uint32]:
        """`(n,)` number of the episode of each copy."""
        if self._keeps is None:
            raise CommandError("the first call is reset()")
        return np.array(self._keeps[1])[self.num_envs : 2 * self.num_envs]

    # between the kernel and the caller

    def _nothing(self) -> tuple[Array, Array]:
        """States before the first episode."""
        n = self.num_envs
        counters = np.zeros((3, n), dtype=np.uint32)
        counters[1] = codes.FIRST_EPISODE
        return jit.from_numpy(jit.Float64, np.zeros(self.program.channels * n)), jit.from_numpy(jit.UInt32, counters)

    def _mask(self, given: Any) -> NDArray[np.bool_]:
        mask = np.asarray(given)
        if mask.dtype != np.bool_ or mask.shape != (self.num_envs,) or not mask.any():
            raise CommandError(
                f"reset_mask is ({self.num_envs},) bool with at least one True; given {mask.dtype} {mask.shape}"
            )
        if self._keeps is None:
            raise CommandError("the first reset is that of all copies; leave out reset_mask")
        return mask

    def _refuse(self) -> None:
        bad = np.flatnonzero(~(np.abs(self._inbox.values).reshape(self.num_envs, -1) <= 1).all(axis=1))
        if len(bad):
            row = self._inbox.values.reshape(self.num_envs, -1)[bad[0]]
            raise CommandError(
                f"actions are between -1 and 1; copy {bad[0]} was given {np.array2string(row, precision=3)}"
                + (f", and so were {len(bad) - 1} others" if len(bad) > 1 else "")
            )

    def _told(self, out: Array) -> tuple[Any, Any, Any, Any, dict[str, Any]]:
        n, size, p = self.num_envs, self.program.size, self.program
        numbers = np.from_dlpack(out) if jit.device == "cpu" else np.array(out)
        whole = self._out(out, None)
        at = n * size
        final = None
        if p.autoreset == "same_step":
            final, at = whole[at : 2 * at].reshape(n, size), 2 * at
        code = numbers[at + n : at + 2 * n].astype(np.uint8)
        seen = int(np.bitwise_or.reduce(code))
        terminated, truncated = self._flag(code, codes.TERMINATED), self._flag(code, codes.TRUNCATED)
        first = at + 2 * n
        info: dict[str, Any] = {name: whole[first + i * n : first + (i + 1) * n] for i, name in enumerate(p.metrics)}
        if final is not None and seen & (codes.TERMINATED | codes.TRUNCATED):
            done = terminated | truncated
            last = {k: v for name, value in info.items() for k, v in ((name, value), (f"_{name}", done))}
            info |= {"final_obs": final, "_final_obs": done, "final_info": last, "_final_info": done}
        if seen & ~(codes.TERMINATED | codes.TRUNCATED):
            self._count(code, seen, info)
        return whole[: n * size].reshape(n, size), whole[at : at + n], terminated, truncated, info

    def _count(self, code: NDArray[np.uint8], seen: int, info: dict[str, Any]) -> None:
        if seen & codes.NO_NUMBER:
            bad = np.flatnonzero(code & codes.NO_NUMBER)
            raise CommandError(
                f"the action of copy {bad[0]} is not finite" + (f", as of {len(bad) - 1} others" * (len(bad) > 1))
            )
        for bit, name in ((codes.CLIPPED, "clipped"), (codes.NOT_FINITE, "not_finite")):
            if seen & bit:
                where = (code & bit) != 0
                info[name] = self._flag(code, bit)
                setattr(self, name, getattr(self, name) + int(where.sum()))

    def _flag(self, code: NDArray[np.uint8], bit: int) -> Any:
        mask = (code & bit) != 0
        return mask if self.arrays == "numpy" else _torch().from_numpy(mask)

    def _out(self, values: Array, shape: tuple[int, ...] | None) -> Any:
        """An array of the caller's kind; one of NumPy is its own."""
        if self.arrays == "torch":
            tensor = _torch().from_dlpack(values)
            return tensor if shape is None else tensor.view(*shape)
        found = np.array(values)
        return found if shape is None else found.reshape(shape)


class Inbox:
    """Memory of the device into which commands are copied: always the same, so that one recording serves."""

    def __init__(self, size: int) -> None:
        self._array = jit.from_numpy(jit.Float, np.zeros(size, dtype=np.float32))
        self.values = np.zeros(size, dtype=np.float32)
        if jit.device == "cpu":
            shown = np.from_dlpack(self._array).__array_interface__["data"][0]  # a view that NumPy does not write to
            self.values = np.ctypeslib.as_array(ctypes.cast(shown, ctypes.POINTER(ctypes.c_float)), (size,))

    def put(self, given: Any, shape: tuple[int, int]) -> Array:
        """Numbers of NumPy, torch or anything that NumPy takes, as a `Float` on the device.

        Raises:
            CommandError: another shape, or no numbers.
        """
        try:
            values = np.asarray(given.detach().cpu() if hasattr(given, "detach") else given)
            if values.shape != shape:
                raise CommandError(f"actions have shape {shape}; given {values.shape}")
            self.values[:] = values.reshape(-1)
        except (TypeError, ValueError) as error:
            raise CommandError(f"actions are numbers of shape {shape}: {error}") from None
        return self._array if jit.device == "cpu" else jit.Float(self.values)


def _torch() -> Any:
    try:
        import torch
    except ImportError:
        raise CommandError("arrays='torch' needs torch: pip install 'pelagos[learn]'") from None
    return torch
