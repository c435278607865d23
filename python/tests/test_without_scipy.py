"""numpy alone is enough; what needs scipy says so."""

from __future__ import annotations

import subprocess
import sys
import textwrap

PROGRAM = """
    import sys
    sys.modules["scipy"] = None  # as if it were not installed
    import numpy as np
    import fracas

    scene = fracas.Scene.gallery("cycle:small")
    assert scene.solve().converged and next(scene.run()).step == 0
    system = fracas.System(np.diag([2.0, 2.0, 2.0]), np.ones((3, 1)), rhs=np.ones(4))
    assert system.solve().converged and system.spectrum("racp:published").contained is True
    for needs in (lambda: system.A, lambda: system.operator, lambda: system.preconditioner(), system.assembled):
        try:
            needs()
        except fracas.Error as error:
            assert "pip install scipy" in str(error)
        else:
            raise AssertionError("scipy is not there")
"""


def test_numpy_alone_is_enough():
    subprocess.run([sys.executable, "-c", textwrap.dedent(PROGRAM)], check=True)
