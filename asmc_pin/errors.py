"""Errors the package raises: one root, and leaves that carry the data they speak of.

Every message says what was given, what was expected and how to correct it. The command line prints the message of any
`AsmcPinError` without a traceback and exits with status 2.
"""

from __future__ import annotations

from pathlib import Path

from asmc_pin.words.text import message_text


class AsmcPinError(Exception):
    """Root of every error that a user of the package can correct.

    Its message often quotes a file, so control characters in it are escaped, all but line breaks.
    """

    def __init__(self, message: str = "") -> None:
        super().__init__(message_text(message))


class ParameterError(AsmcPinError, ValueError):
    """A parameter has a wrong size, sign or value.

    Attributes:
        parameter: Name of the offending parameter.
        said: What is wrong with it, without its name.
    """

    def __init__(self, parameter: str, message: str) -> None:
        super().__init__(f"{parameter}: {message}")
        self.parameter = parameter
        self.said = message_text(message)


class ArmError(AsmcPinError):
    """A URDF cannot be used as an arm.

    Attributes:
        source: The name or path that was given.
    """

    def __init__(self, source: str | Path, message: str) -> None:
        super().__init__(message)
        self.source = str(source)


class NotPositiveDefinite(AsmcPinError):
    """A mass matrix is not positive definite.

    Attributes:
        index: Index of the first such matrix among the leading axes.
        smallest_eigenvalue: Its smallest eigenvalue, kg·m².
    """

    def __init__(self, index: tuple[int, ...], smallest_eigenvalue: float, message: str | None = None) -> None:
        super().__init__(
            message
            or f"the mass matrix at index {index} is not positive definite (smallest eigenvalue "
            f"{smallest_eigenvalue:.3g}); check the inertias of the arm, or add armature"
        )
        self.index = index
        self.smallest_eigenvalue = smallest_eigenvalue


class ExperimentError(AsmcPinError):
    """An experiment file is malformed.

    Attributes:
        key: Path of the offending key, such as ``controllers.PPC.beta``; empty where the TOML itself is broken.
        said: What is wrong with it, without its path.
    """

    def __init__(self, key: str, message: str) -> None:
        super().__init__(f"{key}: {message}" if key else message)
        self.key = key
        self.said = message_text(message)


class ResultError(AsmcPinError):
    """A result folder is missing, incomplete, or would be overwritten.

    Attributes:
        path: The folder.
    """

    def __init__(self, path: str | Path, message: str) -> None:
        super().__init__(message)
        self.path = str(path)


class MissingDependencyError(AsmcPinError):
    """A package that only some users need is not installed.

    Attributes:
        package: Its name.
        extra: The extra of this package that brings it.
    """

    def __init__(self, package: str, extra: str, purpose: str) -> None:
        super().__init__(
            f"{package} is not installed ({purpose}); install it with: pip install 'asmc-pin[{extra}]', "
            f"or pip install {package}"
        )
        self.package = package
        self.extra = extra


class NotComparableError(AsmcPinError):
    """An independent engine refuses a URDF that this package takes.

    Attributes:
        source: The URDF.
    """

    def __init__(self, source: str | Path, message: str) -> None:
        super().__init__(message)
        self.source = str(source)
