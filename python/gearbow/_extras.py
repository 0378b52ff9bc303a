"""Optional libraries that only some functions need."""

import os
from collections.abc import Iterator
from contextlib import contextmanager

from gearbow.errors import MissingExtraError, SceneError

#: Packages that each extra of the distribution installs.
_PACKAGES = {
    "plot": {"matplotlib", "mpl_toolkits", "PIL"},
    "report": {"matplotlib", "mpl_toolkits", "PIL", "plotly", "jinja2"},
    "completion": {"shtab"},
    "netcdf": {"xarray", "h5netcdf", "h5py"},
    "dataframe": {"pandas", "openpyxl"},
    "matlab": {"scipy"},
    "sparse": {"scipy"},
    "identify": {"scipy"},
    "units": {"pint"},
    "fmi": {"pythonfmu3"},
    "sweep": {"xarray", "pandas", "dask", "distributed"},
}


@contextmanager
def extra(name: str) -> Iterator[None]:
    """Report how to install an extra if an import within the block fails."""
    try:
        yield
    except ModuleNotFoundError as error:
        package = (error.name or "").partition(".")[0]
        if package not in _PACKAGES[name]:
            raise
        raise MissingExtraError(
            f'{package}: is not installed; install it with: pip install "gearbow[{name}]"',
            name=error.name,
        ) from error
    except ValueError as error:
        given = os.environ.get("MPLBACKEND")
        if given is None or given not in str(error):
            raise
        raise SceneError(
            f"MPLBACKEND: {given!r} is no backend of matplotlib; remove this environment variable, "
            "gearbow needs none"
        ) from error
