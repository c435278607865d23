"""Frictional contact and flow on fractures, and the saddle points that they make.

>>> import fracas
>>> solution = fracas.Scene.gallery("patch").solve()
>>> solution.converged
True

Scenes (`Scene`) become systems (`System`) that are solved (`Solution`), analysed (`Spectrum`) and multiplied with; `Scene.run` goes
through load steps; `study` compares methods. Everything runs without the interpreter's lock, Ctrl-C ends it, and whatever cannot be is
an `Error` with one sentence.
"""

from ._core import Event, __version__, has_suitesparse, set_threads
from ._errors import (
    Error,
    InputError,
    NotConverged,
    OutOfMemory,
    RunError,
    SceneError,
    SetupError,
    StudyError,
    SystemInputError,
    WrongType,
)
from ._parts import register_augmentation, register_inner, register_preconditioner
from ._scene import Mesh, Run, Scene, Step, gallery
from ._study import Study, study
from ._system import Part, Settings, Solution, Solver, Spectrum, System

__all__ = [
    "Error",
    "Event",
    "InputError",
    "Mesh",
    "NotConverged",
    "OutOfMemory",
    "Part",
    "Run",
    "RunError",
    "Scene",
    "SceneError",
    "Settings",
    "SetupError",
    "Solution",
    "Solver",
    "Spectrum",
    "Step",
    "Study",
    "StudyError",
    "System",
    "SystemInputError",
    "WrongType",
    "__version__",
    "gallery",
    "has_suitesparse",
    "register_augmentation",
    "register_inner",
    "register_preconditioner",
    "set_threads",
    "study",
]
