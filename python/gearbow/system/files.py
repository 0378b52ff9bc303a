"""Files of a system: TOML, and rotors of ROSS."""

import os
from typing import TYPE_CHECKING

from gearbow._files import check_name, replacing
from gearbow.description.load_values import refuse_functions
from gearbow.system.description import SystemDescription, warn

if TYPE_CHECKING:
    from typing_extensions import Self

__all__ = ["SystemFiles"]


class SystemFiles(SystemDescription):
    """A system that is read from a file and written to one."""

    @classmethod
    def load(cls, path: str | os.PathLike[str]) -> "Self":
        """Read a system from a TOML file.

        Parameters
        ----------
        path : str or path-like
            A file whose keys are the names of the parameters, as `save` writes it. A value is a
            number in SI units and radians, or a text with a unit, such as "500 mm".

        Returns
        -------
        RotorSystem
            The system.

        Raises
        ------
        SceneError
            If the description is invalid, or the file is not TOML.
        OSError
            If the file cannot be opened.
        """
        from gearbow.system.scene_file import read_scene  # noqa: PLC0415  # with a TOML parser

        model = read_scene(path)
        warn(model)
        return cls._from_model(model)

    @classmethod
    def from_ross(cls, path: str | os.PathLike[str]) -> "Self":
        """Read a rotor that ROSS saved.

        Parameters
        ----------
        path : str or path-like
            A file of ``rotor.save`` of ROSS 2, ``.toml`` or ``.json``.

        Returns
        -------
        RotorSystem
            The rotor, with one element of degree 1 for each element of ROSS. The shaft has the name
            "rotor". A speed-dependent bearing has a `SpeedTable`, which ends at its speeds.

        Raises
        ------
        SceneError
            If the file is not one of ROSS, or has an element that gearbow cannot represent, for
            example a conical shaft element; the message names it.
        OSError
            If the file cannot be opened.

        Notes
        -----
        The axes x, y, z of ROSS are y, z, x here. https://ross.readthedocs.io
        """
        from gearbow.exchange.ross import read_ross  # noqa: PLC0415  # with a TOML parser

        return cls.from_dict(read_ross(path))

    def save(self, path: str | os.PathLike[str]) -> None:
        """Write the description to a TOML file.

        Parameters
        ----------
        path : str or path-like
            The file. Its name ends with ".toml". It contains the sampled points of a bow that is
            given as a function.

        Raises
        ------
        SceneError
            If the name has another ending, or a load is a function of time.
        OSError
            If the file cannot be written. An existing file is unchanged.
        """
        path, _ = check_name(path, [".toml"])
        refuse_functions(torques=self.torques, forces=self.forces)
        text = self._model.to_toml()
        with replacing(path) as file:
            file.write(text.encode())
