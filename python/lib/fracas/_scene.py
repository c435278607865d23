"""Scenes, and their runs through load steps."""

from __future__ import annotations

import csv
import json
import os
import weakref
from collections.abc import Iterator, Mapping
from dataclasses import dataclass, field
from pathlib import Path
from typing import TYPE_CHECKING, Any

import numpy as np

from . import _convert, _core
from ._convert import Vector, kind
from ._errors import InputError, SceneError, WrongType
from ._system import Observer, Settings, Solution, Solver, Spectrum, System, _asked, _path, _right_hand_side

if TYPE_CHECKING:
    from typing_extensions import Unpack


@dataclass(frozen=True)
class Mesh:
    """The mesh of a scene, split along its fractures.

    ``nodes`` (n, 3) [m]; ``elements`` (m, 8) in the order of VTK; ``regions`` (m,) into ``material_names``; fracture faces with their nodes on
    both sides ``faces_minus``, ``faces_plus`` (k, 4), ``centers`` (k, 3) [m], ``frames`` (k, 3, 3) with rows n, t1, t2, ``areas`` (k,) [m²] and
    ``fractures`` (k,) into ``fracture_names``.
    """

    nodes: Any
    elements: Any
    regions: Any
    faces_minus: Any
    faces_plus: Any
    centers: Any
    frames: Any
    areas: Any
    fractures: Any
    fracture_names: list[str]
    material_names: list[str]


@dataclass(frozen=True)
class Step:
    """A step that is done: fields at its end.

    ``displacement`` (nodes, 3) [m]; per face ``traction`` (n, t1, t2) [Pa], ``jump`` [m], ``slip`` [m], ``state`` (0 stick, 1 new-slip, 2 slip,
    3 open), ``aperture`` [m], ``criticality``, ``tau_limit`` [Pa], ``pressure`` [Pa]; with flow ``conductivity`` [m³] and ``flux`` [m²/s]. ``row``
    has the columns of history.csv.
    """

    row: dict[str, float]
    #: What happened on the way, as in log.jsonl: (name, members).
    events: list[tuple[str, dict[str, Any]]] = field(repr=False)
    displacement: Any = field(default=None, repr=False)
    traction: Any = field(default=None, repr=False)
    jump: Any = field(default=None, repr=False)
    #: The part of the jump that is neither slip nor opening [m].
    stabilization_jump: Any = field(default=None, repr=False)
    state: Any = field(default=None, repr=False)
    slip: Any = field(default=None, repr=False)
    aperture: Any = field(default=None, repr=False)
    criticality: Any = field(default=None, repr=False)
    tau_limit: Any = field(default=None, repr=False)
    pressure: Any = field(default=None, repr=False)
    #: The path of slip [m], where a fracture has ``weakening_by = "path"``.
    cumulated_slip: Any = field(default=None, repr=False)
    conductivity: Any = field(default=None, repr=False)
    flux: Any = field(default=None, repr=False)

    @property
    def step(self) -> int:
        """Its number; 0 is the equilibrium at time 0."""
        return int(self.row["step"])

    @property
    def time(self) -> float:
        """Time at its end [s]."""
        return self.row["time_s"]

    @staticmethod
    def _of(told: dict[str, Any]) -> Step:
        heading = _core.Steps.HEADING.strip().split(",")
        (line,) = csv.reader([told.pop("line").strip()])
        row = {name: float(value) for name, value in zip(heading, line, strict=True) if value}
        events = [(name, members) for name, members in map(json.loads, told.pop("events"))]
        return Step(row=row, events=events, **told)


class Run(Iterator[Step]):
    """Steps of a scene, each computed when it is asked for; ``Scene.run`` makes it.

    With a folder every step is on the disk before it is handed over, as `fracas run` leaves it. A step that does not converge raises
    `NotConverged`. ``close`` (or the end of a ``with`` block) stops before the end; the folder can be restarted. An observer may close its run,
    and may not ask it for a step.
    """

    def __init__(self, core: _core.Steps, observer: Observer | None = None):
        self._core = core
        # handed over with every wish, so that the run holds nobody who holds the run
        self._observer = observer
        # when it is let go, and where Python ends before it
        weakref.finalize(self, core.close)

    def __iter__(self) -> Run:
        return self

    def __next__(self) -> Step:
        told = self._core.advance(self._observer)
        if told is None:
            raise StopIteration
        return Step._of(told)

    def close(self) -> None:
        """Stops after the step at hand."""
        self._core.close()

    def __enter__(self) -> Run:
        return self

    def __exit__(self, *_: object) -> None:
        self.close()

    @property
    def outcome(self) -> str:
        """``running``, ``finished``, ``stopped``, ``interrupted``, ``not_converged``, ``unstable``, or ``failed`` after another exception."""
        return self._core.ended[0]

    @property
    def reason(self) -> str | None:
        """Why it ended before its time."""
        return self._core.ended[1]

    @property
    def folder(self) -> Path | None:
        """Where its files are, once it has ended."""
        path = self._core.ended[2]
        return None if path is None else Path(path)


def _sees_blocks(settings: Mapping[str, Any]) -> bool:
    """True where a part is an object: it sees blocks, and counts in their units."""
    parts = (settings.get(part, "") for part in ("preconditioner", "augmentation", "inner"))
    return not all(part is None or isinstance(part, (str, dict)) for part in parts)


class Scene:
    """A scene: geometry, materials, fractures, boundary conditions and loads.

    >>> import fracas
    >>> scene = fracas.Scene.gallery("crossing")
    >>> finer = scene.with_overrides({"mesh.x.cells": 20, "material.rock.young": "20 GPa"})
    >>> finer.nodes > scene.nodes
    True
    """

    def __init__(self, core: _core.Scene):
        self._core = core

    @classmethod
    def from_file(cls, path: str | os.PathLike[str], overrides: Mapping[str, Any] | None = None) -> Scene:
        """A scene file (TOML); paths in it start at its folder."""
        name = _path("path", path)
        if not os.path.isfile(name):
            raise SceneError(f"cannot read {name}: no such file")
        return cls(_core.Scene.load(name)).with_overrides(overrides)

    @classmethod
    def from_toml(cls, text: str, name: str = "scene.toml") -> Scene:
        """A scene from text; ``name`` is for messages, and its folder is where paths start."""
        if not isinstance(text, str):
            raise WrongType(f"text: expected TOML as text, not {kind(text)}")
        return cls(_core.Scene.from_toml(text, name))

    @classmethod
    def from_dict(cls, sections: dict[str, Any], name: str = "scene") -> Scene:
        """A scene from a dictionary of the sections of a scene file."""
        if not isinstance(sections, dict):
            raise WrongType(f"sections: expected a dictionary, not {kind(sections)}")
        return cls(_core.Scene.from_toml(_convert.toml(sections, name), name))

    @classmethod
    def gallery(cls, name: str, overrides: Mapping[str, Any] | None = None) -> Scene:
        """A scene of the gallery; ``"cycle:small"`` is its small version."""
        if not isinstance(name, str):
            raise WrongType(f"name: expected the name of a scene, not {kind(name)}")
        return cls(_core.Scene.load(name)).with_overrides(overrides)

    def with_overrides(self, overrides: Mapping[str, Any] | None) -> Scene:
        """The same with values replaced: ``{"mesh.x.cells": 8, "material.rock.young": "20 GPa"}``."""
        if not overrides:
            return self
        if not isinstance(overrides, Mapping):
            raise WrongType(f"overrides: expected a dictionary of keys and values, not {kind(overrides)}")

        def written(key: str, value: Any) -> str:
            return f"{key}={value if isinstance(value, str) else _convert._value(value, key, 'overrides')}"

        return Scene(self._core.with_overrides([written(key, value) for key, value in overrides.items()]))

    def to_toml(self) -> str:
        """The scene as TOML, defaults left out."""
        return self._core.to_toml()

    @property
    def title(self) -> str:
        """Title."""
        return self._core.title

    @property
    def nodes(self) -> int:
        """Nodes of the mesh before fractures split them."""
        return self._core.nodes

    def mesh(self) -> Mesh:
        """Nodes, elements and fracture faces."""
        arrays = self._core.mesh()
        arrays["frames"] = arrays["frames"].reshape(-1, 3, 3)
        return Mesh(**arrays)

    def system(self, *, stabilization: float = 1.0, observer: Observer | None = None) -> System:
        """The blocks with every face in stick; ``stabilization`` is the factor of H, 0 leaves it out."""
        return System._of(self._core.system(float(stabilization), observer))

    def solve(
        self, *, rhs: Any = None, stabilization: float = 1.0, observer: Observer | None = None, **settings: Unpack[Settings]
    ) -> Solution:
        """As `fracas solve SCENE`: A is not assembled where that serves. Settings as of `System.solve`; a C or a preconditioner that is an
        object sees the blocks, so that A is assembled."""
        name, b = _right_hand_side(rhs)
        if _sees_blocks(settings):
            return self.system(stabilization=stabilization).solve(rhs=rhs, observer=observer, **settings)
        return Solution._of(self._core.solve(_asked(rhs=name, **settings), float(stabilization), b, observer))

    def set_up(self, *, stabilization: float = 1.0, observer: Observer | None = None, **settings: Unpack[Settings]) -> Solver:
        """Everything that does not depend on a right-hand side."""
        if _sees_blocks(settings):
            return self.system(stabilization=stabilization).set_up(observer=observer, **settings)
        return Solver(self._core.set_up(_asked(**settings), float(stabilization), observer))

    def spectrum(
        self,
        preconditioner: Any = "racp",
        augmentation: Any = None,
        inner: Any = None,
        *,
        stabilization: float = 1.0,
        dense_limit: int | None = None,
        observer: Observer | None = None,
    ) -> Spectrum:
        """As `System.spectrum`, geometric multigrid included."""
        asked = _asked(preconditioner, augmentation, inner)
        return Spectrum._of(self._core.spectrum(asked, float(stabilization), dense_limit, observer))

    def run(
        self,
        out: str | os.PathLike[str] | None = None,
        *,
        restart: str | os.PathLike[str] | None = None,
        steps: int | None = None,
        fields_every: int = 1,
        clock: bool = False,
        fields: bool = True,
        observer: Observer | None = None,
    ) -> Run:
        """Load steps as an iterator; with ``out`` it leaves the bytes of `fracas run` there, without it writes no file.

        >>> import fracas
        >>> with fracas.Scene.gallery("cycle:small").run() as run:
        ...     step = next(run)
        >>> step.step, step.traction.shape[1], run.outcome
        (0, 3, 'interrupted')
        """
        for name, count in (("steps", steps), ("fields_every", fields_every)):
            if count is not None and (not isinstance(count, (int, np.integer)) or count < 1):
                raise InputError(f"{name} = {count!r}: expected a number from 1 on")
        return Run(
            self._core.run(
                None if out is None else _path("out", out),
                None if restart is None else _path("restart", restart),
                steps,
                fields_every,
                clock,
                fields,
                observer,
            ),
            observer,
        )

    def __repr__(self) -> str:
        return f"<fracas.Scene {self._core.name!r}: {self.title}>"


def gallery() -> dict[str, str]:
    """Names of the scenes of the gallery, with their questions."""
    return dict(_core.gallery())


__all__ = ["Mesh", "Run", "Scene", "Step", "Vector", "gallery"]
