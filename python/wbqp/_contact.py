"""The class of contacts, made from the framework's JSON Schema."""

from ._plugins import contact as _contact

Contact = _contact()
