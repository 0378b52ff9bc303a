"""The error of a run: contributions of elements, modes and integration."""

from collections.abc import Mapping
from dataclasses import asdict, dataclass
from typing import Any

from gearbow._shown import Shown
from gearbow._types import Plain


@dataclass(frozen=True)
class ErrorEstimate(Shown):
    """Error of one kind of signal: RMS of the difference / RMS of the signal about its mean."""

    elements: float
    modes: float
    integration: float
    total: float


class Errors(dict[str, ErrorEstimate]):
    """Estimated errors of a run by the kind of signal."""

    def __init__(
        self, estimates: Mapping[str, ErrorEstimate], *, window: float, chaotic: bool
    ) -> None:
        super().__init__(estimates)
        self.window = window
        self.chaotic = chaotic

    def __reduce__(self) -> tuple[Any, ...]:
        return _made, (dict(self), self.window, self.chaotic)

    def __str__(self) -> str:
        lines = [
            f"{kind}: {each.total:.1e} (elements {each.elements:.1e}, modes {each.modes:.1e}, "
            f"integration {each.integration:.1e})"
            for kind, each in self.items()
        ]
        lines.append(f"over the first {self.window:g} s")
        if self.chaotic:
            lines.append(
                "chaotic contact: small differences grow to the size of the signals, so that no "
                "run predicts the time history after the first impacts"
            )
        return "\n".join(lines)

    def plain(self) -> dict[str, Plain]:
        """Convert to data that JSON can hold."""
        estimates = {kind: asdict(each) for kind, each in self.items()}
        return {"window": self.window, "chaotic": self.chaotic, "estimates": estimates}

    @classmethod
    def from_plain(cls, given: Mapping[str, Plain] | None) -> "Errors | None":
        """Read the data of `plain`."""
        if given is None:
            return None
        estimates = {kind: ErrorEstimate(**each) for kind, each in given["estimates"].items()}
        return _made(estimates, given["window"], given["chaotic"])


def _made(estimates: Mapping[str, ErrorEstimate], window: float, chaotic: bool) -> Errors:
    return Errors(estimates, window=window, chaotic=chaotic)
