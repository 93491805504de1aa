"""Pictures for reports: particles with their true shapes, and fields. Needs `pip install sturz[plots]`."""

from .fields import field_plot
from .picture import picture
from .render import View

__all__ = ["View", "field_plot", "picture"]
