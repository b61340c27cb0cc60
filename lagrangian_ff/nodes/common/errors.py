"""The mistakes that come in through topics: counted, warned about, and survived."""

from lagrangian_ff.errors import UserError


class MessageError(UserError):
    """A message that says something impossible: wrong lengths, NaN, unknown joints."""


class RefusedReference(UserError):  # noqa: N818
    """A reference motion that cannot be followed."""
