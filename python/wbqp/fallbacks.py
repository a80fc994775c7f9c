"""Fallback laws.

Made from the registry: one class for each plug-in, with its keys as keyword arguments.
"""

from ._plugins import classes as _classes

globals().update(_classes("fallbacks"))
__all__ = [name for name in dir() if name[0].isupper()]
