"""Save the figures of the gallery."""

from typing import Any

from sphinx_gallery.scrapers import figure_rst


def scraper(_block: object, block_vars: dict[str, Any], gallery_conf: dict[str, Any]) -> str:
    """Save the variable `figure` of an example, and return its reStructuredText.

    Parameters
    ----------
    block_vars : dict
        Variables of the code block, of which `example_globals` and `image_path_iterator` are used.
    gallery_conf : dict
        Configuration of the gallery, of which `src_dir` is used.

    Returns
    -------
    str
        The figure.
    """
    path = next(block_vars["image_path_iterator"])
    block_vars["example_globals"]["figure"].savefig(path, dpi=130)
    return str(figure_rst([path], gallery_conf["src_dir"]))
