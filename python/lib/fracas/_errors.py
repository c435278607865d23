"""Exceptions: a class per kind, with the sentences of the library."""


class Error(Exception):
    """Whatever fracas refuses or cannot do."""


class InputError(Error, ValueError):
    """An argument that cannot be: which, and what it may be."""


class WrongType(Error, TypeError):
    """An object of another kind: which argument, what was expected, what was given."""


class SceneError(Error, ValueError):
    """A scene that cannot be read or built: where, and what to do."""


class SystemInputError(Error, ValueError):
    """Matrices or a folder that are no system: which block, which row and column."""


class SetupError(Error):
    """A preconditioner that cannot be set up: which block, which row, what to take instead."""


class OutOfMemory(Error, MemoryError):
    """Work that does not fit into memory: how much it takes, and what takes less."""


class RunError(Error):
    """A run that cannot begin, or a folder that cannot be written."""


class NotConverged(Error):
    """A step of a run that does not converge: the run ends at the last good state."""


class StudyError(Error):
    """A study that cannot be read, or whose folder cannot be written."""
